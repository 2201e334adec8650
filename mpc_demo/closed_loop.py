"""The loop closed on the plant: sensors at 12 ms, estimator at 12 ms, NMPC at 48 ms on the estimate, plant at 2 ms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.control.courses import WARM_UP
from softsoil.control.driver import Driver
from softsoil.control.driver_types import NOT_JUDGED, DriverCommand, DriverSettings, Judge
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.nmpc import Nmpc
from softsoil.control.nmpc_status import Status
from softsoil.control.ocp import CIRCLES, Ocp, half_width
from softsoil.control.pedals import Pedals
from softsoil.estimator.tuning import Tuning
from softsoil.mpc_demo.closed_loop_parts import TICK, Faults, NoisySensors
from softsoil.mpc_demo.scenarios import Scenario
from softsoil.plant.machine import PlantVehicle
from softsoil.plant.start import Start
from softsoil.plant.world import SPACING, Plant, Sample
from softsoil.recording.drive import STATE_CHANNELS

Array = NDArray[np.float64]

ESTIMATING = "n_estimated"
CONTROLLERS = ("n_guess", "n_true", ESTIMATING)
"""The three controllers compared: wrong, true and estimated n."""
EVERY = 4
"""Ticks between solves."""
DEADLINE = EVERY * TICK
"""s: a solution that takes longer is late."""
CORNERS = 0.03
"""m: what the circles along the vehicle that touch an obstacle, for the judgement, are wider than half the vehicle."""


@dataclass
class LoopLog:
    """What happened, one row per solve unless said otherwise.

    t; truth (K, 6), estimate (K, 6): x, y, psi, u, v, omega_z; n, n_std: estimate; n_used: what the controller drives on;
    verdict: on n; steer; a_x; error: true distance left of the path (m); clearance: of the nearest
    obstacle (m, inf for none); along: length along the path (m); solve_ms; status: names;
    halt: braking before what cannot be passed; plans: predicted x, y of every solve (K, N + 1, 2); gated: measurements left
    out; finished: came to the end of the course; stopped: came to a stand before an obstacle; warm_up: length that is not judged;
    wheelbase, half_width: of the vehicle (m).
    """

    scenario: str
    controller: str
    seed: int
    rows: list[dict] = field(default_factory=list)
    plans: list[Array] = field(default_factory=list)
    gated: int = 0
    finished: bool = False
    stopped: bool = False
    warm_up: float = WARM_UP
    wheelbase: float = 0.0
    half_width: float = 0.0

    def column(self, name: str) -> Array:
        """(K, ...) of the named quantity."""
        return np.array([row[name] for row in self.rows])

    @property
    def verdict(self) -> str:
        """On n at the end of the drive; "not_judged" of a controller that estimates none."""
        return str(self.rows[-1]["verdict"]) if self.rows else NOT_JUDGED

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Rows after the warm-up."""
        return self.column("along") > self.warm_up

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
    """The driver on the plant.

    ocp: the problem; solver: of it, shared between runs; wall: a plan is followed from as many ticks on as its solve took, at
    least one; else always from the next tick on, which makes runs repeat to the bit; tuning: of the estimator; machine: the
    plant's vehicle, default the reference vehicle; spacing: of its soil's grid (m); noisy: which sensors are, of SENSORS;
    judge: the verdict on an estimated n, default none.
    """

    def __init__(
        self, ocp: Ocp, solver: Nmpc, wall: bool = True, tuning: Tuning | None = None, machine: PlantVehicle | None = None,
        noisy: str = "states", judge: Judge | None = None, spacing: float = SPACING,
    ) -> None:  # fmt: skip
        self.ocp, self.solver, self.machine, self.noisy, self.judge = ocp, solver, machine, noisy, judge
        self.spacing = spacing
        self.settings = DriverSettings(tick=TICK, plan_every=EVERY, wall=wall)
        self.estimator = LiveEstimator(ocp.model, self.settings.sensor_std, tuning, TICK)

    def run(
        self, scenario: Scenario, controller: str, seed: int = 0, faults: Faults | None = None,
        disturb: Callable[[int], bool] | None = None,
    ) -> LoopLog:  # fmt: skip
        """Drive the course once.

        controller: of CONTROLLERS; seed: of the sensor noise; disturb: of the number of a solve, whether that solve is
        made to fail (to see what the loop then does). Raises ValueError for an unknown controller.
        """
        if controller not in CONTROLLERS:
            raise ValueError(f"controller: expected one of {', '.join(CONTROLLERS)}; found {controller!r}")
        return _Run(self, scenario, controller, NoisySensors(seed, faults or Faults(), self.noisy), disturb).drive()


