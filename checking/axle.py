"""Whether positions are those of the front axle, by how they turn with the vehicle."""

from __future__ import annotations

from softsoil.checking.geometry_check import front_axle
from softsoil.checking.words import LIMITS, Check
from softsoil.recording.drive import Recording
from softsoil.recording.geometry import Geometry

NAME = "front_axle_place"
LEAST = 0.04
"""Of the wheelbase, by which a place is doubted at least (`python -m benchmarks.identify_contradictions --place 24` prints how
far off right ones come out)."""


def axle_checks(recording: Recording, geometry: Geometry) -> list[Check]:
    """The place of the positions ahead of the centre of gravity, by `front_axle`, against l_f of the vehicle's file.

    None where the drive hardly turns or lacks a state.
    """
    place = front_axle([recording])
    if place is None:
        return []
    off = place.value - geometry.l_f
    wrong = abs(off) > max(LIMITS.sigmas * place.std, LEAST * (geometry.l_f + geometry.l_r))
    cure = (
        f"the antenna is {abs(off):.2f} m farther {'ahead' if off > 0 else 'back'} than its [mount] says, or l_f and l_r of the "
        "vehicle's file are not its own"
    )
    found = f"a point {place.value:.2f} ± {place.std:.2f} m ahead of it, by position against course"
    expected = f"positions of the front axle, {geometry.l_f:.2f} m ahead of the centre of gravity"
    return [Check(NAME, "x, y", not wrong, found, expected, cure if wrong else "")]
