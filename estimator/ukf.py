"""The unscented Kalman filter on any Model, its steps running as generated C."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimator.compiled import CompiledFunction
from estimator.unscented import UnscentedScaling, predict_function, update_function
from symbolic.discretize import advance_memory, discretize, read_memory, start_memory
from symbolic.model import Model

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Innovation:
    """What one update saw.

    value (n_y,): y - y_mean; covariance (n_y, n_y): S; nis: normalised innovation squared over the `used` measurements;
    used (n_y,) bool: measurements that were valid and inside the gate.
    """

    value: Array
    covariance: Array
    nis: float
    used: NDArray[np.bool_]

    @property
    def dof(self) -> int:
        """Measurements used: the degrees of freedom of nis."""
        return int(self.used.sum())


@dataclass
class Counts:
    """How often a measurement was left out, by reason, and an input was held."""

    invalid: dict[str, int] = field(default_factory=dict)
    gated: dict[str, int] = field(default_factory=dict)
    held_inputs: dict[str, int] = field(default_factory=dict)


class UnscentedKalmanFilter:
    """Unscented Kalman filter (paper, section IV) with additive noise on a model's one-step map.

    model: its states are estimated, its outputs measured; dt: prediction step (s);
    q: (n_x,) variances or (n_x, n_x) covariance added at each prediction; r: (n_y,) or (n_y, n_y) of a measurement;
    x0 (n_x,), p0: (n_x,) variances or (n_x, n_x) covariance of the first state; p (n_p,): parameters, default nominal;
    gate: largest innovation in standard deviations; method, substeps: of `discretize`.
    Raises ValueError for a shape that does not fit, q or p0 that is not positive semidefinite, r that is not positive
    definite.
    """

    def __init__(
        self,
        model: Model,
        dt: float,
        *,
        q: ArrayLike,
        r: ArrayLike,
        x0: ArrayLike,
        p0: ArrayLike,
        p: ArrayLike | None = None,
        gate: float = np.inf,
        scaling: UnscentedScaling | None = None,
        method: str = "euler",
        substeps: int = 1,
        compiled: bool = True,
    ) -> None:
        scaling = scaling or UnscentedScaling()
        n_x, n_y = len(model.x), len(model.y)
        self.model, self.dt = model, dt
        self.p = model.p.nominal if p is None else _vector(p, len(model.p), "p")
        self.gate = gate
        self.counts = Counts()
        self._q = _covariance(q, n_x, "q", definite=False)
        self._r = _covariance(r, n_y, "r", definite=True)
        self.x = _vector(x0, n_x, "x0")
        self.P = _covariance(p0, n_x, "p0", definite=False)
        step = discretize(model, dt, method, substeps)
        self._predict = CompiledFunction(predict_function(step, model.x, scaling), compiled)
        self._update = CompiledFunction(update_function(model.measurement(), model.x, model.y, scaling), compiled)
        self._u = np.zeros(len(model.u))
        self._last_external = model.external.nominal
        self.memory: Array | None = None
        if model.memories:
            self._read = CompiledFunction(read_memory(model), compiled)
            self._advance = CompiledFunction(advance_memory(model, dt), compiled)
            self._start = CompiledFunction(start_memory(model), compiled)

    def predict(self, u: ArrayLike) -> None:
        """Time update over dt with the external inputs u (n_external,) held; a non-finite input keeps its last value."""
        u_full = self._full_input(u)
        into = self._predict.inputs
        into[0][:, 0], into[1][...], into[2][:, 0], into[3][:, 0], into[4][...] = (
            self.x,
            self.P,
            u_full,
            self.p,
            self._q,
        )
        self._predict.run()
        x_before = self.x
        self.x, self.P = self._predict.outputs[0][:, 0].copy(), self._predict.outputs[1].copy()
        if self.memory is not None:
            self.memory = np.asarray(self._advance(x_before, u_full, self.p, self.memory))

    def update(self, y: ArrayLike, valid: ArrayLike | None = None) -> Innovation:
        """Measurement update with y (n_y,); entries that are not finite or not `valid` (n_y,) bool are skipped, counted."""
        y = _vector(y, len(self.model.y), "y")
        usable = np.isfinite(y) & (True if valid is None else np.asarray(valid, dtype=bool))
        into = self._update.inputs
        into[0][:, 0], into[1][...], into[2][:, 0], into[3][:, 0] = self.x, self.P, self._u, self.p
        into[4][:, 0], into[5][:, 0], into[6][...] = np.where(usable, y, 0.0), usable, self._r
        into[7][0, 0] = min(self.gate, 1e150)
        self._update.run()
        x, cov, value, s, nis, used = self._update.outputs
        self.x, self.P = x[:, 0].copy(), cov.copy()
        used_flags = used[:, 0] > 0.5
        self._count(usable, used_flags)
        return Innovation(value[:, 0].copy(), s.copy(), float(nis[0, 0]), used_flags)

    def std(self, name: str) -> float:
        """Standard deviation of the named state."""
        return float(np.sqrt(self.P[self.model.x.index(name), self.model.x.index(name)]))

    def __getitem__(self, name: str) -> float:
        """Estimate of the named state."""
        return float(self.x[self.model.x.index(name)])

    def _full_input(self, u: ArrayLike) -> Array:
        external = _vector(u, len(self.model.external), "u")
        bad = ~np.isfinite(external)
        if bad.any():
            for i in np.flatnonzero(bad):
                name = self.model.external.names[i]
                self.counts.held_inputs[name] = self.counts.held_inputs.get(name, 0) + 1
            external = np.where(bad, self._last_external, external)
        self._last_external = external
        if not self.model.memories:
            self._u = external
            return external
        if self.memory is None:
            self.memory = np.asarray(self._start(self.x, external, self.p))
        self._u = np.asarray(self._read(self.x, external, self.p, self.memory))
        return self._u

    def _count(self, usable: NDArray[np.bool_], used: NDArray[np.bool_]) -> None:
        for i, name in enumerate(self.model.y.names):
            if not usable[i]:
                self.counts.invalid[name] = self.counts.invalid.get(name, 0) + 1
            elif not used[i]:
                self.counts.gated[name] = self.counts.gated.get(name, 0) + 1


def _vector(value: ArrayLike, size: int, name: str) -> Array:
    vector = np.array(value, dtype=float)
    if vector.shape != (size,):
        raise ValueError(f"{name}: expected shape ({size},), found {vector.shape}")
    return vector


def _covariance(value: ArrayLike, size: int, name: str, definite: bool) -> Array:
    matrix = np.array(value, dtype=float)
    if matrix.shape == (size,):
        matrix = np.diag(matrix)
    if matrix.shape != (size, size):
        raise ValueError(f"{name}: expected shape ({size},) or ({size}, {size}), found {matrix.shape}")
    if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
        raise ValueError(f"{name}: expected a symmetric matrix")
    least = float(np.linalg.eigvalsh(matrix).min()) if np.isfinite(matrix).all() else np.nan
    # Rounding of eigvalsh is about 1e-16 of the largest entry.
    if not (least > 0 if definite else least >= -1e-12 * np.abs(matrix).max(initial=0.0)):
        kind = "positive definite" if definite else "positive semidefinite"
        raise ValueError(f"{name}: expected a {kind} matrix, found least eigenvalue {least:.3g}")
    return matrix
