"""The sensors of the closed loop: the paper's noise on what the plant measures, and what goes wrong with them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.sampling import STEP
from softsoil.plant.world import Sample
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.noise import TABLE5

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


@dataclass
class NoisySensors:
    """The six measured states with Table-5 noise; wheel speeds, steering and accelerometer are taken as read.

    seed: of the noise; faults: see Faults. `read` gives (6,) values, NaN where there is none.
    """

    seed: int
    faults: Faults = field(default_factory=Faults)

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self.std = np.array([TABLE5[name] for name in STATE_CHANNELS])

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
