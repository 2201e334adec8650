"""Multiple shooting: what a model predicts over windows of a drive that start at the recorded states.

The recorded states are smoothed by a short polynomial (no model in it) for the starts of windows and for the model's
histories; residuals are against the recorded values themselves. Sensor effects enter the outputs, so a window starts at the
state whose outputs are what was recorded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import savgol_filter

from softsoil.codegen.discretize import start_memory, step_with_memory
from softsoil.codegen.step_loop import PathLoop, StepLoop
from softsoil.recording.clock import on_even_clock, on_fine_clock
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Recording
from softsoil.recording.forward import driven, states_known, usable_rows
from softsoil.recording.states import known_states, measured_states, sensor_std
from softsoil.symbolic.model import Model
from softsoil.windows.histories import first_carried, history_loop, parted
from softsoil.windows.inputs import measured_inputs
from softsoil.windows.sensor_states import along, outputs_of, settle

Array = NDArray[np.float64]

BROKEN = 1e9
"""What a prediction that is not finite counts as, in the unit of its channel."""
SMOOTHING = 0.25
"""s: least length of the polynomial that smooths recorded states; much shorter than any motion of a vehicle on soft soil."""
LONGEST_SMOOTHING = 0.6
"""s: its greatest length, for noisy sensors: as long as a vehicle takes to follow its steering."""
MODEL_STD = np.array([0.03, 0.03, 0.004, 0.02, 0.015, 0.008])
"""What a right model misses over a window of 1 s, per state (m, m, rad, m/s, m/s, rad/s): some per cent of the lateral force."""
SEEN = 0.5
"""Share of the measured rows of most windows that one has at least: across a gap its initial state went anywhere, and no step of
the numbers was taken."""
BRIDGED = 0.25
"""s: samples of a state this far from each other, or as far as that sensor's are, are no gap."""
LEFT = 1.3
"""A quadratic over N samples leaves 1.5 over the root of N of their noise; taken a little smaller, so that good sensors keep
SMOOTHING."""


@dataclass(frozen=True)
class Drive:
    """A drive ready for shooting.

    name; dt (s); t (N,); measured (N, 6): recorded states, NaN where missing or derived; smooth (N, 6): smoothed, complete;
    inputs (N, n_u): external inputs; first: row where the start-up is over; driven (N,): rows that windows may run across,
    forwards and after the start-up that follows a standstill, too; usable (N,): rows of which the inputs are known and the soil
    is fresh; near (N,): rows whose smoothed states rest on no gap.
    """

    name: str
    dt: float
    t: Array
    measured: Array
    smooth: Array
    inputs: Array
    first: int
    driven: NDArray[np.bool_]
    usable: NDArray[np.bool_]
    near: NDArray[np.bool_]


def shooting_drive(
    recording: Recording, model: Model, start: float, smoothing: float | None = None, live: bool = False
) -> Drive:
    """The drive on an even clock with smoothed states; `start` seconds at its beginning, and after every standstill or reversing,
    are left out of windows;
    smoothing: length of the polynomial (s), to be shorter for a smaller and quicker vehicle, default by each state's noise
    (`lengths`). Wheel speeds are smoothed, too, since the shear path goes by the size of the slip, which noise only enlarges;
    not where windows are to be as they are `live`, when no later sample is there: then it is SMOOTHING.

    Raises ValueError for inputs that the drive cannot give, or a drive shorter than a few seconds.
    """
    log = on_fine_clock(on_even_clock(recording))
    measured = measured_states(log)
    inputs, _ = measured_inputs(log, model.external)
    spins = [i for i, name in enumerate(model.external.names) if name in WHEEL_CHANNELS]
    if spins and not live:
        inputs[:, spins] = smoothed(inputs[:, spins], log.dt, smoothing or SMOOTHING)
    first = int(np.searchsorted(log.t, log.t[0] + start - 1e-9))
    if len(log) - first < 3.0 / log.dt:
        held = max(log.t[-1] - log.t[0] - start, 0.0)
        raise ValueError(f"{log.name}: expected at least 3 s of drive after the start-up, found {held:.3g} s")
    length = smoothing or (SMOOTHING if live else lengths(log))
    smooth = smoothed(known_states(log), log.dt, length)
    usable = usable_rows(log)
    reach = round(0.5 * float(np.max(length)) / log.dt)  # of the polynomial, which must not lean on a gap's line
    near = np.convolve(~states_known(log, BRIDGED), np.ones(2 * reach + 1), mode="same") == 0
    return Drive(log.name, log.dt, log.t, measured, smooth, inputs, first, driven(log, start) & usable, usable, near)


