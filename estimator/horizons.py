"""States predicted over horizons from recorded states, window after window (paper, section V, Table 8).

A window starts at the recorded state, the model runs free through it on the recorded inputs, and the next window starts at
the recorded state again. A last window that the log does not fill is left out, as is one that starts where a state is
missing. Where the model has effects of sensors, a window starts at the state whose outputs were recorded, and its outputs are
compared. Histories of the model at the start of a window are those along the recorded states before it.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from softsoil.checking.usable import usable
from softsoil.codegen.predictor import Predictor, substeps_for
from softsoil.declaration.handed import check_model
from softsoil.declaration.late_steering import late_steering
from softsoil.estimator.driveline_choice import log_driveline, with_choice
from softsoil.recording.clock import on_even_clock
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.evidence import filled, interpolated
from softsoil.recording.forward import MISSED, driven, usable_rows
from softsoil.recording.states import known_states, measured_states
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import check_n
from softsoil.windows.absent_wheels import with_log_wheels
from softsoil.windows.inputs import measured_inputs
from softsoil.windows.sensor_states import along, outputs_of, senses, settle
from softsoil.windows.shooting import lengths, smoothed, window_starts

Array = NDArray[np.float64]

HORIZONS = (0.5, 2.5, 5.0)
"""s: the paper's horizons."""
START_UP = 2.0
"""s: left out at the beginning of a log, where a vehicle settles on the soil and pulls away."""
RARELY = 2.5
"""s: a row with all states this often is enough for windows to begin."""
BRIDGED = 0.25
"""s between samples of a slower sensor over which a window may start."""


@dataclass(frozen=True)
class Windows:
    """Windows of one horizon over one drive.

    horizon (s); rows (M,): rows of the log at which they start; predicted, recorded (M, N + 1, 6): states in the order of
    STATE_CHANNELS; left_out: rows at the end that fill no window.
    """

    horizon: float
    rows: NDArray[np.int_]
    predicted: Array
    recorded: Array
    left_out: int

    @property
    def error(self) -> Array:
        """(M, N + 1, 6) predicted - recorded, psi on (-pi, pi]."""
        error = self.predicted - self.recorded
        psi = STATE_CHANNELS.index("psi")
        error[:, :, psi] = np.angle(np.exp(1j * error[:, :, psi]))
        return error

    @property
    def mse(self) -> dict[str, float]:
        """Mean squared error of each state over all windows, in squared units; NaN where the log holds nothing to compare with,
        infinite where a prediction has no finite value."""
        squares, known = self.error[:, 1:] ** 2, np.isfinite(self.recorded[:, 1:])
        squares = np.where(np.isfinite(self.predicted[:, 1:]), squares, np.inf)
        count = known.sum(axis=(0, 1))
        total = np.where(known, squares, 0.0).sum(axis=(0, 1))
        return {name: float(total[i] / count[i]) if count[i] else float("nan") for i, name in enumerate(STATE_CHANNELS)}


def predict(
    log: Recording | pd.DataFrame | str | Path,
    model: Model,
    n: float | tuple[float, float] | None = None,
    horizon: float = 2.5,
    *,
    start: float = START_UP,
) -> Windows:
    """States predicted over windows of a log from its recorded states (paper, Table 8).

    log: a drive or its file; model: with its declared effects; n: sinkage exponent, or (front, rear), default the soil's;
    horizon (s); start: seconds left out at the beginning. `mse` of the result has the mean squared error of each state.
    Raises ValueError for an n outside its bounds, and for inputs that the log cannot give, TypeError for what is no model.

    Example:
        >>> import softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> log = softsoil.example_logs()[0]
        >>> right, wrong = (softsoil.predict(log, model, n).mse["omega_z"] for n in (0.5, 0.7))
        >>> right < wrong
        True
    """
    check_model("predict", model)
    p = model.p.nominal
    if n is not None:
        n_f, n_r = n if isinstance(n, tuple) else (n, n)
        check_n("n", n_f)
        check_n("n", n_r)
        p = model.p.pack(n_f=n_f, n_r=n_r)
    return Replay(usable(log, model.geometry, late_steering(model.geometry)), model, start).windows(p, horizon)


