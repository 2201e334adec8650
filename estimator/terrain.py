"""The terrain estimator: the sinkage exponent of a drive, assembled from model, filter and tuning."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.consistency import above_band, inside_band
from softsoil.estimator.drift import Drift
from softsoil.estimator.promote import promote_parameters, tie_parameters
from softsoil.estimator.terrain_filter import TerrainFilter, first_state
from softsoil.estimator.tuning import Tuning
from softsoil.estimator.ukf import Counts
from softsoil.estimator.verdict import Verdict
from softsoil.recording.clock import on_even_clock, on_fine_clock
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.forward import in_ruts, inputs_known
from softsoil.recording.states import known_states, measured_states, sensor_std
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.absent_wheels import with_log_wheels
from softsoil.windows.inputs import measured_inputs

Array = NDArray[np.float64]



NOISE_FREE = 0.2
"""A log whose channels all carry less than this share of the filter's sensor floor has no noise to be consistent with."""


@dataclass(frozen=True)
class TerrainEstimate:
    """What the estimator says about one drive.

    t (N,): times of the updates (s); n_front, n_rear, n_front_std, n_rear_std (N,); states (N, 6): estimates; nis (N,), dof
    (N,): consistency of each update, empty for a method without innovations; counts: measurements left out; step_us (K,):
    time of each predict + update of a pair of steps, microseconds; parameters: p of the underlying model with the final
    estimate; drift: first alarm of the drift monitor, None without one; changes, revoked: times at which the soil was taken
    to have changed (s), and at which it was but the seconds after did not bear it out; noise_free: whether the log carries
    far less noise than the filter assumes, so that its innovations say nothing; verdict: whether the final n may be used,
    None where nobody judged; begun: when estimating began (s), None: with the first update; by_filter: n and its standard
    deviation, front and rear, that the filter itself had at the end where windows corrected it, else None; n0: the initial
    guess that it starts from, NaN without soil; on_trial: time of a jump (s) that the log ends too soon to bear out, and n before
    it, else None. Without soil, one row of NaN and the verdict "no_soil".
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
    revoked: tuple[float, ...] = ()
    drift: Drift | None = None
    noise_free: bool = False
    verdict: Verdict | None = None
    begun: float | None = None
    by_filter: tuple[tuple[float, float], tuple[float, float]] | None = None
    n0: float = np.nan
    on_trial: tuple[float, float] | None = None

    @property
    def nis_inside_95(self) -> float:
        """Share of updates whose NIS lies in its 95 % band."""
        return inside_band(self.nis, self.dof)

    @property
    def nis_above_95(self) -> float:
        """Share of updates whose NIS lies above that band: innovations are larger than the filter expects."""
        return above_band(self.nis, self.dof)

    @property
    def converged_s(self) -> float:
        """How long after estimating began n_front came within 10 % of its final value to stay (s)."""
        outside = np.abs(self.n_front - self.n_front[-1]) > 0.1 * abs(self.n_front[-1])
        last = int(np.flatnonzero(outside)[-1]) + 1 if outside.any() else 0
        return float(self.t[min(last, len(self.t) - 1)] - (self.t[0] if self.begun is None else self.begun))

FIRST = 5
"""Samples of a channel that make a first state."""


@lru_cache(maxsize=4)
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
    Raises ValueError for a first guess outside the bounds of n, or a log without the channels.
    """
    tuning = tuning or Tuning()
    log = on_even_clock(recording)
    log = log.between(log.t[0] + start, np.inf)
    if len(log) < 4:
        raise ValueError(f"{log.name}: expected at least 4 rows after the start-up, found {len(log)}")
    for name in ("u", "v", "omega_z", "steer"):
        if not np.isfinite(log[name]).any():
            raise ValueError(f"{log.name}: channel {name}: expected numbers after the start-up of {start:g} s, found none")
    own_step, log = log.dt, on_fine_clock(log)
    augmented = terrain_model(with_log_wheels(model, [log]), tied)
    inputs, _ = measured_inputs(log, augmented.external)
    known, fresh = inputs_known(log), ~in_ruts(log)
    measured = measured_states(log)
    own = _filter(log, augmented, n0, tuning)
    every = tuning.update_every
    kept: list[tuple[float, float, int, Array, Array]] = []
    own_rows = log.dt >= own_step  # of a log slower than the model's clock only its own samples are updates
    step_us, unused = [], np.full(measured.shape[1], np.nan)
    for k in range(len(log) - 1):
        began = time.perf_counter()
        own.predict(inputs[k], bool(known[k]), bool(fresh[k]))
        own.t = float(log.t[k + 1])
        # What rows without an update measured counts at the next one.
        unused = np.where(np.isfinite(measured[k + 1]), measured[k + 1], unused)
        if (k + 1) % every == 0 and (own_rows or np.isfinite(unused).any()):
            seen = own.update(unused)
            unused = np.full_like(unused, np.nan)
            step_us.append((time.perf_counter() - began) * 1e6)
            kept.append((log.t[k + 1], seen.nis, seen.dof, own.ukf.x, own.n_std))
            if progress is not None and len(kept) % 64 == 0:
                progress((k + 1) / len(log))
    where = [augmented.x.index(name) for name in (("n", "n") if tied else ("n_f", "n_r"))]
    t, nis, dof, states, n_std = (np.array(column) for column in zip(*kept, strict=True))
    n, std = states[:, where], n_std[:, [0, -1]]
    found = TerrainEstimate(
        t=t, n_front=n[:, 0], n_rear=n[:, 1], n_front_std=std[:, 0], n_rear_std=std[:, 1],
        states=states[:, : len(STATE_CHANNELS)], nis=nis, dof=dof, counts=own.ukf.counts, step_us=np.array(step_us),
        parameters={"n_f": float(n[-1, 0]), "n_r": float(n[-1, 1])}, changes=tuple(own.changes),
        revoked=tuple(own.revoked), n0=n0, on_trial=own.on_trial,
        drift=own.drift.first_alarm(catalogue(load_vehicle("reference")).values()),
        noise_free=bool(np.all(sensor_std(log, np.zeros(len(STATE_CHANNELS))) < NOISE_FREE * np.array(tuning.sensor_floor))),
    )  # fmt: skip
    _idle(augmented, log.dt, tuning)["filter"] = own
    return found


