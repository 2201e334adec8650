"""The loop closed on the plant: sensors at 12 ms, estimator at 12/24 ms, NMPC at 48 ms on the estimate, plant at 2 ms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from softsoil.control.courses import WARM_UP
from softsoil.control.nmpc import Nmpc
from softsoil.control.nmpc_status import Status
from softsoil.control.ocp import Ocp
from softsoil.estimator.terrain import Tuning
from softsoil.mpc_demo.closed_loop_parts import (
    TICK,
    Faults,
    LoopEstimator,
    NoisySensors,
    Pedals,
    PlanFollower,
    wheel_slip,
)
from softsoil.mpc_demo.scenarios import Scenario
from softsoil.plant.start import Start
from softsoil.plant.world import Plant, Sample
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.noise import TABLE5

Array = NDArray[np.float64]

CONTROLLERS = ("n_guess", "n_true", "n_estimated")
"""Who is told a wrong n, who the true one, and who finds it."""
EVERY = 4
"""Ticks between solves."""
DEADLINE = EVERY * TICK
"""s: a solution that takes longer is late."""
WIDTH = 0.75
"""m: radius of the circles at both axles that touch an obstacle, for the judgement."""
CLEAR_SOLVES = 20
"""A vehicle that brakes before an obstacle goes on after so many plans in a row that clear it."""
STANDING, STANDS = 0.5, 1.0
"""m/s, s: a vehicle that brakes to a halt and has been slower for so long has stopped, and the drive ends."""


@dataclass
class LoopLog:
    """What happened, one row per solve unless said otherwise.

    t; truth (K, 6), estimate (K, 6): x, y, psi, u, v, omega_z; n, n_std; steer; a_x; error: true distance left of the path
    (m); clearance: of the nearest obstacle (m, inf for none); along: length along the path (m); solve_ms; status: names;
    halt: braking before what cannot be passed; plans: predicted x, y of every solve (K, N + 1, 2); gated: measurements left
    out; finished: came to the end of the course; stopped: came to a stand before an obstacle.
    """

    scenario: str
    controller: str
    seed: int
    rows: list[dict] = field(default_factory=list)
    plans: list[Array] = field(default_factory=list)
    gated: int = 0
    finished: bool = False
    stopped: bool = False

    def column(self, name: str) -> Array:
        """(K, ...) of the named quantity."""
        return np.array([row[name] for row in self.rows])

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Rows after the warm-up."""
        return self.column("along") > WARM_UP

    @property
    def tracking_rms(self) -> float:
        """rms distance from the path after the warm-up (m)."""
        error = self.column("error")[self.judged]
        return float(np.sqrt(np.mean(error**2))) if len(error) else float("nan")

    @property
    def max_error(self) -> float:
        """Largest distance from the path after the warm-up (m)."""
        return float(np.max(np.abs(self.column("error")[self.judged]), initial=0.0))

    @property
    def clearance(self) -> float:
        """Least distance to an obstacle (m); inf where there is none."""
        return float(self.column("clearance").min())

    @property
    def collided(self) -> bool:
        """Whether an obstacle was touched."""
        return self.clearance <= 0.0

    @property
    def failures(self) -> int:
        """Solves whose plan could not be used."""
        return sum(not Status[name].usable for name in self.column("status"))

    @property
    def late(self) -> int:
        """Solves that took longer than their period."""
        return int(np.count_nonzero(self.column("solve_ms") > 1e3 * DEADLINE))


class ClosedLoop:
    """NMPC and estimator on the plant.

    ocp: the problem; solver: of it (shared between runs: it is told a new guess at each start); wall: a plan is
    followed from as many ticks on as its solve took, at least one; else always from the next tick on, which makes runs
    repeat to the bit; tuning: of the estimator.
    """

    def __init__(self, ocp: Ocp, solver: Nmpc, wall: bool = True, tuning: Tuning | None = None) -> None:
        self.ocp, self.solver, self.wall = ocp, solver, wall
        self.estimator = LoopEstimator(ocp.model, np.array([TABLE5[name] for name in STATE_CHANNELS]), tuning)
        # The first solve builds machine code, which no vehicle should wait for.
        solver.make_step(ocp.z.nominal)

    def run(
        self, scenario: Scenario, controller: str, seed: int = 0, faults: Faults | None = None,
        disturb: Callable[[int], bool] | None = None,
    ) -> LoopLog:  # fmt: skip
        """Drive the course once.

        controller: of CONTROLLERS; seed: of the sensor noise; disturb: told the number of a solve, says whether that solve is
        made to fail (to see what the loop then does). Raises ValueError for an unknown controller.
        """
        if controller not in CONTROLLERS:
            raise ValueError(f"controller: expected one of {', '.join(CONTROLLERS)}; found {controller!r}")
        return _Run(self, scenario, controller, seed, faults or Faults(), disturb).drive()