class Replay:
    """A drive made ready for prediction with one model: its inputs, states and clock.

    Windows start at states derived where they are not measured, or on a line between two with at most BRIDGED s between, and are
    judged by measured ones alone.

    recording: taken as it is, so clean logs give the paper's "true states"; model: bicycle, with declared effects if any;
    start: seconds left out at the beginning, and after every standstill or reversing. Raises ValueError for inputs that a drive
    cannot give.
    """

    def __init__(self, recording: Recording, model: Model, start: float = START_UP) -> None:
        log = on_even_clock(recording)
        self.t, self.dt, self.name = log.t, log.dt, log.name
        self.states, self.recorded = start_states(log), measured_states(log)
        self._lengths = lengths(log)
        self.inputs, _ = measured_inputs(log, model.external)
        self.first = int(np.searchsorted(log.t, log.t[0] + start - 1e-9))
        self._driven = driven(log, start) & usable_rows(log)
        choice = log_driveline(log, model, float(model.p.nominal[model.p.index("n_f")]), start)
        if choice is not None:
            warnings.warn(f"{log.name}: no wheel speeds: {choice}", stacklevel=2)
            model = with_choice(model, choice)
        model = with_log_wheels(model, [log])
        self._nominal = model.p.nominal  # of a model with more parameters than p, where wheel speeds are absent
        self.predictor = Predictor(model, log.dt, substeps=substeps_for(log.dt))
        self._more = model.x.nominal[len(STATE_CHANNELS) :]
        self._outputs = outputs_of(model) if senses(model) else None

    def windows(self, p: ArrayLike, horizon: float, stop: int | None = None) -> Windows:
        """Windows of `horizon` (s) with parameters p (n_p,), over the rows from the start-up to `stop`.

        Raises ValueError for a horizon shorter than a step.
        """
        steps = round(horizon / self.dt)
        if steps < 1:
            raise ValueError(f"horizon: expected at least one step of {self.dt:g} s, found {horizon:g} s")
        last = len(self.t) if stop is None else stop
        known = np.asarray(np.isfinite(self.states[:last]).all(axis=1))
        starts = window_starts(self.first, ~self._driven[:last], steps, steps, known)
        left_out = last - (int(starts[-1]) + steps + 1 if len(starts) else self.first)
        p = self._whole(p)
        full, memory = self._along(p)
        predicted = np.empty((len(starts), steps + 1, len(STATE_CHANNELS)))
        said = None if self._outputs is None else self._outputs.map("outputs_ahead", "serial", steps + 1, [1], [])
        for i, row in enumerate(starts):
            path = self.predictor.rollout(full[row], self.inputs[row : row + steps], p, memory[row])
            predicted[i] = path[:, : len(STATE_CHANNELS)] if said is None else said(path.T, p).full().T
        recorded = np.array([self.recorded[row : row + steps + 1] for row in starts]).reshape(predicted.shape)
        return Windows(horizon, starts, predicted, recorded, left_out)

    def mse(self, p: ArrayLike, horizons: Sequence[float] = HORIZONS) -> dict[str, dict[str, float]]:
        """Horizon -> state -> mean squared error, as study.json has it."""
        return {f"{horizon:.1f}": self.windows(p, horizon).mse for horizon in horizons}

    def rates(self, p: ArrayLike) -> Array:
        """(N - 1, 6) rates of the states that the model has at the smoothed record, each as its step over dt says: noise of slips
        would be forces."""
        p = self._whole(p)
        full, memory = self.predictor.track(smoothed(self._true(p), self.dt, self._lengths), self.inputs, p)
        after = self.predictor.one_step(full[:-1], self.inputs[:-1], p, memory[:-1])
        return (after - full[:-1])[:, : len(STATE_CHANNELS)] / self.dt

    def _along(self, p: Array) -> tuple[Array, Array]:
        """States (N, n_x) with what the log does not measure run along it, and memory (N, n_m)."""
        return self.predictor.track(np.column_stack([filled(column) for column in self._true(p).T]), self.inputs, p)

    def true_record(self, p: ArrayLike) -> Array:
        """(N, 6) states by the record, what sensors make of them with p (n_p,) taken off; NaN where it holds none."""
        return np.asarray(self.recorded + (self._true(self._whole(p)) - self.states))

    def _whole(self, p: ArrayLike) -> Array:
        """p with the numbers of the model that it lacks, at their nominal values."""
        return np.concatenate([p, self._nominal[len(np.asarray(p)) :]])

    def _true(self, p: Array) -> Array:
        """(N, 6) states whose outputs with p are those of the record."""
        if self._outputs is None:
            return self.states
        found = np.column_stack([self.states, np.tile(self._more, (len(self.t), 1))])
        sensed = np.asarray(np.isfinite(self.recorded).any(axis=0))
        settle(along(self._outputs, len(self.t)), p, self.states, found, sensed)
        return found[:, : len(STATE_CHANNELS)]


def bridged(states: Array, dt: float) -> Array:
    """States with gaps of at most BRIDGED (s) filled by lines; dt: s per row."""
    return np.column_stack([interpolated(column, round(BRIDGED / dt)) for column in states.T])


def start_states(log: Recording) -> Array:
    """(N, 6) `bridged` states; where samples of slow sensors then hardly meet in a row, with gaps of MISSED intervals of each."""
    states = known_states(log)
    found = bridged(states, log.dt)
    if np.isfinite(found).all(axis=1).sum() * RARELY >= log.t[-1] - log.t[0]:
        return found
    every = [np.diff(np.flatnonzero(np.isfinite(column))) for column in states.T]
    reach = [round(max(MISSED * float(np.median(rows)) if len(rows) else 0.0, BRIDGED / log.dt)) for rows in every]
    return np.column_stack([interpolated(column, rows) for column, rows in zip(states.T, reach, strict=True)])