def lengths(log: Recording) -> Array:
    """(6,) lengths (s) of the polynomials that smooth the states of a log on an even clock: what brings a sensor's noise down to
    MODEL_STD, from SMOOTHING to LONGEST_SMOOTHING. Noise at the start of a window hides what a model lacks."""
    noise = np.nan_to_num(sensor_std(log, np.zeros(len(STATE_CHANNELS))))
    return np.clip(log.dt * (LEFT * noise / MODEL_STD) ** 2, SMOOTHING, LONGEST_SMOOTHING)


def smoothed(states: Array, dt: float, length: ArrayLike = SMOOTHING) -> Array:
    """(N, n) states, dt apart, through quadratics over `length` seconds, one or (n,); missing values are interpolated first."""
    out = np.empty_like(states)
    rows = np.arange(len(states))
    windows = [max(2 * round(one / dt / 2) + 1, 5) for one in np.broadcast_to(length, states.shape[1])]
    for i, window in enumerate(windows):
        good = np.isfinite(states[:, i])
        if not good.any():
            raise ValueError(f"channel {STATE_CHANNELS[i]}: expected numbers, found none")
        out[:, i] = savgol_filter(np.interp(rows, rows[good], states[good, i]), window, 2)
    return out


@dataclass(frozen=True)
class Compiled:
    """What shooting needs of a model for one time step: compiled loops, its memory's start and its outputs [x, p] -> [y]."""

    loop: StepLoop
    histories: PathLoop
    start: ca.Function
    outputs: ca.Function

    @classmethod
    def of(cls, model: Model, dt: float, substeps: int) -> Compiled:
        """The functions for a step of dt (s), in `substeps` Euler steps."""
        step, outputs = step_with_memory(model, dt, substeps=substeps), outputs_of(model)
        x, _, p = model.symbols()
        m, u = ca.SX.sym("m", len(model.cells)), ca.SX.sym("u", len(model.external))
        results = ca.cse([*step(x, m, u, p), outputs(x, p)])
        loop = StepLoop(ca.Function("shooting_step", [x, m, u, p], results))
        return cls(loop, history_loop(model, dt), start_memory(model), outputs)


def window_starts(
    first: int, blocked: NDArray[np.bool_], steps: int, stride: int, known: NDArray[np.bool_] | None = None
) -> NDArray[np.int_]:
    """First rows of windows of so many steps from row `first` on, `stride` rows from one to the next, none across
    a `blocked` row (N,), and each at the next row (N,) whose states are `known`, where that is given."""
    rows, row = [], first
    while row + steps < len(blocked):
        inside = np.flatnonzero(blocked[row : row + steps + 1])
        if len(inside):
            row += int(inside[-1]) + 1
        elif known is not None and not known[row]:
            ahead = np.flatnonzero(known[row:])
            row = row + int(ahead[0]) if len(ahead) else len(blocked)
        else:
            rows.append(row)
            row += stride
    return np.array(rows, dtype=int)


def well_measured(rows: NDArray[np.int_], steps: int, measured: Array, share: float = SEEN) -> NDArray[np.int_]:
    """Those of the windows of so many steps from rows (W,) that have at least a `share` of the measured rows that most have;
    measured (N, n): NaN where nothing was."""
    if not len(rows):
        return rows
    counts = np.concatenate([[0], np.cumsum(np.isfinite(measured).any(axis=1))])
    inside = counts[rows + steps + 1] - counts[rows]
    return np.asarray(rows[inside >= share * np.median(inside)])