class _Run:
    """One drive."""

    def __init__(self, loop: ClosedLoop, scenario: Scenario, controller: str, sensors: NoisySensors, disturb) -> None:
        self.scenario, self.controller, self.sensors, self.ocp = scenario, controller, sensors, loop.ocp
        x, y, psi = scenario.path.at(np.zeros(1))[0]
        start = Start(x=x, y=y, psi=psi, u=scenario.speed)
        self.plant = Plant(scenario.soil, vehicle=loop.machine, start=start, spacing=loop.spacing)
        learn = controller == ESTIMATING
        solver: Any = loop.solver if disturb is None else FailingSolver(loop.solver, disturb)
        self.driver = Driver(
            loop.ocp, scenario.path, scenario.speed, scenario.obstacles, self._n(0.0), learn,
            settings=loop.settings, solver=solver, estimator=loop.estimator, judge=loop.judge if learn else None,
            start=[x, y, psi, scenario.speed, 0.0, 0.0],
        )  # fmt: skip
        self.log = LoopLog(scenario.name, controller, sensors.seed, warm_up=scenario.warm_up)
        self.log.wheelbase, self.log.half_width = loop.ocp.vehicle.wheelbase, half_width(loop.ocp.vehicle)

    def _n(self, x: float) -> float:
        return self.scenario.n_true(x) if self.controller == "n_true" else self.scenario.n_guess

    def drive(self) -> LoopLog:
        """Tick after tick until the course is done, or twice its time is over."""
        pedals, sample = Pedals(tick=TICK), self.plant.sample()
        measured: dict[str, float] = {}
        for k in range(round(2.0 * self.scenario.seconds / TICK)):
            self.driver.set_n(self._n(sample["x"]))
            steer = self.driver.steering.wheels
            command = self.driver.tick(k * TICK, measured)
            if command.solved:
                self._note(sample, command, steer)
            self.log.finished, self.log.stopped = command.finished, command.stopped
            if command.finished or command.stopped:
                break
            throttle, brake = pedals(command.a_asked, command.speed, float(command.state[3]))
            sample = self.plant.step((command.steer, throttle, brake), TICK)
            measured = self.sensors.measure((k + 1) * TICK, sample)
        self.log.gated = self.driver.estimator.gated
        return self.log

    def _note(self, sample: Sample, command: DriverCommand, steer: float) -> None:
        x, y, psi, t = sample["x"], sample["y"], sample["psi"], command.t
        along, error = self.scenario.path.project(x, y, command.along)
        gap, back, half = np.inf, self.log.wheelbase, self.log.half_width + CORNERS
        for ox, oy, radius, vx, vy in self.scenario.obstacles:
            for behind in np.linspace(0.0, back, CIRCLES):
                dx, dy = x - behind * np.cos(psi) - ox - t * vx, y - behind * np.sin(psi) - oy - t * vy
                gap = min(gap, float(np.hypot(dx, dy) - radius - half))
        self.log.rows.append(
            {
                "t": t, "truth": [sample[name] for name in STATE_CHANNELS], "estimate": command.state[:6], "n": command.n,
                "n_std": command.n_std, "n_used": command.n_used, "verdict": command.verdict,
                "steer": steer, "a_x": float(command.plan_w[0, 1]), "error": error, "along": along,
                "clearance": gap, "solve_ms": 1e3 * self.driver.solver.stats.seconds, "status": command.status.name,
                "safe": command.lost, "halt": command.halt, "slip": command.slip,
            }
        )  # fmt: skip
        self.log.plans.append(command.plan_z[:, :2])


class FailingSolver:
    """A solver whose solves are made to fail where `disturb` of their number says so: the state it is given is not finite.

    solver: that solves the others, and answers everything else.
    """

    def __init__(self, solver: Nmpc, disturb: Callable[[int], bool]) -> None:
        self._solver, self._disturb, self._number = solver, disturb, -1

    def __getattr__(self, name: str) -> Any:
        return getattr(self._solver, name)

    def make_step(self, z0: Array) -> Array:
        """As the solver's own, or failed; z0 (n_z,)."""
        self._number += 1
        return self._solver.make_step(np.full_like(z0, np.nan) if self._disturb(self._number) else z0)
