"""Windows of a drive whose initial states are free: predictions and their derivatives, in generated C.

A window that starts at recorded states carries their noise into every parameter; here the initial state of each window is an
unknown that is eliminated window by window (Schur complement). Histories (ruts, delays) start each window as they are along the
states estimated so far.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.discretize import start_memory, step_with_memory
from softsoil.codegen.step_loop import StepLoop
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.symbolic.model import Model
from softsoil.windows.histories import first_carried, history_loop, parted
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import BROKEN, Drive, well_measured, window_starts

Array = NDArray[np.float64]

N = len(STATE_CHANNELS)
PSI = STATE_CHANNELS.index("psi")
STATE_STEP = np.array([1e-4, 1e-4, 1e-5, 1e-4, 1e-4, 1e-5])
"""Steps of the differences by which initial states enter the Jacobian (units of the states)."""
FREE_STEP = 5e-6
"""The same for parameters, relative to their scale."""
Windows = slice | NDArray[np.int_]
"""Which windows: increasing indices, or all."""
ALL = slice(None)
SETTLING = 0.1
"""s: after a steering faster than the vehicle's actuator, before a window starts."""
BRIDGED = 2.0
"""s: longest gap between windows across which histories run along the model instead of along noisy records."""


class WindowModel:
    """A model's step compiled once for the windows of all drives with one sample interval.

    dt: sample interval (s); substeps: Euler steps inside it; beside: as of `history_loop`.
    """

    def __init__(self, model: Model, dt: float, substeps: int = 1, beside: ca.Function | None = None) -> None:
        self.model, self.dt = model, dt
        step = step_with_memory(model, dt, substeps=substeps)
        x, u_full, p = model.symbols()
        m, u = ca.SX.sym("m", len(model.cells)), ca.SX.sym("u", len(model.external))
        y = model.measurement()(x, u_full, p)
        if ca.depends_on(y, u_full):
            raise ValueError(f"model {model.name}: expected outputs of the states alone, found some of the inputs")
        after = step(x, m, u, p)
        self.loop = StepLoop(ca.Function("window_step", [x, m, u, p], ca.cse([*after, ca.vertcat(y, x[:N])])))
        self.histories, self.start = history_loop(model, dt, beside), start_memory(model)
        self.extra = model.x.nominal[N:]

    def first(self, x: Array, u: Array, sets: Array) -> Array:
        """(K, n) what is carried first at states x (n_x,) and inputs u (n_u,), for parameters sets (K, n_p)."""
        return first_carried(self.model, self.start, x, u, sets)


@lru_cache(maxsize=8)
def window_model(model: Model, dt: float, substeps: int = 1) -> WindowModel:
    """The `WindowModel` of these, built once: it takes as long as the windows of a drive."""
    return WindowModel(model, dt, substeps)


@dataclass(frozen=True)
class Linear:
    """Residuals in standard deviations and their derivatives.

    residual (W, m); by_state (W, m, 6); by_free (W, m, K); path (W, steps + 1, 6): states that the windows run through, and
    path_by_state (W, steps + 1, 6, 6), None for what has no states. A window for which the model has no finite answer says
    nothing: its residuals and derivatives are 0, its path is NaN.
    """

    residual: Array
    by_state: Array
    by_free: Array
    path: Array | None = None
    path_by_state: Array | None = None


