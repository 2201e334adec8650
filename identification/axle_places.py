"""Where the axles are, before any fit: l_f by motion against the given one, and what that makes of l_r."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softsoil.checking.geometry_check import Measured, front_axle
from softsoil.identification.result import Contradiction
from softsoil.identification.rules import Rules
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import expected
from softsoil.refinement.words import with_error

Values = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class AxlePlaces:
    """What motion says of the axles' places.

    contradictions: of l_f, one at most; values: l_f and l_r (m) that fits start from, none where they stand as given; left: l_f
    or l_r -> (value, standard deviation) (m) within which fits are to find it; note: what the logs say of l_f.
    """

    contradictions: tuple[Contradiction, ...]
    values: Mapping[str, float]
    left: Mapping[str, tuple[float, float]]
    note: str


def axle_places(recordings: Sequence[Recording], known: Known, rules: Rules) -> AxlePlaces:
    """l_f against position and course of all `recordings`, the one that judges among them: no force law and no n are in it.

    Where it is contradicted, l_r is between two values: a wrong wheelbase leaves the axle loads, thus l_r/l_f, and wrong axle
    loads leave the wheelbase, thus l_f + l_r. Where it is not, and `known` states an uncertainty of one of them, fits find it
    within that; l_f within what tape and motion say together.
    """
    before = expected(known)
    (given, std), behind = before["l_f"], before["l_r"]
    left: Values = {name: before[name] for name in ("l_f", "l_r") if name in known.stated}
    place = front_axle(recordings)
    if place is None:
        return AxlePlaces((), {}, left, _not_seen(recordings))
    own = float(np.hypot(place.std, std))
    sigmas = float(abs(place.value - given) / own)
    note = (
        f"l_f: given as {given:.3f} m, {with_error(place.value, place.std)} m by position against course ({sigmas:.1f} standard "
        f"deviations); these logs contradict one that is {1e3 * rules.contradicted_motion * own:.0f} mm off"
    )
    if sigmas < rules.contradicted_motion or abs(place.value - given) < rules.material * known.wheelbase:
        left |= {"l_f": _both(place, given, std)} if "l_f" in left else {}
        return AxlePlaces((), {name: value for name, (value, _) in left.items()}, left, note)
    by_loads, by_wheelbase = behind[0] * place.value / given, known.wheelbase - place.value
    between = (0.5 * (by_loads + by_wheelbase), 0.5 * abs(by_loads - by_wheelbase))
    found = Contradiction("l_f", given, place.value, place.std, sigmas, "position against course")
    return AxlePlaces((found,), {"l_f": place.value, "l_r": between[0]}, {"l_r": between}, note)


def _both(place: Measured, given: float, std: float) -> tuple[float, float]:
    """l_f by tape and motion together, and its standard deviation (m)."""
    tape, motion = std**-2, place.std**-2
    return (tape * given + motion * place.value) / (tape + motion), float((tape + motion) ** -0.5)


def _not_seen(recordings: Sequence[Recording]) -> str:
    lacking = [name for name in STATE_CHANNELS if not any(one.measured(name) for one in recordings)]
    why = f"do not measure {', '.join(lacking)}" if lacking else "turn too little, or in stretches too short,"
    return f"l_f: the logs {why}, and do not say where the front axle is"