class Shooting:
    """Predictions of one model over the windows of one drive.

    model: bicycle with effects; drive; horizon (s): length of the windows, which stand side by side where the vehicle drives;
    substeps: Euler steps inside a step of the drive, for vehicles so quick that one would not be stable; compiled: the model's
    functions for this time step, where there are some already.
    """

    def __init__(self, model: Model, drive: Drive, horizon: float, substeps: int = 1, compiled: Compiled | None = None) -> None:
        self.model, self.drive = model, drive
        self.compiled = compiled or Compiled.of(model, drive.dt, substeps)
        self.steps = max(round(horizon / drive.dt), 2)
        self.rows = self.starts(horizon)
        if len(self.rows) < 2:
            raise ValueError(
                f"{drive.name}: expected at least 2 windows of {horizon:g} s driven forwards, found {len(self.rows)}"
            )
        self._loop, self._start = self.compiled.loop, self.compiled.start
        self._extra = model.x.nominal[len(STATE_CHANNELS) :]
        take = self.rows[:, None] + np.arange(self.steps + 1)
        self.recorded = drive.measured[take][:, 1:]
        self._inputs = drive.inputs[take]

    def starts(self, horizon: float) -> NDArray[np.int_]:
        """Rows at which windows of another length (s) of the same drive would start: none in a gap of what is measured, and none
        across most of one."""
        steps = max(round(horizon / self.drive.dt), 2)
        rows = window_starts(self.drive.first, ~self.drive.driven, steps, steps, self.drive.near)
        return well_measured(rows, steps, self.drive.measured)

    def ahead(self, horizon: float) -> Shooting:
        """Windows of another length (s) of the same drive, with the same compiled functions."""
        return Shooting(self.model, self.drive, horizon, compiled=self.compiled)

    def predict(self, p: ArrayLike, windows: NDArray[np.int_] | None = None) -> Array:
        """Outputs predicted over the windows, from one step after their start to their end.

        p (n_p,): (W, N, 6); p (K, n_p), many parameter sets at once, which is faster: (K, W, N, 6).
        windows: indices, increasing, of those that are wanted, default all; the drive after the last is not looked at.
        """
        rows = np.atleast_2d(np.asarray(p, dtype=float))
        wanted = np.arange(len(self.rows)) if windows is None else windows
        starts, memory = self._starts(rows, self.rows[wanted])
        count, inputs = len(wanted), self._inputs[wanted]
        jobs = len(rows) * count
        outputs = self._loop.windows(
            starts.reshape(jobs, starts.shape[-1]),
            memory.reshape(jobs, memory.shape[-1]),
            np.broadcast_to(inputs, (len(rows), *inputs.shape)).reshape(jobs, *inputs.shape[1:]),
            np.repeat(rows, count, axis=0),
        ).reshape(len(rows), count, self.steps + 1, len(STATE_CHANNELS))[:, :, 1:]
        return outputs if np.ndim(p) == 2 else outputs[0]

    def residual(self, p: ArrayLike, windows: NDArray[np.int_] | None = None) -> Array:
        """Predicted - recorded, psi on (-pi, pi], in the shapes of `predict`; NaN where nothing was recorded."""
        recorded = self.recorded if windows is None else self.recorded[windows]
        # A prediction that broke down is as wrong as can be; only what was not recorded is unknown.
        error = np.nan_to_num(self.predict(p, windows), nan=BROKEN, posinf=BROKEN, neginf=-BROKEN) - recorded
        psi = STATE_CHANNELS.index("psi")
        error[..., psi] = np.angle(np.exp(1j * error[..., psi]))
        return error

    def _starts(self, p: Array, rows: NDArray[np.int_]) -> tuple[Array, Array]:
        """States (K, W, n_x) at the rows (W,), whose outputs are the smoothed record, and memories (K, W, n_m) there."""
        drive = self.drive
        end = int(rows.max(initial=0)) + 1
        states = np.column_stack([drive.smooth[:end], np.tile(self._extra, (end, 1))])
        m0 = first_carried(self.model, self._start, states[0], drive.inputs[0], p)
        states = np.tile(states, (len(p), 1, 1))
        sensed = np.asarray(np.isfinite(drive.measured).any(axis=0))
        outputs = along(self.compiled.outputs, len(drive.t))  # with buffers that no other thread writes
        for row, found in zip(p, states, strict=True):
            settle(outputs, row, drive.smooth[:end], found, sensed)
        more, memory = parted(self.model, self.compiled.histories.along(states, m0, drive.inputs[:end], p, rows)[1])
        starts = states[:, rows]
        starts[:, :, len(STATE_CHANNELS) :] = more
        return starts, memory


def shootings(model: Model, drives: Sequence[Drive], horizon: float, substeps: int = 1) -> tuple[Shooting, ...]:
    """Windows of `horizon` seconds of several drives, the model compiled once for each time step; substeps: as of Shooting."""
    steps = {dt: Compiled.of(model, dt, substeps) for dt in {drive.dt for drive in drives}}
    return tuple(Shooting(model, drive, horizon, substeps, steps[drive.dt]) for drive in drives)