class FreeWindows:
    """The windows of one drive.

    compiled: the model's step; drive: on an even clock; horizon: length of a window (s); sigma (6,): what a residual of each
    channel is measured against, in its unit, infinite for a channel that does not count; fastest: steering rate (rad/s) beyond
    which no window runs, since no actuator follows; stride: from the start of one window to the next (s), default `horizon`;
    run_in: seconds before a window from which its histories are run, default the whole drive before it; slowest: measured speed
    (m/s) below which no window runs, default where the drive is not `driven`; seen: least share of the measured rows of most
    windows, since fewer leave the initial state of a window open.
    Raises ValueError for a drive that holds no two windows.
    """

    def __init__(
        self,
        compiled: WindowModel,
        drive: Drive,
        horizon: float,
        sigma: Array,
        fastest: float = np.inf,
        stride: float | None = None,
        run_in: float = np.inf,
        slowest: float | None = None,
        seen: float = 0.0,
    ) -> None:
        self.compiled, self.drive, self.sigma = compiled, drive, np.asarray(sigma, dtype=float)
        self.steps = max(round(horizon / drive.dt), 2)
        apart = self.steps if stride is None else max(round(stride / drive.dt), 1)
        self.rows = window_rows(compiled.model, drive, self.steps, apart, fastest, slowest, seen)
        self._before = len(drive.t) if np.isinf(run_in) else round(run_in / drive.dt)
        if len(self.rows) < 2:
            where = "driven forwards" if slowest is None else f"above {slowest:g} m/s"
            raise ValueError(f"{drive.name}: expected at least 2 windows of {horizon:g} s {where}, found {len(self.rows)}")
        gaps = zip(self.rows[:-1] + self.steps, self.rows[1:], strict=True)
        self._gaps = {int(to): int(end) for end, to in gaps if 0 < to - end <= round(BRIDGED / drive.dt)}
        take = self.rows[:, None] + np.arange(self.steps + 1)
        self.recorded, self._inputs = drive.measured[take], drive.inputs[take]
        self.covered = len(np.unique(take)) / (len(drive.t) - drive.first)
        self._latest: tuple[tuple[bytes, ...], tuple[Array, Array]] | None = None
        self.reset()

    def reset(self) -> None:
        """Let histories run along the smoothed record again."""
        self._along = np.column_stack([self.drive.smooth, np.tile(self.compiled.extra, (len(self.drive.t), 1))])

    def by(self, compiled: WindowModel) -> FreeWindows:
        """The same windows by another model of the same states and parameters, or by other steps of it."""
        other = copy(self)
        other.compiled, other._latest = compiled, None
        return other

    def along(self, rows: NDArray[np.int_]) -> Array:
        """(R, n_x) states at the `rows` (R,) of the drive as estimated so far."""
        return self._along[rows].copy()

    def under(self, which: Windows = ALL) -> NDArray[np.int_]:
        """(R,) rows of the drive that the windows `which` run over, each once."""
        return np.unique(self.rows[which][:, None] + np.arange(self.steps + 1))

    @property
    def first(self) -> Array:
        """(W, 6) initial states of the windows as estimated so far."""
        return self._along[self.rows, :N].copy()

    def residual(self, p: Array, x0: Array, which: Windows = ALL) -> Array:
        """(W, m) residuals in standard deviations for parameters p (n_p,) and initial states x0 (W, 6) of the windows `which`."""
        return self._residual(self._run(p[None], x0[None], which)[0, ..., :N], which)

    def moved(self, p: Array, free: Sequence[Free]) -> tuple[Array, Array]:
        """(1 + K, n_p) parameters p (n_p,), and p with each free number moved by its step; (K,) steps."""
        index = self.compiled.model.p.index
        sets, steps = np.tile(p, (1 + len(free), 1)), np.zeros(len(free))
        for k, f in enumerate(free):
            steps[k] = FREE_STEP * f.scale * (-1.0 if p[index(f.sets[0])] + FREE_STEP * f.scale > f.upper else 1.0)
            sets[1 + k, [index(name) for name in f.sets]] += steps[k]
        return sets, steps

    def carried(self, sets: Array, memory: Array | None, row: int, to: int) -> Array:
        """(K, n_m) histories at the row `to`, where a window starts, for parameters sets (K, n_p): from memory (K, n_m) at
        `row`, or straight. Across a gap between the window before and `to` they run along what the model predicts for sets[0],
        not along records, whose noise is not the vehicle's motion."""
        gap = self._gaps.get(to)
        if gap is not None and row < gap:
            memory = self._carried(sets, memory, row, gap)
            self._bridge(sets[0], memory[0], gap, to)
            row = gap
        return self._carried(sets, memory, row, to)

    def bridge(self, p: Array) -> None:
        """Let histories run across all gaps between windows along what the model predicts with p (n_p,)."""
        memory, row = None, max(int(self.rows[0]) - self._before, 0)
        for to in self._gaps:
            memory = self.carried(p[None], memory, row, to)
            row = to

    def _bridge(self, p: Array, memory: Array, row: int, to: int) -> None:
        """States between `row` and `to` as predicted with p (n_p,) and memory (n_m,) at `row`, led to the one at `to` in a
        straight line; as they were where the model has no finite answer."""
        inputs = self.drive.inputs[None, row : to + 1]
        more, memory = parted(self.compiled.model, memory)
        first = np.concatenate([self._along[row, :N], more])
        path = self.compiled.loop.windows(first[None], memory[None], inputs, p[None])[0, :, N:]
        path += (self._along[to, :N] - path[-1]) * (np.arange(len(path)) / (to - row))[:, None]
        if np.isfinite(path).all():
            self._along[row:to, :N] = path[:-1]

    def _carried(self, sets: Array, memory: Array | None, row: int, to: int) -> Array:
        states, inputs = self._along[row : to + 1], self.drive.inputs[row : to + 1]
        if memory is None:
            memory = self.compiled.first(states[0], inputs[0], sets)
        many = np.tile(states, (len(sets), 1, 1))
        start = memory.reshape(len(sets), -1)
        return self.compiled.histories.along(many, start, inputs, sets, np.array([to - row]))[1][:, 0]

    @property
    def before(self) -> int:
        """Rows before a window from which its histories are run."""
        return self._before

    def linearise(self, p: Array, x0: Array, free: Sequence[Free], which: Windows = ALL, memory: Array | None = None) -> Linear:
        """Residuals and derivatives at p (n_p,), x0 (W, 6), of the windows `which` (increasing indices, default all).

        memory (1 + K, W, n_m): histories at their starts for p and for each free number moved, default run before them.
        """
        moved, steps = self.moved(p, free)
        starts = np.concatenate([[x0], x0 + STATE_STEP[:, None, None] * np.eye(N)[:, None, :], np.tile(x0, (len(free), 1, 1))])
        sets = np.array([0] * (1 + N) + list(range(1, len(moved))))
        both = self._run(moved, starts, which, sets, memory)
        out, states = both[..., :N], both[: 1 + N, ..., N:]
        residual = self._residual(out[0], which)
        with np.errstate(invalid="ignore"):  # of windows without a finite answer
            slope = (out[1:] - out[0]) / self.sigma
            path_by_state = np.moveaxis((states[1:] - states[0]) / STATE_STEP[:, None, None, None], 0, -1)
        slope[:, ~np.isfinite(self.recorded[which])] = 0.0
        slope = slope.reshape(len(slope), len(x0), -1)
        broken = ~np.isfinite(slope).all(axis=(0, 2))
        residual[broken], slope[:, broken], states[0, broken], path_by_state[broken] = 0.0, 0.0, np.nan, np.nan
        by_state = np.moveaxis(slope[:N] / STATE_STEP[:, None, None], 0, -1)
        by_free = np.moveaxis(slope[N:] / steps[:, None, None], 0, -1) if len(free) else np.zeros((*residual.shape, 0))
        return Linear(residual, by_state, by_free, states[0], path_by_state)

    def follow(self, p: Array, x0: Array, which: Windows = ALL) -> None:
        """Let histories run along the trajectories from the initial states x0 (W, 6) of the windows `which` with p (n_p,), and
        across gaps between them."""
        self.keep(self._run(p[None], x0[None], which)[0, ..., N:], which)
        self.bridge(p)

    def keep(self, states: Array, which: Windows = ALL) -> None:
        """Let histories run along the states (W, steps + 1, 6) of the windows `which`, where they are finite."""
        for row, path in zip(self.rows[which], states, strict=True):
            if np.isfinite(path).all():
                self._along[row : row + self.steps + 1, :N] = path

    def rms(self, p: Array, x0: Array) -> Array:
        """(W, 6) root mean square residual of each window and channel at p, x0 (W, 6), in standard deviations of `sigma`."""
        z = self.residual(p, x0).reshape(len(x0), -1, N)
        seen = np.isfinite(self.recorded)
        return np.sqrt((z**2).sum(axis=1) / np.maximum(seen.sum(axis=1), 1))

    def _residual(self, out: Array, which: Windows) -> Array:
        error = np.nan_to_num(out, nan=BROKEN, posinf=BROKEN, neginf=-BROKEN) - self.recorded[which]
        error[..., PSI] = np.angle(np.exp(1j * error[..., PSI]))
        return np.nan_to_num(error / self.sigma).reshape(len(error), -1)

    def memories(self, p: Array, rows: NDArray[np.int_]) -> Array:
        """(K, W, n_m) histories at the `rows` (W,) for parameters p (K, n_p)."""
        return self._histories(p, rows)[1]

    def series(self, p: Array) -> Array:
        """(K, N, n_y) what the model has `beside` its histories, along the drive as estimated so far, for p (K, n_p)."""
        return self._histories(p, self.rows)[0]

    def _histories(self, p: Array, rows: NDArray[np.int_]) -> tuple[Array, Array]:
        """Along the states as estimated so far: what is beside the histories, over the whole drive, if anything is, and the
        histories at the rows. The latest result is kept, since residuals and what is beside them are asked for in turns."""
        begin, end = max(int(rows[0]) - self._before, 0), int(rows[-1]) + 1
        if self.compiled.histories.n_y:
            begin, end = 0, len(self.drive.t)
        states, inputs = self._along[begin:end], self.drive.inputs[begin:end]
        key = (p.tobytes(), rows.tobytes(), states.tobytes())
        if self._latest is None or self._latest[0] != key:
            m0 = self.compiled.first(states[0], inputs[0], p)
            many = np.tile(states, (len(p), 1, 1))
            self._latest = key, self.compiled.histories.along(many, m0, inputs, p, rows - begin)
        return self._latest[1]

    def _run(
        self, p: Array, x0: Array, which: Windows, sets: NDArray[np.int_] | None = None, memory: Array | None = None
    ) -> Array:
        """(S, W, steps + 1, 12) outputs and states of the windows `which` for x0 (S, W, 6) with the parameters p[sets]."""
        memory = self.memories(p, self.rows[which]) if memory is None else memory
        if sets is not None:
            p, memory = p[sets], memory[sets]
        inputs = self._inputs[which]
        many, count = x0.shape[:2]
        more, memory = parted(self.compiled.model, np.broadcast_to(memory, (many, count, memory.shape[-1])))
        jobs = many * count
        out = self.compiled.loop.windows(
            np.concatenate([x0, more], axis=2).reshape(jobs, -1),
            memory.reshape(jobs, -1),
            np.broadcast_to(inputs, (many, *inputs.shape)).reshape(jobs, *inputs.shape[1:]),
            np.repeat(p, count, axis=0),
        )
        return out.reshape(many, count, self.steps + 1, 2 * N)


