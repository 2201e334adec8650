"""What was measured between the steps of a driver's filter, and how many steps a call is due."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from softsoil.control.driver_types import Measured
from softsoil.recording.drive import STATE_CHANNELS

TOGETHER = 0.5
"""s within which the measurements of a first state have to come."""


class Inbox:
    """Calls come when they come; the filter takes steps of `tick`, s. What is measured waits for the next step."""

    def __init__(self, tick: float) -> None:
        self.tick, self.at = tick, math.nan
        self._waiting: dict[str, float] = {}
        self._seen: dict[str, tuple[float, float]] = {}

    def emptied(self) -> Inbox:
        """One of the same tick in which nothing is."""
        return Inbox(self.tick)

    def take(self, t: float, measured: Measured) -> dict[str, float]:
        """What was measured since the last step, at t (s) the last of each; values that are not finite are none."""
        for name, value in measured.items():
            if value is not None and math.isfinite(value):
                self._waiting[name] = float(value)
                self._seen[name] = (t, float(value))
        return dict(self._waiting)

    def steps(self, t: float) -> int:
        """Steps of the filter until t (s), to the nearest; with one or more, nothing waits any longer."""
        count = max(math.floor((t - self.at) / self.tick + 0.5), 0)
        self.at += count * self.tick
        if count:
            self._waiting.clear()
        return count

    def begin(self, t: float) -> None:
        """The filter stands at t (s)."""
        self.at = t
        self._waiting.clear()

    def recent(self, t: float) -> dict[str, float]:
        """The last of every measurement that is at most `TOGETHER` old at t (s)."""
        return {name: value for name, (when, value) in self._seen.items() if t - when <= TOGETHER}

    def age(self, t: float, name: str) -> float:
        """Time from the last measurement of that name until t (s)."""
        return t - self._seen[name][0]


def given(measured: Measured, name: str, default: float) -> float:
    """A measurement that is there and finite, else the default."""
    value = measured.get(name)
    return default if value is None or not math.isfinite(value) else float(value)


def as_states(measured: Measured) -> NDArray[np.float64]:
    """(6,) x, y, psi, u, v, omega_z as measured, NaN for what is not there."""
    return np.array([given(measured, name, math.nan) for name in STATE_CHANNELS])
