"""The sensors of the closed loop: the paper's noise on what the plant measures, and what goes wrong with them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.sampling import STEP
from softsoil.plant.world import Sample
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.noise import GOOD, TABLE5

Array = NDArray[np.float64]

TICK = STEP
"""s: between sensor readings, and the estimator's prediction step."""


@dataclass(frozen=True)
class Faults:
    """What goes wrong with the sensors: `dropout` (from, to) s without any of the six states; `burst` (from, to) s in which
    every third measurement of each state jumps by 12 standard deviations.
    """

    dropout: tuple[float, float] | None = None
    burst: tuple[float, float] | None = None

    def stretched(self, factor: float) -> Faults:
        """The same faults, every time multiplied by `factor`."""
        spans = (None if span is None else (factor * span[0], factor * span[1]) for span in (self.dropout, self.burst))
        return Faults(*spans)

    def later(self, seconds: float) -> Faults:
        """The same faults, every one so much later (s)."""
        spans = (None if span is None else (span[0] + seconds, span[1] + seconds) for span in (self.dropout, self.burst))
        return Faults(*spans)


SENSORS = ("states", "all")
"""Noisy sensors: the six states with the noise of the paper's Table 5, or `all`: wheel speeds, accelerometer and steering angle
too, with the noise of a good sensor (`GOOD`)."""
OTHERS = (*WHEEL_CHANNELS, "a_x_imu", "steer")
"""Channels beside the states."""


@dataclass
class NoisySensors:
    """The sensors of a drive, with noise and faults.

    seed: of the noise; faults: see Faults; noisy: of SENSORS. With "states" wheel speeds and accelerometer are exact and the
    steering angle is the commanded one. Raises ValueError for another set of sensors.
    """

    seed: int
    faults: Faults = field(default_factory=Faults)
    noisy: str = "states"

    def __post_init__(self) -> None:
        if self.noisy not in SENSORS:
            raise ValueError(f"sensors: expected one of {', '.join(SENSORS)}; found {self.noisy!r}")
        self._rng = np.random.default_rng(self.seed)
        self._other_rng = np.random.default_rng([self.seed, 1])
        self.std = np.array([TABLE5[name] for name in STATE_CHANNELS])
        self.other_std = np.array([GOOD[name] for name in OTHERS])

    def measure(self, t: float, sample: Sample) -> dict[str, float]:
        """Every measurement at t (s) by name, as `Driver.tick` takes it."""
        measured = dict(zip(STATE_CHANNELS, self.read(t, sample).tolist(), strict=True))
        exact = np.array([sample[name] for name in OTHERS])
        if self.noisy == "all":
            noisy = exact + self.other_std * self._other_rng.standard_normal(len(OTHERS))
            return measured | dict(zip(OTHERS, noisy.tolist(), strict=True))
        return measured | dict(zip(OTHERS[:-1], exact[:-1].tolist(), strict=True))

    def read(self, t: float, sample: Sample) -> Array:
        """(6,) x, y, psi, u, v, omega_z as measured at t (s)."""
        y = np.array([sample[name] for name in STATE_CHANNELS]) + self.std * self._rng.standard_normal(6)
        jump = self._rng.random(6) < 1.0 / 3.0
        sign = self._rng.choice([-1.0, 1.0], 6)
        if self.faults.burst and self.faults.burst[0] <= t < self.faults.burst[1]:
            y = np.where(jump, y + 12.0 * sign * self.std, y)
        if self.faults.dropout and self.faults.dropout[0] <= t < self.faults.dropout[1]:
            y[:] = np.nan
        return y
