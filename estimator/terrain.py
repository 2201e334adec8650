"""The terrain estimator: the sinkage exponent of a drive, assembled from model, filter and tuning."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.consistency import inside_band
from softsoil.estimator.inputs import known_states, measured_inputs, measured_states, sensor_std
from softsoil.estimator.predictor import substeps_for
from softsoil.estimator.promote import promote_parameters, tie_parameters
from softsoil.estimator.ukf import Counts, Innovation, UnscentedKalmanFilter
from softsoil.estimator.verdict import Verdict
from softsoil.recording.clock import on_even_clock, on_fine_clock
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS

Array = NDArray[np.float64]

SLOW_ROWS = 0.018
"""s: a log with rows farther apart is too slow to leave any measurement out."""


NOISE_FREE = 0.2
"""A log whose channels all carry less than this share of the filter's sensor floor has no noise to be consistent with."""


@dataclass(frozen=True)
class Tuning:
    """Numbers of the filter that the paper leaves open; the same for every soil, vehicle and log.

    model_error: what the equations miss, as densities per state: standard deviation after one second of accumulation
    (units of x, y, psi, u, v, omega_z); force_error: what they miss in proportion to the lateral acceleration |u omega_z|,
    the same densities for v (m/s per m/s^2) and omega_z (rad/s per m/s^2): a force law errs by a share of the force;
    n_walk: of the sinkage exponent per square root of a second; n_std: of the first
    guess; sensor_floor: least standard deviation that a sensor is believed to have; gate: innovation in standard
    deviations; patience: updates in a row that a measurement may fail the gate before it is the state that is taken to have
    jumped; change_after, change_sigmas, change_std: an n that has moved by
    more than change_sigmas of its standard deviation within change_after seconds belongs to another soil, and change_std
    is added to its uncertainty; update_every: predictions per update (the paper: 12 ms and 24 ms), 1 for slow logs.
    """

    model_error: tuple[float, ...] = (0.02, 0.02, 0.002, 0.1, 0.1, 0.05)
    force_error: tuple[float, float] = (0.2, 0.1)
    n_walk: float = 0.002
    n_std: float = 0.3
    sensor_floor: tuple[float, ...] = (0.05, 0.05, 0.003, 0.05, 0.05, 0.005)
    gate: float = 6.0
    patience: int = 2
    change_after: float = 5.0
    change_sigmas: float = 1.2
    change_std: float = 0.15
    update_every: int = 2


EXACT_MODEL = Tuning(model_error=(0.02, 0.02, 0.002, 0.1, 0.05, 0.02), force_error=(0.0, 0.0), change_sigmas=3.0)
"""For drives of the model itself, whose equations miss nothing: what is left is rounding and the sampling of inputs. The stated
uncertainty is then all there is, so that n must move by more of it before the soil is taken to have changed."""


@dataclass(frozen=True)
class TerrainEstimate:
    """What the estimator says about one drive.

    t (N,): times of the updates (s); n_front, n_rear, n_front_std, n_rear_std (N,); states (N, 6): estimates;
    nis (N,), dof (N,): consistency of each update, empty for a method without innovations; counts: measurements left out;
    step_us (K,): time of each predict + update of a pair of steps, microseconds; parameters: p of the underlying model with the
    final estimate; changes: times at which the soil was taken to have changed (s); noise_free: whether the log carries far less
    noise than the filter assumes, so that its innovations say nothing; verdict: whether the final n may be used, None where
    nobody judged.
    """

    t: Array
    n_front: Array
    n_rear: Array
    n_front_std: Array
    n_rear_std: Array
    states: Array
    nis: Array
    dof: NDArray[np.int_]
    counts: Counts
    step_us: Array
    parameters: dict[str, float] = field(default_factory=dict)
    changes: tuple[float, ...] = ()
    noise_free: bool = False
    verdict: Verdict | None = None

    @property
    def nis_inside_95(self) -> float:
        """Share of updates whose NIS lies in its 95 % band."""
        return inside_band(self.nis, self.dof)

    @property
    def converged_s(self) -> float:
        """First time after the start from which n_front stays within 10 % of its final value (s)."""
        outside = np.abs(self.n_front - self.n_front[-1]) > 0.1 * abs(self.n_front[-1])
        last = int(np.flatnonzero(outside)[-1]) + 1 if outside.any() else 0
        return float(self.t[min(last, len(self.t) - 1)] - self.t[0])


