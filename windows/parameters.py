"""Free numbers of a fit: which model parameters each sets, with scale, bounds and prior knowledge."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Free:
    """One free number: the model parameters it sets (more than one where they are tied), scale, bounds.

    drive: index of the one drive whose parameters it sets, or several; None for all: the soil is each drive's own, an effect
    is common;
    known: value and standard deviation that are known beforehand, None for nothing.
    """

    name: str
    sets: tuple[str, ...]
    scale: float
    lower: float
    upper: float
    drive: int | tuple[int, ...] | None = None
    known: tuple[float, float] | None = None

    @property
    def drives(self) -> tuple[int, ...]:
        """Indices of the drives whose parameters it sets; of the first where it sets those of all."""
        return self.drive if isinstance(self.drive, tuple) else (self.drive or 0,)

    def at_bound(self, value: float) -> bool:
        """Whether `value` lies on one of the bounds."""
        span = self.upper - self.lower
        near = 1e-6 * max(span if math.isfinite(span) else self.scale, 1e-9)
        return value <= self.lower + near or value >= self.upper - near