class _Run:
    """One drive."""

    def __init__(
        self, loop: ClosedLoop, scenario: Scenario, controller: str, seed: int, faults: Faults, disturb
    ) -> None:
        self.ocp, self.solver, self.wall = loop.ocp, loop.solver, loop.wall
        self.scenario, self.controller, self.disturb = scenario, controller, disturb
        self.sensors = NoisySensors(seed, faults)
        x, y, psi = scenario.path.at(np.zeros(1))[0]
        self.plant = Plant(scenario.soil, start=Start(x=x, y=y, psi=psi, u=scenario.speed))
        n0 = scenario.n_true(0.0) if controller == "n_true" else scenario.n_guess
        first = np.array([x, y, psi, scenario.speed, 0.0, 0.0])
        self.estimator = loop.estimator
        self.estimator.start(first, n0, controller == "n_estimated")
        self.follower, self.pedals = PlanFollower(self.ocp.settings.dt), Pedals()
        self.slip = self.ocp.settings.slip
        self.steer = self.along = 0.0
        self.waiting: tuple[int, tuple] | None = None
        self.still = self.halting = 0
        self.log = LoopLog(scenario.name, controller, seed)
        self._first_guess(first)

    def _first_guess(self, x0: Array) -> None:
        n, dt = self.ocp.settings.steps, self.ocp.settings.dt
        places = self.scenario.path.at(x0[3] * dt * np.arange(n + 1))
        z = np.stack([self.ocp.z.pack(x=p[0], y=p[1], psi=p[2], u=x0[3]) for p in places])
        self.solver.set_initial_guess(z, np.zeros((n, 2)))
        self.follower.take(0.0, z[:, -1], z[:, 3], np.zeros(n))

    def drive(self) -> LoopLog:
        """Tick after tick until the course is done, or twice its time is over."""
        ticks = round(2.0 * self.scenario.seconds / TICK)
        sample = self.plant.sample()
        for tick in range(ticks):
            t = tick * TICK
            if tick % EVERY == 0:
                self._solve(tick // EVERY, t, sample)
            if self.waiting is not None and tick >= self.waiting[0]:
                self.follower.take(*self.waiting[1])
                self.waiting = None
            before = self.steer
            self.steer, wanted, a_x = self.follower.command(t + TICK, before)
            throttle, brake = self.pedals(a_x, wanted, float(self.estimator.states[3]))
            sample = self.plant.step((self.steer, throttle, brake), TICK)
            self._estimate(t + TICK, sample, (self.steer - before) / TICK)
            if self.along > self.scenario.path.s[-1] - 2.0:
                self.log.finished = True
                break
            if self._has_stopped(t):
                self.log.stopped = True
                break
        self.log.gated = self.estimator.gated
        return self.log

    def _estimate(self, t: float, sample: Sample, steer_rate: float) -> None:
        states = self.estimator.states
        self.estimator.set_n(
            self.scenario.n_true(sample["x"]) if self.controller == "n_true" else self.scenario.n_guess
        )
        inputs = {name: sample[name] for name in ("omega_fl", "omega_fr", "omega_rl", "omega_rr")}
        a_x = sample["a_x_imu"] + states[4] * states[5]
        self.estimator.tick(
            {"steer": self.steer, "steer_rate": steer_rate, "a_x": a_x, **inputs}, self.sensors.read(t, sample)
        )
        self.slip += 0.02 * (wheel_slip(sample, states[3], self.ocp.vehicle.radius) - self.slip)

    def _solve(self, number: int, t: float, sample: Sample) -> None:
        solver, scenario, dt = self.solver, self.scenario, self.ocp.settings.dt
        states = self.estimator.states
        z0 = np.append(states, self.steer)
        self.along, _ = scenario.path.project(z0[0], z0[1], self.along if number else None)
        n = self.estimator.n
        p = self.ocp.model.p.pack(n_f=n, n_r=n)
        s = np.concatenate([p, [self.slip, self.ocp.settings.slip_gain]])
        if number:
            solver.shift(DEADLINE)
        r = solver.histories(self.estimator.filter.memory, s)
        solver.set_parameters(s, r, self._reference(z0), self._obstacles(t, z0))
        failed = self.disturb is not None and self.disturb(number)
        solver.make_step(np.full_like(z0, np.nan) if failed else z0)
        stats = solver.stats
        if stats.status.usable:
            # A solution is there one tick later, or as many as it took.
            ready = round(t / TICK) + (max(1, int(np.ceil(stats.seconds / TICK))) if self.wall else 1)
            self.waiting = (ready, (t, solver.z[:, -1], solver.z[:, 3], solver.w[:, 1], self._must_halt(z0)))
        self._note(t, sample, dt)

    def _must_halt(self, z0: Array) -> bool:
        """Whether the plan meets an obstacle so near that the brakes are due; then until plans are clear for a while."""
        stage = self.solver.stats.touch
        if stage < 0:
            self.halting = max(self.halting - 1, 0)
        elif self.halting:
            self.halting = CLEAR_SOLVES
        else:
            moves = np.diff(self.solver.z[: stage + 1, :2], axis=0)
            due = self.follower.must_halt(float(z0[3]), float(np.hypot(*moves.T).sum()))
            self.halting = CLEAR_SOLVES if due else 0
        return self.halting > 0

    def _has_stopped(self, t: float) -> bool:
        """Whether the vehicle has been standing, halted or without a plan."""
        slow = (self.follower.halt or self.follower.lost(t)) and abs(float(self.estimator.states[3])) < STANDING
        self.still = self.still + 1 if slow else 0
        return self.still * TICK > STANDS

    def _reference(self, z0: Array) -> Array:
        n, dt = self.ocp.settings.steps, self.ocp.settings.dt
        pace = self.scenario.speed + (z0[3] - self.scenario.speed) * np.exp(-dt * np.arange(n) / 1.5)
        s = self.along + np.concatenate([[0.0], np.cumsum(dt * pace)])
        places = self.scenario.path.at(s)
        places[:, 2] += 2 * np.pi * np.round((z0[2] - places[0, 2]) / (2 * np.pi))
        return np.column_stack([places, np.full(n + 1, self.scenario.speed)])

    def _obstacles(self, t: float, z0: Array) -> Array:
        """The nearest obstacles that are not yet behind, over the horizon."""
        given, n = self.scenario.obstacles, self.ocp.settings.steps
        if not len(given):
            return np.zeros((n + 1, 0, 3))
        now = given[:, :2] + t * given[:, 3:]
        ahead = (now - z0[:2]) @ np.array([np.cos(z0[2]), np.sin(z0[2])])
        near = np.flatnonzero((ahead > -6.0) & (ahead < 60.0))
        near = near[np.argsort(ahead[near])][: self.ocp.settings.obstacles]
        times = t + self.ocp.settings.dt * np.arange(n + 1)
        placed = np.zeros((n + 1, len(near), 3))
        placed[:, :, :2] = given[near, :2] + times[:, None, None] * given[near, 3:]
        placed[:, :, 2] = given[near, 2]
        return placed

    def _note(self, t: float, sample: Sample, dt: float) -> None:
        x, y, psi = sample["x"], sample["y"], sample["psi"]
        along, error = self.scenario.path.project(x, y, self.along)
        gap = np.inf
        back = self.ocp.vehicle.wheelbase
        for ox, oy, radius, vx, vy in self.scenario.obstacles:
            for behind in (0.0, 0.5 * back, back):
                dx, dy = x - behind * np.cos(psi) - ox - t * vx, y - behind * np.sin(psi) - oy - t * vy
                gap = min(gap, float(np.hypot(dx, dy) - radius - WIDTH))
        stats = self.solver.stats
        late = stats.seconds > DEADLINE and stats.status.usable
        self.log.rows.append(
            {
                "t": t, "truth": [sample[name] for name in ("x", "y", "psi", "u", "v", "omega_z")],
                "estimate": self.estimator.states[:6], "n": self.estimator.n, "n_std": self.estimator.n_std,
                "steer": self.steer, "a_x": float(self.solver.w[0, 1]), "error": error, "along": along, "clearance": gap,
                "solve_ms": 1e3 * stats.seconds, "status": (Status.LATE if late else stats.status).name,
                "safe": self.follower.lost(t), "halt": self.follower.halt, "slip": self.slip,
            }
        )  # fmt: skip
        self.log.plans.append(self.solver.z[:, :2].copy())
