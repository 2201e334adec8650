"""Moving-horizon estimate of the sinkage exponent: windows with free initial states, summed as information.

Every `stride` seconds a new window of `length` seconds is reduced to a quadratic in n (its initial state eliminated); windows
overlap and count stride/length each. The estimate minimises the sum of the quadratics and a broad prior, old windows weighing
less (`forgetting`); windows linearised too far from the estimate are linearised again. The soil has changed where the newest
windows contradict the older ones beyond their scatter (likelihood ratio); the older ones are then dropped.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.predictor import substeps_for
from softsoil.declaration.driveline import with_driveline
from softsoil.estimator.late_change import later_soil
from softsoil.estimator.summary import LEAST_CURVATURE, Summary
from softsoil.estimator.tuning import common_error
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.states import sensor_std
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS
from softsoil.windows.absent_wheels import absent_wheels
from softsoil.windows.free_windows import FreeWindows, window_model
from softsoil.windows.own_numbers import stated_error, with_load, with_own_numbers, with_steering_scale
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive
from softsoil.windows.window_fit import reduce_windows, window_costs

Array = NDArray[np.float64]

LEAST_NOISE = np.array([1e-3, 1e-3, 1e-4, 1e-3, 1e-3, 1e-4])
"""Least standard deviation that a sensor is believed to have (units of the states)."""
FARTHEST = 1.0
"""Scales by which histories are moved to another estimate by their derivative: an extrapolated rut may not turn inside out."""
SCALE = 0.1
"""Of n: what it may move by in a step of a fit."""
SETTLING = 3
"""Steps at the end of a drive in which all its windows are linearised again."""


@dataclass(frozen=True)
class HorizonRules:
    """Numbers of the moving horizon; the same for every soil, vehicle and log (evidence: `benchmarks/estimate_nominal.py`).

    length, stride, run_in: of windows, between their starts, and of histories before them (s); model_error: what the equations
    miss of each channel within a window (m, m, rad, m/s, m/s, rad/s), added to the sensor's noise; common_error: share of n that
    an error common to all windows makes, which no number of windows removes, beside the vehicle's own n_error; forgetting: time
    constant of old windows (s of windows: where none runs, as in a stop, none gets older); longest: age, counted so, beyond which
    a window counts no more; prior: standard deviation of the initial guess; stale: at every update one window of those that
    started within `again` (s) and were linearised farther than this from the estimate (shares of a number's scale, 0.1 of n) is
    linearised again, the one whose quadratic the distance touches most;
    recent: numbers of newest windows of which each is tested against the older ones for a change of soil, few for a large
    change, many for a small one or noisy sensors; change: standard deviations of their difference that are one, and
    least_change: least share of n that is; fastest: steering rate of the road wheels (rad/s) beyond which no window runs, since
    no steering follows; slowest: measured speed (m/s) below which none does, since the force laws divide by it.
    """

    length: float = 1.0
    stride: float = 0.5
    run_in: float = 2.5
    model_error: tuple[float, ...] = (0.03, 0.03, 0.012, 0.02, 0.015, 0.024)
    common_error: float = 0.02
    forgetting: float = 60.0
    prior: float = 0.3
    longest: float = 120.0
    stale: float = 0.1
    again: float = 10.0
    recent: tuple[int, ...] = (4, 8, 16)
    change: float = 4.0
    least_change: float = 0.12
    fastest: float = 1.5
    slowest: float = 0.5


@dataclass(frozen=True)
class HorizonEstimate:
    """The estimate along a drive.

    begun: start of the first window (s); t (K,): times of the updates (s), the ends of windows; states (K, 6): then, by all that
    the horizon knew at last; n (K, A), std (K, A): per axle or one column for both; cost (K,): mean robust squared residual of
    each window in standard deviations; changes: times at which the soil was taken to have changed (s); step_us (K,): time of
    each update; windows (W, ...) remain in `summary`.
    """

    begun: float
    t: Array
    states: Array
    n: Array
    std: Array
    cost: Array
    changes: tuple[float, ...]
    step_us: Array
    summary: Summary


def estimate_horizon(
    recording: Recording,
    model: Model,
    n0: float,
    *,
    tied: bool,
    start: float = 0.0,
    rules: HorizonRules | None = None,
    progress: Callable[[float], None] | None = None,
) -> HorizonEstimate:
    """The sinkage exponent along a drive by a moving horizon, from sensor channels only.

    model: bicycle with parameters n_f, n_r; n0: initial guess; tied: one n for both axles; start: seconds left out at the
    beginning; rules: numbers of the horizon; progress: called with the share done.
    Raises ValueError for a drive that the model cannot use or that is too short.
    """
    rules = rules or HorizonRules()
    bounds = SOIL_SIGNALS["n"]
    if not bounds.lower <= n0 <= bounds.upper:
        raise ValueError(f"n0: expected an initial guess in [{bounds.lower}, {bounds.upper}], found {n0}")
    windows = drive_windows(recording, model, start, rules)
    horizon = MovingHorizon(windows, exponents(tied), n0, rules)
    rows, kept, step_us = windows.rows, [], []
    for k in range(len(rows)):
        began = time.perf_counter()
        n, std = horizon.update(k)
        step_us.append((time.perf_counter() - began) * 1e6)
        kept.append((n, std))
        if progress is not None:
            progress((k + 1) / len(rows))
    horizon.settle()
    kept[-1] = horizon.n.copy(), horizon.std(len(rows) - 1)
    n, std = (np.array(column) for column in zip(*kept, strict=True))
    ends = rows + windows.steps
    return HorizonEstimate(
        begun=float(windows.drive.t[rows[0]]), t=windows.drive.t[ends], states=windows.along(ends)[:, : len(STATE_CHANNELS)], n=n,
        std=std, cost=np.array(horizon.summary.cost),
        changes=tuple(float(windows.drive.t[row]) for row in horizon.changes), step_us=np.array(step_us), summary=horizon.summary,
    )  # fmt: skip


def drive_windows(
    recording: Recording, model: Model, start: float, rules: HorizonRules, absent: tuple[str, ...] | None = None
) -> FreeWindows:
    """Windows of a drive after `start` seconds, weighted by sensor noise and model error; where the vehicle's file states errors
    of its numbers, these are parameters of their model, and so are a load and the steering's scale. absent: wheels that the model
    turns, default those without a measured speed."""
    drive = shooting_drive(recording, model, start, live=True)
    sigma = np.hypot(sensor_std(recording, LEAST_NOISE), rules.model_error)
    absent = absent_wheels([recording]) if absent is None else absent
    compiled = window_model(_with_numbers(model, absent), drive.dt, substeps_for(drive.dt))
    return FreeWindows(compiled, drive, rules.length, sigma, rules.fastest, rules.stride, rules.run_in, rules.slowest)


@lru_cache(maxsize=8)
def _with_numbers(model: Model, absent: tuple[str, ...]) -> Model:
    """The model with the numbers of `drive_windows` as parameters, and wheels that are `absent` from a log."""
    known = stated_error(model.geometry)
    model = with_steering_scale(with_load(with_own_numbers(model, known.names))) if known else model
    return with_driveline(model, absent)


def exponents(tied: bool) -> tuple[Free, ...]:
    """The sinkage exponent as the free number of a horizon: one for both axles (`tied`) or one for each."""
    bounds = SOIL_SIGNALS["n"]
    names = (("n_f", "n_r"),) if tied else (("n_f",), ("n_r",))
    return tuple(Free(group[0], group, SCALE, bounds.lower, bounds.upper) for group in names)


class MovingHorizon:
    """The recursion over windows; the generated library has the same in C (`softsoil_horizon.c`).

    windows: of the drive; free: what is estimated, `exponents` or more: a number that is known beforehand belongs to the
    vehicle, does not change with the soil, and its `known` is its prior; n0: initial guess of the exponents; rules: its numbers.
    """

    def __init__(self, windows: FreeWindows, free: Sequence[Free], n0: float, rules: HorizonRules) -> None:
        self.windows, self.rules, self.free = windows, rules, tuple(free)
        self._guess = np.array([n0 if f.known is None else f.known[0] for f in free])
        self._prior = np.array([rules.prior if f.known is None else f.known[1] for f in free])
        self._soil = np.array([f.known is None for f in free])
        self._common = self._soil * common_error(rules.common_error, windows.compiled.model)
        self._scale = np.array([f.scale for f in free])
        self.n = self._guess.copy()
        self.summary, self._since = Summary(), 0
        self.changes: list[int] = []
        self._memory: list[tuple[Array, Array, Array]] = []
        self._share = min(rules.stride / rules.length, 1.0)

    def update(self, k: int) -> tuple[Array, Array]:
        """Take in window k; returns the estimate (A,) and its standard deviation (A,)."""
        memory = self._carry(k)
        self.take(np.array([k]), [self.windows.first[k]], memory[:, None])
        self._minimise(k)
        i = self._stale(k)
        if i is not None:
            self._linearise(np.array([i]), self._recalled(i)[:, None])
            self._minimise(k)
        if self._changed(k):
            self.changes.append(int(self.windows.rows[self._since]))
            self._minimise(k)
        return self.n.copy(), self.std(k)

    def settle(self) -> None:
        """At the end of a drive: all windows of its last soil linearised again at the estimate, however old, and minimised.

        Where the soil has changed without a window saying so when it was new, the last soil is that of the later part.
        """
        self._settle()
        found = later_soil(self.summary, self._since, self._share, self._soil, round(self.rules.length / self.rules.stride))
        if found is not None:
            self._begin(*found)
            self.changes.append(int(self.windows.rows[self._since]))
            self._settle()

    def _settle(self) -> None:
        last = len(self.summary.at) - 1
        for _ in range(SETTLING):
            self.windows.bridge(self.parameters(self.n))
            self._linearise(np.arange(self._since, last + 1), None)
            self._minimise(last)

    def _begin(self, window: int, n: Array) -> None:
        """Another soil since `window`, whose own estimate is n (A,): what is no soil keeps what was known of it."""
        self._since = window
        inside = np.clip(n, [f.lower for f in self.free], [f.upper for f in self.free])
        self._guess = np.where(self._soil, inside, self._guess)

    def _stale(self, k: int) -> int | None:
        """Of windows that started lately and were linearised far from the estimate, the one whose quadratic that touches most."""
        summary, rows, lately = self.summary, self.windows.rows, round(self.rules.again / self.windows.drive.dt)
        found, most = None, -1.0
        for i in range(max(self._since, int(np.searchsorted(rows, rows[k] - lately))), k + 1):
            away = summary.at[i] - self.n
            if not np.any(np.abs(away) / self._scale > self.rules.stale):
                continue
            weight = float(away @ summary.hessian[i] @ away)
            if weight > most:
                found, most = i, weight
        return found

    def _carry(self, k: int) -> Array:
        """(1 + A, n_m) histories at the start of window k, continued from the window before it."""
        windows, row = self.windows, int(self.windows.rows[k])
        sets, steps = windows.moved(self.parameters(self.n), self.free)
        if k == 0:
            memory = windows.carried(sets, None, max(row - windows.before, 0), row)
        else:
            memory = windows.carried(sets, self._recalled(k - 1), int(windows.rows[k - 1]), row)
        self._memory.append((memory, self.n.copy(), steps))
        return memory

    def _recalled(self, i: int) -> Array:
        """(1 + A, n_m) histories at the start of window i, moved to the present estimate to first order."""
        memory, at, steps = self._memory[i]
        away = np.clip(self.n - at, -FARTHEST * self._scale, FARTHEST * self._scale)
        return memory + np.einsum("km,k->m", memory[1:] - memory[0], away / steps)

    def take(self, which: NDArray[np.int_], states: Sequence[Array], memory: Array | None = None) -> None:
        """Add the windows `which` with initial states (6,) each; memory (1 + A, W, n_m): histories at their starts."""
        summary, count = self.summary, len(self.free)
        for x0 in states:
            summary.at.append(self.n.copy())
            summary.hessian.append(np.zeros((count, count)))
            summary.gradient.append(np.zeros(count))
            summary.states.append(x0)
            summary.cost.append(0.0)
        self._linearise(which, memory)

    @property
    def since(self) -> int:
        """The first window of the present soil."""
        return self._since

    @property
    def share(self) -> float:
        """What a window counts of one that overlaps none."""
        return self._share

    def parameters(self, n: Array) -> Array:
        """(n_p,) parameters of the model with n (A,)."""
        model = self.windows.compiled.model
        p = model.p.nominal
        for f, value in zip(self.free, n, strict=True):
            p[[model.p.index(name) for name in f.sets]] = value
        return p

    def _linearise(self, which: NDArray[np.int_], memory: Array | None) -> None:
        """Reduce windows at the present estimate."""
        p, summary = self.parameters(self.n), self.summary
        x0 = np.array([summary.states[i] for i in which])
        linear = self.windows.linearise(p, x0, self.free, which, memory)
        reduced = reduce_windows(linear)
        move = reduced.states(np.zeros(len(self.free)))
        x0 = x0 + move
        if linear.path is not None and linear.path_by_state is not None:
            bent = linear.path + np.einsum("wtij,wj->wti", linear.path_by_state, move)
            self.windows.keep(bent, which)
        cost = window_costs(linear.residual)
        for j, i in enumerate(which):
            summary.at[i], summary.states[i], summary.cost[i] = self.n.copy(), x0[j], float(cost[j])
            summary.hessian[i], summary.gradient[i] = reduced.hessian[j], reduced.gradient[j]

    def weight(self, k: int) -> Array:
        """(k + 1,) weights of the windows up to k: overlap, forgetting, none before the last change of soil."""
        age = (k - np.arange(k + 1)) * self.rules.stride
        weight = self._share * np.exp(-age / self.rules.forgetting)
        weight[: self._since] = 0.0
        weight[age > self.rules.longest] = 0.0
        return weight

    def _minimise(self, k: int) -> None:
        n, _ = self.summary.minimum(self.weight(k), (self._guess, self._prior))
        self.n = np.clip(n, [f.lower for f in self.free], [f.upper for f in self.free])

    def _changed(self, k: int) -> bool:
        """Whether the newest windows contradict the older ones; then the older ones no longer count."""
        return any(self._changed_within(k, recent) for recent in self.rules.recent)

    def _changed_within(self, k: int, recent: int) -> bool:
        rules = self.rules
        if k + 1 - self._since < recent + 2 * rules.recent[0]:
            return False
        weight = self.weight(k) / self._share
        new, old = slice(k + 1 - recent, k + 1), slice(self._since, k + 1 - recent)
        (n_new, h_new), (n_old, h_old) = (self.summary.minimum(weight, None, part) for part in (new, old))
        spread = np.zeros(len(n_new))
        per_window = self.summary.scatter(n_old, weight, old) / max(weight[old].sum(), 1.0)
        for curvature, count in ((h_new, recent), (h_old, weight[old].sum())):
            inverse = np.linalg.inv(curvature + LEAST_CURVATURE * np.eye(len(curvature)))
            # Neighbours overlap: their scores count 1/share times as often as windows that do not.
            scatter = np.diag(inverse @ (per_window * count / self._share) @ inverse)
            spread = spread + np.maximum(scatter, np.diag(inverse) / self._share)
        moved = np.abs(n_new - n_old)
        found = self._soil & (moved > rules.change * np.sqrt(spread)) & (moved > rules.least_change * n_old)
        if not found.any():
            return False
        # Windows that overlap the border hold both soils: they are dropped with the older ones.
        self._begin(k + 1 - max(recent - round(rules.length / rules.stride), 1), n_new)
        return True

    def std(self, k: int) -> Array:
        """(A,) standard deviation after window k: sandwich of the scores, at least that of noise, and the error common to all."""
        weight = self.weight(k)
        return np.sqrt(self.summary.variance(self.n, weight, (self._guess, self._prior)) + (self._common * self.n) ** 2)

