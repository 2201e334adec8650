"""The terrain filter on live measurements, one tick at a time, with one n for both axles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.sampling import STEP
from softsoil.estimator.terrain import ForceError, Jumps, SoilChange, Tuning, terrain_model
from softsoil.estimator.ukf import UnscentedKalmanFilter
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]

LOOP_TUNING = Tuning(force_error=(0.0, 0.0), n_walk=0.01, n_std=0.5, patience=12)
"""The filter's numbers in the loop. Plans keep away from the full lock where the force law errs most, so that its error
need not grow with the force; n may be far off at first and change underway, with a manoeuvre waiting for neither; and a
vehicle that is believed 14 m away brakes or swerves, so that a burst of outliers must not pass for a jump."""
FIRST_SPREAD = (0.3, 0.3, 0.01, 0.1, 0.1, 0.02)
"""Standard deviations of a first state that is known: x, y, psi, u, v, omega_z, SI units."""


class LiveEstimator:
    """The parts of `estimate_terrain`, step by step.

    model: bicycle with its effects; std (6,): of the sensors of x, y, psi, u, v, omega_z; tuning: numbers of the filter;
    tick: prediction step (s). `start` begins a drive; the compiled filter is kept.
    """

    def __init__(self, model: Model, std: ArrayLike, tuning: Tuning | None = None, tick: float = STEP) -> None:
        self.tuning, self.tick_length = tuning or LOOP_TUNING, tick
        self.std = np.asarray(std, dtype=float)
        self.augmented = terrain_model(model, tied=True)
        self._n_at = self.augmented.x.index("n")
        self._kept = np.array([i for i in range(len(self.augmented.x)) if i != self._n_at])
        self._names = self.augmented.external.names
        self._walks = np.array([name == "n" for name in self.augmented.x.names[6:]])
        size = len(self.augmented.x)
        self.filter = UnscentedKalmanFilter(
            self.augmented, tick, q=np.ones(size), r=self.std**2, x0=self.augmented.x.nominal, p0=np.ones(size),
            gate=self.tuning.gate,
        )  # fmt: skip
        self.learn = True
        self.start(self.augmented.x.nominal[:6], float(self.augmented.x.nominal[self._n_at]), True)

    def start(self, x0: ArrayLike, n0: float, learn: bool, spread: ArrayLike = FIRST_SPREAD) -> None:
        """Begin a drive at x0 (6,) with the first guess n0; learn: whether n is estimated or stays what `set_n` sets;
        spread (6,): standard deviations of x0.
        """
        tuning, self.learn = self.tuning, learn
        first = np.concatenate([np.asarray(x0, dtype=float), self.augmented.x.nominal[6:]])
        first[self._n_at] = n0
        n_spread = np.where(self._walks, tuning.n_std if learn else 0.0, 1e-2)
        walk = np.where(self._walks, tuning.n_walk if learn else 0.0, 1e-4)
        q = np.concatenate([tuning.model_error, walk]) ** 2 * self.tick_length
        self.filter.set_process_variance(range(len(q)), q)
        self.filter.restart(first, np.concatenate([np.asarray(spread, dtype=float), n_spread]) ** 2)
        self._noise = ForceError(self.augmented, tuning, self.tick_length)
        self._jumps = Jumps(tuning.patience)
        lookback = max(round(tuning.change_after / (self.tick_length * tuning.update_every)), 1)
        self._soil = SoilChange(tuning, [self._n_at], lookback)
        self._count, self._sound = 0, n0

    def set_n(self, n: float) -> None:
        """Set n of a filter that does not learn."""
        if not self.learn:
            x = self.filter.x
            x[self._n_at] = n
            self.filter.x = x

    def tick(self, inputs: Mapping[str, float], y: Array) -> None:
        """Predict over one tick with the inputs by name, update with y (6,) every second one; NaN where none was measured."""
        self._noise.apply(self.filter)
        self.filter.predict(np.array([inputs[name] for name in self._names]))
        self._count += 1
        if self._count % self.tuning.update_every == 0:
            near = y.copy()
            near[2] += 2 * np.pi * np.round((self.filter["psi"] - y[2]) / (2 * np.pi))
            seen = self.filter.update(near)
            if seen.dof < len(seen.used) or self._jumps.waiting:
                self._jumps.see(self.filter, seen, near)
            if self.learn:
                self._soil.see(self.filter)
            self._keep(y)

    def _keep(self, y: Array) -> None:
        """Remember a sound n; a filter that has broken down (near standstill) starts again where it is measured."""
        if np.isfinite(self.filter.x).all():
            self._sound = self.n
        elif np.isfinite(y).all():
            self.start(y, self._sound, self.learn)

    @property
    def n(self) -> float:
        """Estimate of n."""
        return self.filter.at(self._n_at)

    @property
    def n_std(self) -> float:
        """Its standard deviation."""
        return float(np.sqrt(self.filter.variance[self._n_at]))

    @property
    def states(self) -> Array:
        """(n_x,) states of the model, n left out."""
        return self.filter.x[self._kept]

    @property
    def gated(self) -> int:
        """Measurements left out because they were outside the gate."""
        return sum(self.filter.counts.gated.values())
