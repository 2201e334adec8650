"""A driver: estimator, model predictive control and the following of plans in one object that any vehicle can call.

driver = Driver(declaration, path, speed=6.0, n0=0.7)
while not command.finished:
    command = driver.tick(t, vehicle.measure())
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.control.declared import for_control
from softsoil.control.driver_checks import (
    check_names,
    check_speed,
    checked_n0,
    checked_obstacles,
    checked_path,
    checked_start,
)
from softsoil.control.driver_types import (
    CONTESTED,
    CONTESTED_SIGMAS,
    IDENTIFIED,
    INCONSISTENT,
    MEASURED,
    NOT_JUDGED,
    STANDING_SHARE,
    DriverCommand,
    DriverSettings,
    Judge,
    Measured,
)
from softsoil.control.follower import PlanFollower
from softsoil.control.horizon import reference, watched
from softsoil.control.inbox import Inbox, as_states, given
from softsoil.control.live_estimator import FIRST_SPREAD, LiveEstimator
from softsoil.control.live_steering import LiveSteering
from softsoil.control.motion_watch import MotionWatch
from softsoil.control.nmpc import Nmpc
from softsoil.control.nmpc_settings import SETTINGS
from softsoil.control.nmpc_status import Status
from softsoil.control.ocp import Ocp
from softsoil.control.path import Path
from softsoil.control.tick_clock import TickClock
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.terrain_filter import FilterStatus
from softsoil.recording.drive import STATE_CHANNELS, UNSEEN, WHEEL_CHANNELS
from softsoil.recording.geometry import radius_of
from softsoil.symbolic.soil import SOIL_SIGNALS

Array = NDArray[np.float64]


class Driver:
    """Drives a path at a speed.

    model: a Declaration (vehicle, soil, effects), or an Ocp with settings of its own; path; speed: m/s, inside the controller's
    limits of u (`OcpSettings.speed`, 0.5 to 12 m/s unless set), so that no speed stops a vehicle: to stop, end the drive and
    brake, as from `finished` on; obstacles (K, 5): x, y, radius (m) and velocity (m/s), at the time of the first tick 0; n0:
    first guess of n, default the declared soil's; learn: whether n is estimated, else it stays n0 or what `set_n` sets; settings;
    solver, estimator: used again from drive to drive; judge: a second estimate of n with a verdict (`LiveHorizon`), "not_judged"
    without one; start (6,): first state where it is known, else it comes from the first measurements.
    Raises TypeError for a model, path or speed of another kind, ValueError for a speed out of those limits, an n0 out of bounds,
    obstacles or a start of another shape or with numbers that are not finite, a negative radius.
    """

    def __init__(
        self, model: Declaration | Ocp, path: Path, speed: float, obstacles: ArrayLike = (), n0: float | None = None,
        learn: bool = True, *, settings: DriverSettings | None = None, solver: Nmpc | None = None,
        estimator: LiveEstimator | None = None, judge: Judge | None = None, start: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        self.ocp = _problem(model)
        self.settings = settings or DriverSettings()
        self.path, self.speed = checked_path(path), speed
        self.obstacles = checked_obstacles(obstacles)
        self.n0 = checked_n0(float(self.ocp.model.p["n_f"].nominal) if n0 is None else n0)
        self._known = checked_start(start)
        self.learn, self.judge = learn, judge
        self.solver = solver or Nmpc(self.ocp)
        self.estimator = estimator or LiveEstimator(self.ocp.model, self.settings.sensor_std, tick=self.settings.tick)
        self.follower = PlanFollower(self.ocp.settings.dt, self.settings.tick)
        self.steering = LiveSteering(
            self.ocp.vehicle.max_steer_rate, self.settings.tick, self.settings.steering_gap, self.settings.actuator_lag
        )
        self.slip, self.steer_rate, self.a_x = self.ocp.settings.slip, 0.0, 0.0
        self.resistance = 0.0
        self.along, self.left, self._ticks, self._solves = 0.0, 0.0, 0, 0
        self.inbox = Inbox(self.settings.tick)
        vehicle, std = self.ocp.vehicle, self.settings.sensor_std
        self.watch = MotionWatch(vehicle.l_f, vehicle.l_r, max(std[:2]), std[2])
        self._begun: float | None = None
        self.clock, self._corrected = TickClock(self.settings.dead_reckoning), math.nan
        self._waiting: tuple[int, tuple] | None = None
        self._unused = np.full(len(STATE_CHANNELS), math.nan)
        self._halting, self._still, self.status = 0, 0, Status.NO_STATE
        self.verdict = NOT_JUDGED
        """On the estimated n, of the last tick: that of `judge` unless the filter contests its n, "not_judged" without one."""

    @property
    def speed(self) -> float:
        """Speed to drive at (m/s); ValueError where one is set that is out of the controller's limits."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        check_speed(speed, self.ocp.settings.speed)
        self._speed = float(speed)

    def set_n(self, n: float) -> None:
        """Set n of a driver that does not learn."""
        if self._begun is not None:
            self.estimator.set_n(n)
        elif not self.learn:
            self.n0 = n

    def tick(self, t: float, measured: Measured) -> DriverCommand:
        """The command from t (s) on, from what was measured since the last call; call it every `settings.tick` seconds.

        The filter takes steps of `settings.tick` up to t: a late call is predicted over, and after a pause longer than
        `settings.dead_reckoning`, or a clock set back by more, the drive begins anew where the vehicle is measured, with the last
        n as its first guess. Raises ValueError for a t that is not finite or less far before the last tick's, or a name in
        `measured` that is not known: then nothing was done.
        """
        back, solved = self.clock.check(t), False
        check_names(measured, MEASURED)
        self.clock.take(t, back)
        if back:  # nothing that was measured or planned has an age
            self.inbox = self.inbox.emptied()
            self.follower.forget()
        if self._begun is not None and (back or t - self.inbox.at > self.settings.dead_reckoning):
            self.n0, self._begun, self._known, self.status = self.estimator.n, None, None, Status.NO_STATE
            self.along, self.left, self._corrected = 0.0, 0.0, math.nan
            self.watch.forget()
        known = self.inbox.take(t, measured)
        self.watch.take(t, measured, self._steering(measured))
        if self._begun is None:
            self._begin(t)
        elif steps := self.inbox.steps(t):
            self._estimate(t, known, steps)
        if self._begun is not None:
            self.verdict = NOT_JUDGED if self.judge is None else self._verdict(self.judge)
            if self._ticks % self.settings.plan_every == 0:
                self._solve(t)
                solved = True
            if self._waiting is not None and self._ticks >= self._waiting[0]:
                self.follower.take(*self._waiting[1])
                self._waiting = None
            self._ticks += 1
        lost = self.follower.lost(t)
        before = self.steering.command
        steer, speed, self.a_x = self.follower.command(t + self.settings.tick, before, self.steering.lag)
        if not lost:  # the lock is a soft limit of plans; from a command beyond it none leads further out
            low, high = self.ocp.state_box["steer"]
            steer = min(max(steer, min(low, before)), max(high, before))
        self.steering.ask(steer)
        self.steer_rate = (steer - before) / self.settings.tick
        return self._command(t, speed, lost, solved)

    def _begin(self, t: float) -> None:
        """Start where the vehicle is known or was measured to be just now; wait where it is neither."""
        measured = self.inbox.recent(t)
        first, spread = self._known, np.array(FIRST_SPREAD)
        if first is None:
            first, spread = as_states(measured), np.array(self.settings.sensor_std)
            needed = [STATE_CHANNELS.index(name) for name in ("x", "y", "psi", "u")]
            if not np.isfinite(first[needed]).all():
                return
            spread = np.where(np.isfinite(first), spread, UNSEEN)
            spread[:2] += abs(first[needed[3]]) * np.array([self.inbox.age(t, name) for name in ("x", "y")])
            first = np.where(np.isfinite(first), first, 0.0)
        self._begun = self._corrected = t
        self.clock.begin(t)
        self.steering.begin(self._steering(measured))
        self._ticks, self._waiting, self._halting = 0, None, 0
        self._unused = np.full(len(STATE_CHANNELS), math.nan)
        self.inbox.begin(t)
        self.estimator.start(first, self.n0, self.learn, spread)
        if self.judge is not None:
            self.judge.start(t, self.n0)
        self.along, self.left = self.path.project(first[0], first[1])
        n = self.ocp.settings.steps
        z = np.tile(self.ocp.z.nominal, (n + 1, 1))
        named = [self.ocp.z.index(name) for name in ("x", "y", "psi", "u")]
        z[:, named] = reference(self.ocp, self.path, self.along, max(first[3], SETTINGS.slowest), self._z0())
        z[:, named[3]] = max(first[3], SETTINGS.slowest)
        z[:, self.ocp.z.index("steer")] = self.steering.wheels
        self.solver.set_initial_guess(z, np.zeros((n, len(self.ocp.w))))
        self._follow_from(t, z, np.zeros((n, len(self.ocp.w))), False)

    def _estimate(self, t: float, measured: Measured, steps: int) -> None:
        """Filter and slip over so many steps of the filter; what was measured counts at the end of the last."""
        states = self.estimator.states
        steer = self.steering.take(self._steering(measured), steps)
        u, v, omega_z = (states[STATE_CHANNELS.index(name)] for name in ("u", "v", "omega_z"))
        accelerometer = given(measured, "a_x_imu", np.nan)
        slowest = -u / (steps * self.settings.tick)  # brakes hold a vehicle that stands
        a_x = accelerometer + v * omega_z if np.isfinite(accelerometer) else max(self.a_x, slowest)
        wheels = {name: given(measured, name, np.nan) for name in WHEEL_CHANNELS}
        rims = [radius_of(self.ocp.vehicle, name) * speed for name, speed in wheels.items()]
        slip, way = self.slip, float(np.mean(rims))
        if not np.isfinite(way):
            inputs = self.solver.model_inputs(
                self._z0(), np.array([self.steer_rate, a_x]), self._parameters(self.estimator.n)
            )
            assumed = dict(zip(self.ocp.model.external.names, inputs, strict=True))
            wheels = {name: value if np.isfinite(value) else assumed[name] for name, value in wheels.items()}
        elif max(abs(u), way) >= self.settings.standing:  # wheels of a vehicle that stands do not slip
            slip = float(np.clip(1.0 - u / max(way, 0.1), -0.3, 0.6))
        sample, fresh = {"steer": steer, "steer_rate": self.steer_rate, "a_x": a_x, **wheels}, as_states(measured)
        y, nothing = np.where(np.isfinite(fresh), fresh, self._unused), np.full_like(fresh, math.nan)
        for left in reversed(range(steps)):
            self.estimator.tick(sample, nothing if left else y)
            if self.judge is not None:
                self.judge.tick(t - left * self.settings.tick, sample, nothing if left else fresh)
        self._unused = nothing if self.estimator.updated else y
        if self.estimator.corrected:
            self._corrected = t
        self.slip += self.settings.slip_share * (slip - self.slip)

    def _solve(self, t: float) -> None:
        solver, z0 = self.solver, self._z0()
        self.along, self.left = self.path.project(z0[0], z0[1], self.along if self._solves else None)
        u = float(z0[self.ocp.z.index("u")])
        self._resist(t, u)
        self.solver.limit_speed(max((1.0 + self.settings.overspeed) * self.speed, u))
        s = self._parameters(self.n_used)
        if self._solves:
            solver.shift(self.settings.period)
        ref = reference(self.ocp, self.path, self.along, self.speed, z0)
        places = watched(self.ocp, self.obstacles, t - self.clock.origin, z0, ref)
        solver.set_parameters(s, solver.histories(self.estimator.filter.memory, s), ref, places)
        self._solves += 1
        solver.make_step(z0)
        stats = solver.stats
        self.status = Status.LATE if stats.seconds > self.settings.period and stats.status.usable else stats.status
        if stats.status.usable:
            took = max(1, int(np.ceil(stats.seconds / self.settings.tick))) if self.settings.wall else 1
            fault = self._fault(t)
            self.status = fault or self.status
            self._follow_from(t, solver.z, solver.w, self._must_halt(z0, fault is not None), self._ticks + took)

    def _resist(self, t: float, u: float) -> None:
        """Take in what the vehicle is slower at t (s), at the speed u (m/s), than the plan of a period ago has it."""
        if self._solves and not self.follower.lost(t) and not self.follower.halt:
            short = (self.follower.command(t, 0.0)[1] - u) / self.settings.period
            most = (STANDING_SHARE if abs(u) < self.settings.standing else 1.0) * self.settings.most_resistance
            self.resistance = float(np.clip(self.resistance + self.settings.resistance_share * short, -most, most))

    def _follow_from(self, t: float, z: Array, w: Array, halt: bool, ready: int | None = None) -> None:
        """Follow a plan at once, or from the tick `ready` on."""
        steer, u, a_x = self.ocp.z.index("steer"), self.ocp.z.index("u"), self.ocp.w.index("a_x")
        plan = (t, z[:, steer].copy(), z[:, u].copy(), w[:, a_x].copy(), halt)
        if ready is None:
            self.follower.take(*plan)
        else:
            self._waiting = (ready, plan)

    def _fault(self, t: float) -> Status | None:
        """What halts the vehicle at t (s): position and velocity not measured for too long, a position that is too uncertain,
        measurements that disagree, or a steering that does not follow."""
        late = t - self._corrected > self.settings.dead_reckoning
        if late or self.estimator.position_std > self.settings.most_position_std:
            return Status.POSITION_UNKNOWN
        if self.watch.disagree:
            return Status.SENSORS_DISAGREE
        return Status.STEERING_STUCK if self.steering.stuck else None

    def _must_halt(self, z0: Array, fault: bool) -> bool:
        """Whether the brakes are due: for a fault, or the plan meets an obstacle that is near; then until plans are clear for a
        while."""
        stage = self.solver.stats.touch
        if fault:
            self._halting = SETTINGS.clear_steps
        elif stage < 0:
            self._halting = max(self._halting - 1, 0)
        elif self._halting:
            self._halting = SETTINGS.clear_steps
        else:
            moves = np.diff(self.solver.z[: stage + 1, :2], axis=0)
            due = self.follower.must_halt(float(z0[self.ocp.z.index("u")]), float(np.hypot(*moves.T).sum()))
            self._halting = SETTINGS.clear_steps if due else 0
        return self._halting > 0

    def _command(self, t: float, speed: float, lost: bool, solved: bool) -> DriverCommand:
        known = self._begun is not None
        u = float(self.estimator.states[STATE_CHANNELS.index("u")]) if known else 0.0
        slow = known and (self.follower.halt or lost) and abs(u) < self.settings.standing
        self._still = self._still + 1 if slow else 0
        drives = known and not lost and not self.follower.halt
        asked = self.a_x + (self.settings.speed_gain * (speed - u) + self.resistance if drives else 0.0)
        estimate = self._sure or self.estimator
        ends = self.along > self.path.s[-1] - self.settings.end and self.status is not Status.POSITION_UNKNOWN
        return DriverCommand(
            t, self.steering.command, self.steer_rate, speed, self.a_x, asked, self.status, lost, self.follower.halt,
            bool(ends), self._still * self.settings.tick > self.settings.stands,
            estimate.n if known else self.n0, estimate.n_std if known else self.estimator.tuning.n_std,
            self.n_used if known else self.n0, self.verdict, self.slip, self._z0() if known else self.ocp.z.nominal, solved,
            self.solver.z.copy(), self.solver.w.copy(), self.along, self.left,
            math.nan if self.ocp.vehicle.steering is None else float(self.ocp.vehicle.steering.command_of(self.steering.command)),
            self.estimator.status if known else FilterStatus(), self.estimator.position_std if known else math.nan,
            t - self._corrected, self.steering.lag, self.watch.disagree,
        )  # fmt: skip

    def _steering(self, measured: Measured) -> float:
        """Angle at the road wheels (rad): measured, or by the vehicle's steering map from a measured command, else NaN."""
        command, steering = given(measured, "steer_command", math.nan), self.ocp.vehicle.steering
        mapped = steering is not None and math.isfinite(command)
        return given(measured, "steer", float(steering.angle_of(command)) if steering is not None and mapped else math.nan)

    def _verdict(self, judge: Judge) -> str:
        """The judge's verdict, "inconsistent" where the filter is sure of another n than the one that it calls identified, or
        measurements disagree."""
        own, apart = self.estimator, abs(judge.n - self.estimator.n)
        contested = apart > max(CONTESTED * own.n, CONTESTED_SIGMAS * math.hypot(judge.n_std, own.n_std))
        doubted = contested or bool(self.watch.disagree)
        return INCONSISTENT if self.learn and doubted and judge.verdict == IDENTIFIED else judge.verdict

    @property
    def _sure(self) -> Judge | None:
        """The judge, where its n may be used."""
        return self.judge if self.learn and self.verdict == IDENTIFIED else None

    @property
    def n_used(self) -> float:
        """The n that the controller drives on: the estimate, on the safe side while it is uncertain; see `DriverSettings`."""
        n = self.estimator.n
        if self._sure is not None:
            return self._sure.n
        if not self.learn:
            return n
        more = self.settings.caution * (self.estimator.n_std - self.settings.settled)
        return min(n + float(np.clip(more, 0.0, self.settings.most)), SOIL_SIGNALS["n"].upper)

    def _z0(self) -> Array:
        return np.append(self.estimator.states, self.steering.wheels)

    def _parameters(self, n: float) -> Array:
        p = self.ocp.model.p.pack(n_f=n, n_r=n)
        return np.concatenate([p, [self.slip, self.ocp.settings.slip_gain]])


def _problem(model: Declaration | Ocp) -> Ocp:
    if isinstance(model, Ocp):
        return model
    declared = for_control(model)
    return Ocp(declared.build(), declared.vehicle)