def terrain_model(model: Model, tied: bool) -> Model:
    """The model with n as a state: n_f and n_r as in the paper, or one n for both axles (`tied`)."""
    if tied:
        return promote_parameters(tie_parameters(model, SOIL_SIGNALS["n"], "n_f", "n_r"), "n")
    return promote_parameters(model, "n_f", "n_r")


def estimate_terrain(
    recording: Recording,
    model: Model,
    n0: float,
    *,
    tied: bool = False,
    tuning: Tuning | None = None,
    start: float = 0.0,
    progress=None,
) -> TerrainEstimate:
    """The sinkage exponent along a drive, from sensor channels only.

    model: bicycle with parameters n_f, n_r (and declared effects); n0: first guess; tied: one n for both axles;
    start: seconds of the log left out at its beginning (start-up transient); progress: called with the share done.
    Raises ValueError for reversing, a first guess outside the bounds of n, or a log without the channels.
    """
    tuning = tuning or Tuning()
    log = on_even_clock(recording)
    log = log.between(log.t[0] + start, np.inf)
    if len(log) < 4:
        raise ValueError(f"{log.name}: expected at least 4 rows after the start-up, found {len(log)}")
    own_step, log = log.dt, on_fine_clock(log)
    augmented = terrain_model(model, tied)
    inputs, _ = measured_inputs(log, augmented.external)
    measured = measured_states(log)
    ukf = _filter(log, augmented, n0, tuning)
    where = [augmented.x.index(name) for name in (("n", "n") if tied else ("n_f", "n_r"))]
    every = tuning.update_every if log.dt < SLOW_ROWS else 1
    noise, jumps = ForceError(augmented, tuning, log.dt), Jumps(tuning.patience)
    soil = SoilChange(tuning, where, max(round(tuning.change_after / max(log.dt * every, own_step)), 1))
    kept: list[tuple[float, float, int, Array, Array]] = []
    # Of a log slower than the model's clock only its own samples are updates.
    seen_rows: NDArray[np.bool_] = np.asarray(np.isfinite(measured).any(axis=1) | (log.dt >= own_step), dtype=bool)
    step_us = []
    for k in range(len(log) - 1):
        began = time.perf_counter()
        noise.apply(ukf)
        ukf.predict(inputs[k])
        if (k + 1) % every == 0 and seen_rows[k + 1]:
            seen = ukf.update(measured[k + 1])
            if seen.dof < len(seen.used) or jumps.waiting:
                jumps.see(ukf, seen, measured[k + 1])
            soil.see(ukf)
            step_us.append((time.perf_counter() - began) * 1e6)
            kept.append((log.t[k + 1], seen.nis, seen.dof, ukf.x, ukf.variance))
            if progress is not None and len(kept) % 64 == 0:
                progress((k + 1) / len(log))
    t, nis, dof, states, variances = (np.array(column) for column in zip(*kept, strict=True))
    n, std = states[:, where], np.sqrt(variances[:, where])
    return TerrainEstimate(
        t=t, n_front=n[:, 0], n_rear=n[:, 1], n_front_std=std[:, 0], n_rear_std=std[:, 1],
        states=states[:, : len(STATE_CHANNELS)], nis=nis, dof=dof, counts=ukf.counts, step_us=np.array(step_us),
        parameters={"n_f": float(n[-1, 0]), "n_r": float(n[-1, 1])},
        noise_free=bool(np.all(sensor_std(log, np.zeros(len(STATE_CHANNELS))) < NOISE_FREE * np.array(tuning.sensor_floor))),
    )  # fmt: skip


