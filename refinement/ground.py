"""Friction and tread of hard ground, as a refinement gives them: values, standard errors, verdicts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.evidence import percent_above
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.refinement.fit import Fit
from softsoil.symbolic.soil import Soil
from softsoil.windows.parameters import Free

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GroundNumber:
    """A number of a class of hard ground.

    name: "friction", the coefficient tan(phi), or "tread", the length that it shears by before it slides (m); unit; before: with
    the declared model; value, std: with the refined one; word, reason: verdict, of those on n, and why.
    """

    name: str
    unit: str
    before: float
    value: float
    std: float
    word: str
    reason: str

    def as_json(self) -> dict[str, Any]:
        """Its entry in refine.json."""
        return {"before": self.before, "value": self.value, "std": self.std, "unit": self.unit, "verdict": self.word,
                "reason": self.reason}  # fmt: skip


@dataclass(frozen=True)
class FittedGround:
    """A class of hard ground: its name, names of the drives on it, friction and tread."""

    name: str
    drives: tuple[str, ...]
    numbers: tuple[GroundNumber, ...]

    def as_json(self) -> dict[str, Any]:
        """Its entry in refine.json."""
        return {"name": self.name, "drives": list(self.drives), **{n.name: n.as_json() for n in self.numbers}}


def fitted_ground(
    free: Sequence[Free],
    soils: Sequence[Soil],
    drives: Sequence[str],
    before: Array,
    last: Fit,
    left: Sequence[bool],
    error: float,
) -> tuple[FittedGround, ...]:
    """Each class of hard ground with what the declared and the refined model say of it.

    free: the ground's; before (K,): their values with the declared model; last: fit of the refined one; soils, drives: class and
    name of each drive; left: whether the model leaves too much of its axle forces; error: share of a number by which law and
    vehicle are wrong in all drives alike.
    """
    found = []
    for angle, tread, (first, shear) in zip(free[::2], free[1::2], before.reshape(-1, 2), strict=True):
        mine = range(len(soils)) if angle.drive is None else angle.drives
        doubt = any(left[i] for i in mine)
        (phi, phi_std), (k, k_std) = (last.named()[f.name] for f in (angle, tread))
        friction = math.tan(phi), phi_std / math.cos(phi) ** 2
        words = _judged(angle, phi, *friction, error, doubt), _judged(tread, k, k, k_std, error, doubt)
        numbers = (
            GroundNumber("friction", "", math.tan(first), *_with(*friction, error), *words[0]),
            GroundNumber("tread", "m", float(shear), *_with(k, k_std, error), *words[1]),
        )
        found.append(FittedGround(soils[mine[0]].name, tuple(drives[i] for i in mine), numbers))
    return tuple(found)


def _with(value: float, std: float, error: float) -> tuple[float, float]:
    """The value with its standard deviation by the drives and by an `error` that is common to them, a share of it."""
    return value, math.hypot(std, error * value)


def _judged(free: Free, value: float, shown: float, std: float, error: float, left: bool) -> tuple[str, str]:
    """Verdict on a number of the ground that ends at `value`, and its reason; shown: as it is printed; std: by the drives alone;
    error: share by law and vehicle."""
    limit, share = VerdictRules().excited, std / max(abs(shown), 1e-12)
    if free.at_bound(value):
        return "at_bound", f"ends at {shown:.3g}, a bound of its range: the drives do not show it"
    if left:
        return "inconsistent", "more is left of the axle forces than a right model leaves"
    if not share <= limit:
        only = f"the drives determine it to ± {percent_above(share, limit)} % only (limit {100 * limit:.0f} %)"
        return "not_excited", f"{only}: turn harder"
    whole = f"± {100 * math.hypot(share, error):.0f} % with errors of law and vehicle"
    return "identified", f"the drives determine it to ± {100 * share:.0f} % ({whole})"
