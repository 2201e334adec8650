"""The terrain filter: an unscented filter on a terrain model, with the rules of what may go wrong on a drive.

The rules, in the order in which they act; the generated C library has the same (`softsoil_filter.c`, `softsoil_policy.h`):
an input that is missing or beyond reason keeps its last value; a vehicle that stands, crawls or reverses keeps its soil and
rolls without forces (`rolling.py`); the process noise grows while histories are not yet the drive's or the steering kicks; a
measurement that is missing, beyond reason or outside the gate is left out; one that stays outside the gate to the same side is
believed, its state put where it is; an n that innovations say has jumped is put there and opened; a jump that the seconds after
it do not bear out is revoked (`soil_trial.py`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.factor_order import factor_order
from softsoil.codegen.sampling import LONGEST_STEP
from softsoil.estimator.drift import CHANNELS, DriftMonitor
from softsoil.estimator.rolling import Rolling
from softsoil.estimator.soil_change import CLOCK_SLACK, SoilChange, evidence
from softsoil.estimator.soil_trial import SoilTrial
from softsoil.estimator.tuning import LEAP, N_NAMES, WHEELS_TURN, Tuning, by_unit, common_error
from softsoil.estimator.ukf import Innovation, UnscentedKalmanFilter
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FilterStatus:
    """What the rules did in the last prediction and update.

    standing: the vehicle stands, crawls or reverses, its soil is held; gated: measurements left out by the gate; jumped:
    measurements believed against the gate, whose states were put there; soil_changed: n has jumped and was opened; soil_kept: a
    jump is revoked, what was known of n before counts again; refused: the model had no usable answer, the last estimate was
    kept; drift: largest sum of the drift monitor over its limit; drifting: name of its channel while that is above 1, else
    empty.
    """

    standing: bool = False
    gated: tuple[str, ...] = ()
    jumped: tuple[str, ...] = ()
    soil_changed: bool = False
    soil_kept: bool = False
    refused: bool = False
    drift: float = 0.0
    drifting: str = ""


class TerrainFilter:
    """Predict and update with the policy that replay, the live loop and the generated C library share.

    model: of `terrain_model`; dt: of a prediction (s); r_std (n_y,): standard deviations of the measurements; tuning: the rules'
    numbers. `start` begins a drive; the compiled filter is kept. A prediction over more than LONGEST_STEP is divided.
    """

    def __init__(self, model: Model, dt: float, r_std: ArrayLike, tuning: Tuning | None = None) -> None:
        self.model, self.dt, self.tuning = model, dt, tuning or Tuning()
        tuning, states = self.tuning, model.x
        self._parts = max(1, math.ceil(dt / LONGEST_STEP - CLOCK_SLACK))
        self._step = dt / self._parts
        self._q, self._kick = tuning.q_std(states) ** 2, tuning.kick_std(states) ** 2
        self._kicked = np.flatnonzero(self._kick)
        self._ceiling = by_unit(states, tuning.ceiling, 1e5)
        self._soil = np.array([i for i, name in enumerate(states.names) if name in N_NAMES], dtype=int)
        self._common = common_error(tuning.common_error, model)
        self._rolling = Rolling(model, tuning.fade)
        self._u, self._turn, self._heading = states.index("u"), states.index("omega_z"), states.index("psi")
        self._motion = [states.index(name) for name in STATE_CHANNELS]
        self._u_limit = by_unit(model.external, tuning.input_limit, 1e9)
        self._y_limit = by_unit(model.y, tuning.output_limit, 1e9)
        self._speed = model.y.names.index("u") if "u" in model.y.names else -1
        self._wheels = [i for i, name in enumerate(model.external.names) if name in WHEEL_CHANNELS]
        self._patience = tuning.patiences(model.y)
        self._measures = np.array([states.names.index(name) if name in states.names else -1 for name in model.y.names])
        self._steer_rate = model.external.names.index("steer_rate") if "steer_rate" in model.external.names else -1
        self._missed = np.array(tuning.output_error) ** 2
        self._change = SoilChange(tuning, len(self._soil))
        self._trial = SoilTrial(tuning, self._q[self._soil])
        self.ukf = UnscentedKalmanFilter(
            model, self._step, q=self._q * self._step, r=np.ones(len(model.y)), x0=states.nominal,
            p0=np.ones(len(states)), gate=tuning.gate, order=factor_order(model),
        )  # fmt: skip
        self.set_sensors(r_std)
        self.start(states.nominal, tuning.std0(states, tuning.sensor_floor))

    def set_sensors(self, r_std: ArrayLike) -> None:
        """Take r_std (n_y,) for the standard deviations of the measurements, before a drive."""
        self._r = np.asarray(r_std, dtype=float) ** 2 + self._missed
        self.ukf.set_measurement_noise(self._r)
        self.drift = DriftMonitor(self._noise_scale(np.asarray(r_std, dtype=float)))

    def start(self, x0: ArrayLike, std0: ArrayLike, t: float = 0.0, learn: bool = True) -> None:
        """Begin a drive at x0 (n_x,) with standard deviations std0 (n_x,) at t (s); learn: whether n is estimated, else it
        stays what it is or is set to. Raises ValueError as the filter's constructor does.
        """
        std0 = np.array(std0, dtype=float)
        self._q = self.tuning.q_std(self.model.x) ** 2
        if not learn:
            std0[self._soil] = self._q[self._soil] = 0.0
        self.learn, self.t, self._run_in_to = learn, t, t + self.tuning.run_in
        self.ukf.restart(x0, std0**2)
        self.ukf.set_process_variance(range(len(self._q)), self._q * self._step)
        self.status = FilterStatus()
        self.changes: list[float] = []
        self.revoked: list[float] = []
        self._trial.end()
        self.drift.start(t)
        self._reversing, self._kicks, self._rate = False, False, 0.0
        self._missing, self._unknown, self._fresh = 0.0, False, True
        self._runs = np.zeros(len(self.model.y), dtype=int)
        # Twice the time: the first seconds are convergence from the first guess, not a change.
        self._change.forget(t + 2 * self.tuning.change_after)

    def predict(self, u: ArrayLike, known: bool = True, fresh: bool = True) -> None:
        """Time update over dt with the external inputs u (n_u,) held; NaN where one is missing, which keeps its last value. Where
        one is missing for longer than `held_inputs`, or they are not `known`, or the soil is not `fresh` but an own rut,
        velocities follow their sensors as in a kick; n is held in a rut."""
        u = np.asarray(u, dtype=float)
        if not np.all(np.abs(u) <= self._u_limit):
            u = np.where(np.abs(u) <= self._u_limit, u, np.nan)
        self._missing = 0.0 if np.isfinite(u).all() else self._missing + self.dt
        self._fresh = fresh
        self._unknown = not known or not fresh or self._missing > self.tuning.held_inputs + CLOCK_SLACK
        refused = False
        for _ in range(self._parts):
            standing = self._reversing or self.ukf.at(self._u) < self.tuning.standstill
            if standing:
                self._stand(self.ukf.take_inputs(u))
            elif not self._move(u):
                refused = True
                self._stand(self.ukf.held_inputs)
            self._stay_below_ceilings()
            u = self.ukf.held_inputs
        if standing:
            self._wait()
        self.t += self.dt
        if self._unknown:
            self.drift.wait(self.t)
        self._rate = float(u[self._steer_rate]) if self._steer_rate >= 0 else 0.0
        self.status = FilterStatus(standing=standing, refused=refused, drift=self.drift.level)

    def update(self, y: ArrayLike) -> Innovation:
        """Measurement update with y (n_y,) taken now; NaN where nothing was measured."""
        y = np.asarray(y, dtype=float)
        if not np.all(np.abs(y) <= self._y_limit):
            y = np.where(np.abs(y) <= self._y_limit, y, np.nan)
        if self._speed >= 0 and math.isfinite(y[self._speed]):
            self._reversing = bool(y[self._speed] < -self.tuning.standstill)
        hold = self.status.standing or self._reversing
        self.ukf.hold(self._soil if hold or not self._fresh else ())
        before, cov = self.ukf.x, self.ukf.P
        seen = self.ukf.update(y)
        if not math.isfinite(self.ukf.x.sum() + self.ukf.variance.sum()):
            self.ukf.undo_update()
            self.status = FilterStatus(hold, refused=True)
            return seen
        kicked = self._unknown or abs(self._rate) > self.tuning.fastest  # then velocities follow their sensors, which is no drift
        drifting = bool(seen.dof) and not hold and not kicked and self._drifts(before)
        jumped = self._believe_jumps(seen, y) if seen.dof < len(seen.used) or self._runs.any() else ()
        looks = bool(seen.dof) and self.learn and not hold and self._fresh
        kept = looks and self._soil_kept()
        changed = looks and not kept and self._soil_changed(seen, cov, kicked)
        self._stay_below_ceilings()
        gated = tuple(n for n, used, v in zip(self.model.y.names, seen.used, y, strict=True) if not used and v == v)
        name = CHANNELS[self.drift.channel].name if drifting else ""
        self.status = FilterStatus(hold, gated, jumped, changed, kept, self.status.refused, self.drift.level, name)
        return seen

    @property
    def n(self) -> Array:
        """(A,) estimate of n: of both axles, or of front and rear."""
        return np.array([self.ukf.at(i) for i in self._soil])

    @property
    def n_std(self) -> Array:
        """(A,) its standard deviation, 0 of an n that is not estimated."""
        common = self._common * self.n if self.learn else np.zeros(len(self._soil))
        return np.sqrt(self.ukf.variance[self._soil] + common**2)

    @property
    def on_trial(self) -> tuple[float, float] | None:
        """When n last jumped (s) and what it was before, where nothing has borne that out yet; else None."""
        return None if self._trial.over else (self._trial.t, float(self._trial.n.mean()))

    def set_n(self, n: float) -> None:
        """Set n of a filter that does not learn."""
        if not self.learn:
            x = self.ukf.x
            x[self._soil] = n
            self.ukf.x = x

    def _move(self, u: Array) -> bool:
        """One step of the model; False where it has no usable answer, and nothing was done."""
        before = self.ukf.x
        rate = float(u[self._steer_rate]) if self._steer_rate >= 0 else 0.0
        if not math.isfinite(rate):
            rate = self._rate
        kicks = self._unknown or self.t < self._run_in_to - CLOCK_SLACK or abs(rate) > self.tuning.fastest
        if kicks != self._kicks:
            self._kicks = kicks
            noise = (self._q + self._kick * kicks) * self._step
            self.ukf.set_process_variance(self._kicked, noise[self._kicked])
        self.ukf.predict(u)
        good = bool(np.all(np.abs(self.ukf.x - before) <= LEAP * self._ceiling)) and bool(np.isfinite(self.ukf.P).all())
        if not good:
            self.ukf.undo_prediction()
        return good

    def _stand(self, u: Array) -> None:
        """The soil is held; the vehicle rolls where its wheels turn it to, without forces."""
        turning = not self._wheels or bool(np.any(np.abs(u[self._wheels]) > WHEELS_TURN))
        x, share = self._rolling.step(self.ukf.x, u, self._step, turning)
        q = self._q * self._step
        q[self._soil] = 0.0
        self.ukf.P = share @ self.ukf.P @ share.T + np.diag(q)
        self.ukf.x = x

    def _wait(self) -> None:
        """Times in which nothing is said, or histories are wrong, are of driving: they do not pass for a vehicle that stands."""
        if self._run_in_to > self.t:
            self._run_in_to += self.dt
        self._change.stand(self.t, self.dt)
        self.drift.stand(self.t, self.dt)

    def _stay_below_ceilings(self) -> None:
        """Standard deviations beyond their ceilings are scaled down, which keeps correlations: for long dropouts."""
        variance = self.ukf.variance
        if np.any(variance > self._ceiling**2):
            scale = np.minimum(1.0, self._ceiling / np.sqrt(variance))
            self.ukf.P = self.ukf.P * np.outer(scale, scale)

    def _believe_jumps(self, seen: Innovation, y: Array) -> tuple[str, ...]:
        """Put states where their measurements are, which have failed the gate to one side for as long as the patience lasts."""
        there = np.isfinite(y)
        side = np.where(seen.value > 0, 1, -1)
        run = np.where(self._runs * side > 0, self._runs + side, side)
        self._runs = np.where(there & seen.used, 0, np.where(there, run, self._runs))
        due = np.flatnonzero((np.abs(self._runs) >= self._patience) & (self._patience > 0))
        for i in due:
            if self._measures[i] >= 0:
                self.ukf.jump(int(self._measures[i]), float(seen.value[i]), self._r[i])
            self._runs[i] = 0
        return tuple(self.model.y.names[i] for i in due)

    def _noise_scale(self, sensor: Array) -> Array:
        """(9,) factor on the limit of each drift channel, for a sensor (n_y,) that is noisier than the floor."""
        floor = dict(zip(self.model.y.names, self.tuning.sensor_floor, strict=False))
        noise = dict(zip(self.model.y.names, sensor, strict=True))
        return np.array([max(1.0, noise[c.state] / floor[c.state]) if c.state in floor else 1.0 for c in CHANNELS])

    def _drifts(self, before: Array) -> bool:
        """Whether corrections have gone to one side for too long; before (n_x,): the estimate before this one."""
        moved = self.ukf.x - before
        motion = (float(before[self._heading]), float(before[self._u]), float(before[self._turn]))
        return self.drift.see(self.t, moved[self._motion], float(moved[self._soil].mean()), motion, self._rate)

    def _soil_changed(self, seen: Innovation, cov: Array, kicked: bool) -> bool:
        """Whether n has jumped, and was put there and opened; cov (n_x, n_x): before the update; kicked: it says nothing of n."""
        score = information = np.zeros(len(self._soil))
        use = seen.used & (self._measures >= 0)
        known = cov[self._soil, self._soil]
        if not kicked and np.all(known > 0):
            share = cov[np.ix_(self._soil, self._measures[use])] / known[:, None]
            score, information = evidence(seen.value[use], (seen.covariance.diagonal() - self._missed)[use], share)
        jump = self._change.see(self.t, score, information)
        if not jump.any():
            return False
        rows = self._soil[jump != 0]
        self._trial.begin(self.t, self.n, self.ukf.variance[self._soil], jump != 0)
        self.ukf.open(rows, np.full(len(rows), self.tuning.change_std**2), jump[jump != 0])
        self._change.forget(self.t + self.tuning.change_after)
        self.changes.append(self.t)
        return True

    def _soil_kept(self) -> bool:
        """Whether a jump was revoked: what was known of n before it counts again."""
        if self._trial.over:
            return False
        old = self._trial.judge(self.t, self.n, self.ukf.variance[self._soil])
        for row, n, variance in zip(self._soil, self._trial.n, old, strict=True):
            if variance > 0:
                self.ukf.open(np.array([row]), np.array([self.tuning.change_error**2]), np.zeros(1))
                self.ukf.know(int(row), float(n), float(variance))
        if not old.any():
            return False
        self._change.forget(self.t)
        if self._trial.over and not self._trial.stands:
            self.changes.remove(self._trial.t)
            self.revoked.append(self._trial.t)
        return True


def first_state(model: Model, motion: Sequence[float] | Array, n0: float) -> Array:
    """(n_x,) first state of a terrain model: motion (6,), the initial guess n0, nominal values of what an effect brings."""
    return np.array([*motion, *(n0 if x.name in N_NAMES else x.nominal for x in tuple(model.x)[len(motion) :])])