def blocked_rows(model: Model, drive: Drive, fastest: float, slowest: float | None) -> dict[str, NDArray[np.bool_]]:
    """(N,) rows across which no window runs, by the reason.

    "steering": faster than `fastest` (rad/s); "speed": measured, below `slowest` (m/s), or, where that is None, not driven
    forwards; "inputs": unknown, or of wheels in the drive's own ruts.
    """
    slow = ~drive.driven if slowest is None else drive.measured[:, STATE_CHANNELS.index("u")] < slowest
    steers = "steer_rate" in model.external.names
    rate = drive.inputs[:, model.external.index("steer_rate")] if steers else np.zeros(len(slow))
    return {"steering": np.abs(rate) > fastest, "speed": slow, "inputs": ~drive.usable}


def window_rows(
    model: Model, drive: Drive, steps: int, apart: int, fastest: float, slowest: float | None, seen: float
) -> NDArray[np.int_]:
    """First rows (W,) of the windows of so many steps, `apart` rows apart, of a drive.

    model: of the windows; None runs across `blocked_rows` by fastest and slowest; none has a smaller share than `seen` of the
    measured rows that most have, as across a gap.
    """
    after = round(SETTLING / drive.dt)
    blocked = np.any(list(blocked_rows(model, drive, fastest, slowest).values()), axis=0)
    blocked = np.convolve(blocked, np.ones(2 * after + 1), mode="same") > 0
    return well_measured(window_starts(drive.first, blocked, steps, apart), steps, drive.measured, seen)
