"""The unscented Kalman filter on any Model, its steps running as generated C."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.compiled import CompiledFunction, at_points
from softsoil.codegen.discretize import advance_memory, discretize, read_memory, start_memory
from softsoil.estimator.unscented import UnscentedScaling, predict_function, update_function
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]


class Innovation(NamedTuple):
    """What one update saw.

    value (n_y,): y - y_mean; covariance (n_y, n_y): S; nis: normalised innovation squared over the `used` measurements;
    used (n_y,) bool: measurements that were valid and inside the gate; dof: how many those are, the degrees of freedom.
    """

    value: Array
    covariance: Array
    nis: float
    used: NDArray[np.bool_]
    dof: int


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
    gate: largest innovation in standard deviations; scaling: of the unscented transform; method, substeps: of
    `discretize`; compiled: whether the steps run as generated C; order (n_x,): of the states in the factor of the covariance.
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
        order: Sequence[int] | None = None,
    ) -> None:
        scaling = scaling or UnscentedScaling()
        n_x = len(model.x)
        self.model, self.dt = model, dt
        self.p = model.p.nominal if p is None else _checked(p, len(model.p), "p").copy()
        self.gate = gate
        self.counts = Counts()
        self._compile(method, substeps, scaling, compiled, order)
        self._predict.inputs[4][...] = _covariance(q, n_x, "q", definite=False)
        self.set_measurement_noise(r)
        self._update.inputs[7][...] = min(gate, 1e150)
        self._parameters[:, 0] = self.p
        self.x = _checked(x0, n_x, "x0")
        self.P = _covariance(p0, n_x, "p0", definite=False)
        self._started = not model.memories

    def _compile(
        self, method: str, substeps: int, scaling: UnscentedScaling, compiled: bool, order: Sequence[int] | None
    ) -> None:
        """The steps as C on shared arrays: prediction goes from the first pair (x, P) to the second, the update back."""
        model = self.model
        step = discretize(model, self.dt, method, substeps)
        substep = discretize(model, self.dt / substeps, method)
        many, parts = at_points(substep, 2 * len(model.x) + 1, substeps) if compiled else (None, ())
        self._predict = CompiledFunction(predict_function(step, model.x, scaling, many, order), compiled, parts)
        update = update_function(model.measurement(), model.x, model.y, scaling, order)
        self._update = CompiledFunction(update, compiled)
        self._pairs = (self._predict.inputs[:2], self._predict.outputs[:2])
        self._at = 0
        self._input, self._parameters = self._predict.inputs[2], self._predict.inputs[3]
        for i, array in enumerate((*self._pairs[1], self._input, self._parameters)):
            self._update.bind_input(i, array)
        for i, array in enumerate(self._pairs[0]):
            self._update.bind_output(i, array)
        self._n_external = len(model.external)
        self._y, self._valid = self._update.inputs[4][:, 0], self._update.inputs[5][:, 0]
        _, _, innovation, _, self._nis, used = self._update.outputs
        self._innovation, self._used = innovation[:, 0], used[:, 0]
        if model.memories:
            self._share_memory(compiled)
        self._external = (self._read.inputs[1] if model.memories else self._input)[:, 0]
        self._external[:] = model.external.nominal

    def _share_memory(self, compiled: bool) -> None:
        """Histories as C on the same arrays: read gives the full input, advance reads what the prediction started from."""
        model = self.model
        self._read = CompiledFunction(read_memory(model), compiled)
        self._advance = CompiledFunction(advance_memory(model, self.dt), compiled)
        self._start = CompiledFunction(start_memory(model), compiled=False)
        state, external, memory = self._pairs[0][0], self._read.inputs[1], self._read.inputs[3]
        for function, inputs in (
            (self._start, (state, external, self._parameters)),
            (self._read, (state, external, self._parameters, memory)),
            (self._advance, (state, self._input, self._parameters, memory)),
        ):
            for i, array in enumerate(inputs):
                function.bind_input(i, array)
        self._read.bind_output(0, self._input)
        self._before = memory.copy()

    def restart(self, x0: ArrayLike, p0: ArrayLike) -> None:
        """Begin again from another first state, without memory of the past: for drive after drive with one compiled filter.

        x0 (n_x,); p0: (n_x,) variances or (n_x, n_x) covariance. Raises ValueError as the constructor does.
        """
        self._stand(0)
        self.x = _checked(x0, len(self.model.x), "x0")
        self.P = _covariance(p0, len(self.model.x), "p0", definite=False)
        self._started = not self.model.memories
        self._external[:] = self.model.external.nominal
        self.counts = Counts()

    @property
    def compiled(self) -> tuple[CompiledFunction, CompiledFunction]:
        """Prediction and update on their shared arrays: run in turn, they go on from step to step on the last inputs."""
        return self._predict, self._update

    @property
    def x(self) -> Array:
        """(n_x,) estimate; set it to start again from another."""
        return self._pairs[self._at][0][:, 0].copy()

    @x.setter
    def x(self, value: ArrayLike) -> None:
        self._pairs[self._at][0][:, 0] = value

    @property
    def P(self) -> Array:
        """(n_x, n_x) covariance of the estimate."""
        return self._pairs[self._at][1].copy()

    @P.setter
    def P(self, value: ArrayLike) -> None:
        self._pairs[self._at][1][...] = value

    @property
    def memory(self) -> Array | None:
        """(n_m,) histories, None for a model without them or before the first prediction."""
        return self._read.inputs[3][:, 0].copy() if self.model.memories and self._started else None

    def predict(self, u: ArrayLike) -> None:
        """Time update over dt with the external inputs u (n_external,) held; a non-finite input keeps its last value."""
        self._stand(0)
        self._take_input(u)
        self._predict.run()
        if self.model.memories:
            self._advance.run()
            self._before[...] = self._read.inputs[3]
            self._read.inputs[3][...] = self._advance.outputs[0]
        self._at = 1

    def update(self, y: ArrayLike, valid: ArrayLike | None = None) -> Innovation:
        """Measurement update with y (n_y,); entries that are not finite or not `valid` (n_y,) bool are skipped, counted."""
        self._stand(1)
        y = _checked(y, len(self.model.y), "y")
        if valid is None and _all_finite(y):
            self._y[:], self._valid[:] = y, 1.0
        else:
            usable = np.isfinite(y) & (True if valid is None else np.asarray(valid, dtype=bool))
            self._y[:], self._valid[:] = np.where(usable, y, 0.0), usable
        self._update.run()
        self._at = 0
        used = self._used > 0.5
        dof = int(np.count_nonzero(used))
        if dof < len(used):
            self._count(self._valid > 0.5, used)
        return Innovation(self._innovation.copy(), self._update.outputs[3].copy(), self._nis.item(), used, dof)

    def take_inputs(self, u: ArrayLike) -> Array:
        """External inputs (n_external,) held from now on, u with its non-finite entries replaced, without a prediction."""
        self._stand(0)
        self._take_input(u)
        return self.held_inputs

    @property
    def held_inputs(self) -> Array:
        """(n_external,) external inputs of the last prediction."""
        return self._external.copy()

    def undo_prediction(self) -> None:
        """Back to the estimate and the histories before the last prediction, where its answer cannot be used."""
        self._at = 0
        if self.model.memories:
            self._read.inputs[3][...] = self._before

    def undo_update(self) -> None:
        """Back to the estimate before the last update, where its answer is not finite."""
        self._at = 1

    def hold(self, rows: Sequence[int] | NDArray[np.int_]) -> None:
        """Have updates leave the states `rows` (K,) as they are from now on, their variances too; none: all are corrected."""
        held = self._update.inputs[8]
        held[:] = 0.0
        held[list(rows)] = 1.0

    def set_process_variance(self, rows: Sequence[int] | NDArray[np.int_], variance: ArrayLike) -> None:
        """Variances added to the states `rows` (K,) at each prediction from now on, variance (K,)."""
        noise = self._predict.inputs[4]
        for row, value in zip(rows, np.atleast_1d(variance), strict=True):
            noise[row, row] = value

    def set_measurement_noise(self, r: ArrayLike) -> None:
        """Variances (n_y,) or covariance (n_y, n_y) of the measurements from now on."""
        self._update.inputs[6][...] = _covariance(r, len(self.model.y), "r", definite=True)

    def open(self, rows: NDArray[np.int_], variance: Array, away: Array) -> None:
        """Move the states `rows` (K,) by away (K,), inside their bounds, and add variance (K,): they have jumped thereabouts."""
        x, cov = self._pairs[self._at]
        x[rows, 0] = np.clip(x[rows, 0] + away, self.model.x.lower[rows], self.model.x.upper[rows])
        cov[rows, rows] += variance

    def know(self, row: int, value: float, variance: float) -> None:
        """Update with a measurement `value` of the state `row` itself, with this variance."""
        x, cov = self._pairs[self._at]
        column = cov[:, row].copy()
        gain = column / (column[row] + variance)
        x[:, 0] = np.clip(x[:, 0] + gain * (value - x[row, 0]), self.model.x.lower, self.model.x.upper)
        cov -= np.outer(gain, column)

    def jump(self, row: int, away: float, variance: float) -> None:
        """Move the state `row` by `away`, from where it knows nothing of the others and has this variance."""
        x, cov = self._pairs[self._at]
        x[row, 0] += away
        cov[row, :] = cov[:, row] = 0.0
        cov[row, row] = variance

    def at(self, row: int) -> float:
        """Estimate of the state with index `row`."""
        return float(self._pairs[self._at][0][row, 0])

    @property
    def variance(self) -> Array:
        """(n_x,) diagonal of P."""
        return self._pairs[self._at][1].diagonal().copy()

    def __getitem__(self, name: str) -> float:
        """Estimate of the named state."""
        return float(self._pairs[self._at][0][self.model.x.index(name), 0])

    def _stand(self, at: int) -> None:
        """Have x and P in the pair that the next step reads: two predictions or updates in a row need a copy."""
        if self._at != at:
            for target, source in zip(self._pairs[at], self._pairs[self._at], strict=True):
                target[...] = source
            self._at = at

    def _take_input(self, u: ArrayLike) -> None:
        external = _checked(u, self._n_external, "u")
        if not _all_finite(external):
            finite = np.isfinite(external)
            for i in np.flatnonzero(~finite):
                name = self.model.external.names[i]
                self.counts.held_inputs[name] = self.counts.held_inputs.get(name, 0) + 1
            external = np.where(finite, external, self._external)
        self._external[:] = external
        if not self._started:
            self._start.run()
            self._read.inputs[3][...] = self._start.outputs[0]
            self._started = True
        if self.model.memories:
            self._read.run()

    def _count(self, usable: NDArray[np.bool_], used: NDArray[np.bool_]) -> None:
        for i, name in enumerate(self.model.y.names):
            if not usable[i]:
                self.counts.invalid[name] = self.counts.invalid.get(name, 0) + 1
            elif not used[i]:
                self.counts.gated[name] = self.counts.gated.get(name, 0) + 1


def _all_finite(vector: Array) -> bool:
    """Whether every entry is finite: one product instead of a test of each, which may say no where squares overflow."""
    return math.isfinite(vector.dot(vector))


def _checked(value: ArrayLike, size: int, name: str) -> Array:
    """`value` as (size,) floats, without a copy where it is that already."""
    vector = np.asarray(value, dtype=float)
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