def _filter(log: Recording, model: Model, n0: float, tuning: Tuning) -> UnscentedKalmanFilter:
    bounds = SOIL_SIGNALS["n"]
    if not bounds.lower <= n0 <= bounds.upper:
        raise ValueError(f"n0: expected a first guess in [{bounds.lower}, {bounds.upper}], found {n0}")
    sensor = sensor_std(log, np.array(tuning.sensor_floor))
    extra = len(model.x) - len(STATE_CHANNELS)
    known = known_states(log)
    first = np.array([_first(known[:, i]) for i in range(known.shape[1])])
    is_n = np.array([name in ("n", "n_f", "n_r") for name in model.x.names[len(STATE_CHANNELS) :]])
    x0 = np.concatenate([first, np.where(is_n, n0, model.x.nominal[len(STATE_CHANNELS) :])])
    p0 = np.concatenate([sensor**2, np.where(is_n, tuning.n_std**2, 1e-4)])
    walk = np.where(is_n, tuning.n_walk, 1e-4) if extra else np.zeros(0)
    q = np.concatenate([tuning.model_error, walk]) ** 2 * log.dt
    return UnscentedKalmanFilter(
        model, log.dt, q=q, r=sensor**2, x0=x0, p0=p0, gate=tuning.gate, substeps=substeps_for(log.dt)
    )


class ForceError:
    """Process noise of v and omega_z that grows with the lateral force; dt: of a prediction (s)."""

    def __init__(self, model: Model, tuning: Tuning, dt: float) -> None:
        self._rows = [model.x.index(name) for name in ("v", "omega_z")]
        self._still = np.array([tuning.model_error[STATE_CHANNELS.index(name)] for name in ("v", "omega_z")]) ** 2 * dt
        self._force = np.array(tuning.force_error) ** 2 * dt
        self._u, self._omega_z = model.x.index("u"), model.x.index("omega_z")

    def apply(self, ukf: UnscentedKalmanFilter) -> None:
        """Set the noise of the next prediction."""
        if self._force.any():
            a_y = ukf.at(self._u) * ukf.at(self._omega_z)
            ukf.set_process_variance(self._rows, self._still + self._force * (a_y * a_y))


class Jumps:
    """A measurement that fails the gate again and again is right: the state has jumped, and is opened for it.

    patience: failures in a row after which it is.
    """

    def __init__(self, patience: int) -> None:
        self._patience = patience
        self._run = np.zeros(len(STATE_CHANNELS), dtype=int)

    @property
    def waiting(self) -> bool:
        """Whether a measurement failed the last time."""
        return bool(self._run.any())

    def see(self, ukf: UnscentedKalmanFilter, seen: Innovation, y: Array) -> None:
        """Take in what an update saw of the measurements y (n_y,)."""
        failed = ~seen.used & np.isfinite(y)
        self._run = np.where(failed, self._run + 1, 0)
        due = np.flatnonzero(self._run >= self._patience)
        if len(due):
            ukf.open(due, seen.value[due] ** 2)
            self._run[due] = 0


class SoilChange:
    """Opens n when it moves on and on: a soil that changed, where a filter that had converged would follow too slowly.

    rows: of the states that are n; lookback: updates over which a move is judged.
    """

    def __init__(self, tuning: Tuning, rows: Sequence[int], lookback: int) -> None:
        self._tuning, self._rows = tuning, sorted(set(rows))
        # Twice the lookback: the first seconds are convergence from the first guess, not a change.
        self._past: deque[tuple[float, ...]] = deque(maxlen=lookback)
        self._settling = 2 * lookback

    def see(self, ukf: UnscentedKalmanFilter) -> None:
        """Take in the estimate after an update."""
        values = tuple(ukf.at(row) for row in self._rows)
        self._settling -= 1
        if self._settling < 0 and len(self._past) == self._past.maxlen:
            std = np.sqrt(ukf.variance[self._rows])
            moved = np.abs(np.subtract(values, self._past[0]))
            changed = np.flatnonzero(moved > self._tuning.change_sigmas * std)
            if len(changed):
                ukf.open(np.asarray(self._rows)[changed], np.full(len(changed), self._tuning.change_std**2))
                self._past.clear()
                self._settling = self._past.maxlen or 0
        self._past.append(values)


def _first(values: Array) -> float:
    """Median of the first few finite values: a first state that one outlier does not spoil."""
    good = values[np.isfinite(values)][:5]
    return float(np.median(good)) if len(good) else 0.0