@lru_cache(maxsize=4)
def _idle(model: Model, dt: float, tuning: Tuning) -> dict[str, TerrainFilter]:
    """The `filter` that no drive uses, if there is one: building it takes longer than a drive."""
    return {}


def _filter(log: Recording, model: Model, n0: float, tuning: Tuning) -> TerrainFilter:
    bounds = SOIL_SIGNALS["n"]
    if not bounds.lower <= n0 <= bounds.upper:
        raise ValueError(f"n0: expected a first guess in [{bounds.lower}, {bounds.upper}], found {n0}")
    sensor = sensor_std(log, np.array(tuning.sensor_floor))
    own = _idle(model, log.dt, tuning).pop("filter", None) or TerrainFilter(model, log.dt, sensor, tuning)
    own.set_sensors(sensor)
    first = np.array([_first(log.t, column) for column in known_states(log).T])
    x0 = first_state(model, first[:, 0], n0)
    std0 = tuning.std0(model.x, sensor)
    std0[: len(first)] = np.hypot(std0[: len(first)], first[:, 1])
    own.start(x0, std0, float(log.t[0]))
    return own


def _first(t: Array, values: Array) -> tuple[float, float]:
    """A first state that one outlier does not spoil, by the first few finite values, and by how much it is less certain than one
    of them: their median, or where a sensor is slower than the clock, what a line through them says of the first row. Of a
    channel that begins later the median, as uncertain as the channel changes in so long a time."""
    rows = np.flatnonzero(np.isfinite(values))[:FIRST]
    if not len(rows):
        return 0.0, 0.0
    middle, every = float(np.median(values[rows])), float(np.median(np.diff(rows))) if len(rows) > 1 else 1.0
    if rows[0] > 2.0 * every:
        change = values[rows[0] :] - values[: -rows[0]]
        change = change[np.isfinite(change)]
        return middle, float(np.sqrt(np.mean(change**2))) if len(change) else abs(middle)
    if every < 2.0:
        return middle, 0.0
    rates = np.diff(values[rows]) / np.diff(t[rows])
    rate = float(np.median(rates))
    back = values[rows] - rate * (t[rows] - t[0])
    middle = float(np.median(back))
    apart, turning = (float(np.median(np.abs(one - np.median(one)))) for one in (back, rates))
    return middle, 1.4826 * float(np.hypot(apart, 0.5 * turning * (t[rows[0]] - t[0])))
