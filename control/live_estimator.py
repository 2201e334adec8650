"""The terrain filter on live measurements, one tick at a time, with one n for both axles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.sampling import STEP
from softsoil.estimator.terrain import terrain_model
from softsoil.estimator.terrain_filter import FilterStatus, TerrainFilter, first_state
from softsoil.estimator.tuning import Tuning
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]

SEEN = ("x", "y", "u", "v")
"""Measurements of position and velocity."""
FIRST_SPREAD = (0.3, 0.3, 0.01, 0.1, 0.1, 0.02)
"""Standard deviations of a first state that is known: x, y, psi, u, v, omega_z, SI units."""


class LiveEstimator:
    """The filter of `estimate_terrain`, step by step.

    model: bicycle with its effects; std (6,): of the sensors of x, y, psi, u, v, omega_z; tuning: numbers of the filter;
    tick: prediction step (s). `start` begins a drive; the compiled filter is kept. `corrected`: whether the last tick used a
    measurement of position or velocity (`SEEN`).
    """

    def __init__(self, model: Model, std: ArrayLike, tuning: Tuning | None = None, tick: float = STEP) -> None:
        self.augmented = terrain_model(model, tied=True)
        self.terrain = TerrainFilter(self.augmented, tick, std, tuning)
        self.tuning, self.filter = self.terrain.tuning, self.terrain.ukf
        self._n_at = self.augmented.x.index("n")
        self._place = [self.augmented.x.index(name) for name in ("x", "y")]
        self._seen = [self.augmented.y.index(name) for name in SEEN]
        self._kept = np.array([i for i in range(len(self.augmented.x)) if i != self._n_at])
        self._names = self.augmented.external.names
        self.start(self.augmented.x.nominal[:6], float(self.augmented.x.nominal[self._n_at]), True)

    def start(self, x0: ArrayLike, n0: float, learn: bool, spread: ArrayLike = FIRST_SPREAD) -> None:
        """Begin a drive at x0 (6,) with the first guess n0; learn: whether n is estimated or stays what `set_n` sets;
        spread (6,): standard deviations of x0.
        """
        first = first_state(self.augmented, np.asarray(x0, dtype=float), n0)
        std0 = self.tuning.std0(self.augmented.x, np.asarray(spread, dtype=float))
        self.terrain.start(first, std0, learn=learn)
        self._count, self.corrected, self.updated = 0, False, False

    def set_n(self, n: float) -> None:
        """Set n of a filter that does not learn."""
        self.terrain.set_n(n)

    def tick(self, inputs: Mapping[str, float], y: Array) -> None:
        """Predict over one tick with the inputs by name, update with y (6,); NaN where none was measured.

        Of every `update_every` ticks of the tuning the last one updates (`updated`); a caller keeps what another one measured.
        """
        self.terrain.predict(np.array([inputs[name] for name in self._names]))
        self._count += 1
        self.corrected, self.updated = False, self._count % self.tuning.update_every == 0
        if self.updated:
            used = self.terrain.update(y).used
            self.corrected = bool(used[self._seen].any()) and not self.status.refused

    @property
    def status(self) -> FilterStatus:
        """What the filter's rules did in the last prediction and update."""
        return self.terrain.status

    @property
    def position_std(self) -> float:
        """Root of the sum of the variances of x and y (m)."""
        return float(np.sqrt(self.filter.variance[self._place].sum()))

    @property
    def n(self) -> float:
        """Estimate of n."""
        return self.filter.at(self._n_at)

    @property
    def n_std(self) -> float:
        """Its standard deviation."""
        return float(self.terrain.n_std[0])

    @property
    def states(self) -> Array:
        """(n_x,) states of the model, n left out."""
        return self.filter.x[self._kept]

    @property
    def gated(self) -> int:
        """Measurements left out because they were outside the gate."""
        return sum(self.filter.counts.gated.values())
