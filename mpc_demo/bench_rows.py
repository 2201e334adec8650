"""A speed figure: a time, what it is set against, and the ratio, both measured in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

REPEATS = 11
BLOCK = 0.05
"""s of each block."""


@dataclass(frozen=True)
class Row:
    """One row of bench.json.

    name; value, unit; against: what it is set against; against_value: in the same unit, None where there is nothing;
    paper: what the paper says of its own, for the eye only.
    """

    name: str
    value: float
    unit: str
    against: str
    against_value: float | None
    paper: str = ""

    @property
    def ratio(self) -> float | None:
        """How many times the other takes."""
        return None if self.against_value is None else self.against_value / self.value

    def as_json(self) -> dict[str, Any]:
        """The entry of bench.json."""
        names = ("name", "value", "unit", "against", "against_value", "ratio")
        return {name: getattr(self, name) for name in names}


def microseconds(*calls: Callable[[], object]) -> list[float]:
    """Time of one call of each function (us): the best of REPEATS blocks of about BLOCK seconds, blocks taking turns.

    The best block is the one that other work on the machine disturbed least; taking turns treats all alike.
    """
    counts = [max(3, int(BLOCK / max(seconds(call), seconds(call), 1e-7))) for call in calls]
    blocks = np.empty((REPEATS, len(calls)))
    for repeat in range(REPEATS):
        for i, (call, count) in enumerate(zip(calls, counts, strict=True)):
            began = time.perf_counter()
            for _ in range(count):
                call()
            blocks[repeat, i] = (time.perf_counter() - began) / count * 1e6
    return [float(value) for value in blocks.min(axis=0)]


def seconds(call: Callable[[], object]) -> float:
    """Time of one call (s)."""
    began = time.perf_counter()
    call()
    return time.perf_counter() - began
