"""What a driver takes and gives: measurements, commands, periods, and the vehicle on the other side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.sampling import STEP
from softsoil.control.live_steering import MOST_LAG
from softsoil.control.nmpc_status import Status
from softsoil.estimator.terrain_filter import FilterStatus
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.noise import TABLE5

Array = NDArray[np.float64]
Measured = Mapping[str, float]
"""Measurements by name, SI units, ISO 8855:

x, y: of the middle of the front axle (m); psi: heading (rad, wrapped anywhere); u, v: velocity of the centre of gravity in the
yaw frame, forward and to the left (m/s); omega_z: yaw rate (rad/s, positive to the left). Each may be NaN or absent at any
tick; the first state needs x, y, psi and u once.
omega_fl, omega_fr, omega_rl, omega_rr: wheel speeds (rad/s, positive forward); without them they follow from the motion and
the nominal slip. a_x_imu: what an accelerometer along the vehicle reads, du/dt - v omega_z (m/s^2); without it the
commanded acceleration is taken. steer: angle at the road wheels (rad), or steer_command, which the
vehicle's steering map turns into it; without both the commanded one is taken.
Other names are refused."""
MEASUREMENTS = (*STATE_CHANNELS, *WHEEL_CHANNELS, "a_x_imu", "steer")
"""Names that a tick takes, in the order of enum softsoil_driver_measurement."""
MEASURED = (*MEASUREMENTS, "steer_command")
"""Names that a tick of `Driver` takes."""
IDENTIFIED, INCONSISTENT, NOT_JUDGED = "identified", "inconsistent", "not_judged"
CONTESTED, CONTESTED_SIGMAS = 0.1, 2.0
"""Share of n, and standard errors of the difference, by which filter and judge must differ for neither n to be identified: a
fault of the model moves each in its own way."""

STANDING_SHARE = 0.5
"""Of `most_resistance`, while the vehicle stands: someone else's brakes may hold it."""


@dataclass(frozen=True)
class DriverSettings:
    """Periods, sensors and caution of a driver.

    tick: s between calls; plan_every: ticks between solves; wall: a plan is followed from as many ticks on as its solve took, one
    at least, else always from the next tick on, which makes drives repeat to the bit; sensor_std: of x, y, psi, u, v, omega_z
    (SI); slip_share: share of a tick's measured slip in its running mean; speed_gain: acceleration per error in speed that a
    vehicle which takes accelerations is given beyond the plan's (1/s); overspeed: share of the speed asked for that plans may
    be faster by, softly (as where the path is far away); resistance_share: of what the vehicle became slower than planned
    within a period, per period, in the running estimate of the deceleration that plans do not know (the soil's resistance, a
    grade, the pedals' map), which the command makes up for; most_resistance: its limit (m/s^2);
    caution, settled, most: while n is not identified the controller drives on n + caution (n_std - settled), by `most` at most:
    an n that is too low promises lateral force that the soil does not give, one that is too high costs next to nothing.
    standing, stands: slower than `standing` (m/s) for `stands` (s) while halted or without a plan, the vehicle has stopped;
    dead_reckoning: longest time without a measurement of position or velocity (x, y, u, v) that the filter could use (s), and
    most_position_std: greatest standard deviation of the estimated position (m): beyond either the vehicle brakes to a halt
    (`Status.POSITION_UNKNOWN`) and goes on as it does after an obstacle, when plans are clear for a while; steering_gap: greatest
    mean of expected less measured steering angle (rad) where that does not move: beyond it the same (`Status.STEERING_STUCK`),
    until it moves and follows; actuator_lag: of the wheels behind their command (s, first order), a first guess where the angle
    is measured (`LiveSteering`); end: before the end of the path from which on a drive is finished, at speed (m). Measurements
    that contradict each other (`MotionWatch`) halt it, too, until they agree (`Status.SENSORS_DISAGREE`).
    Raises ValueError for a period that is not positive, sensors that are not six, a limit that is negative or not finite, a lag
    out of 0 to 0.5 s.
    """

    tick: float = STEP
    plan_every: int = 4
    wall: bool = False
    sensor_std: tuple[float, ...] = tuple(TABLE5[name] for name in ("x", "y", "psi", "u", "v", "omega_z"))
    slip_share: float = 0.02
    speed_gain: float = 1.0
    overspeed: float = 0.2
    resistance_share: float = 0.05
    most_resistance: float = 2.0
    caution: float = 2.0
    settled: float = 0.1
    most: float = 0.25
    standing: float = 0.5
    stands: float = 1.0
    dead_reckoning: float = 4.0
    most_position_std: float = 2.5
    steering_gap: float = 0.1
    actuator_lag: float = 0.0
    end: float = 2.0

    def __post_init__(self) -> None:
        if not self.tick > 0 or self.plan_every < 1:
            raise ValueError(
                f"driver: expected tick > 0 s and plan_every >= 1, found {self.tick} and {self.plan_every}"
            )
        if len(self.sensor_std) != 6 or not all(value > 0 for value in self.sensor_std):
            raise ValueError(f"driver: expected six positive sensor_std, found {self.sensor_std}")
        for name in ("overspeed", "dead_reckoning", "most_position_std", "steering_gap", "end"):
            if not 0 <= getattr(self, name) < 1e3:
                raise ValueError(f"driver: expected {name} in [0, 1000), found {getattr(self, name)}")
        if not 0 <= self.actuator_lag <= MOST_LAG:
            raise ValueError(f"driver: expected actuator_lag in [0, {MOST_LAG}] s, found {self.actuator_lag}")

    @property
    def period(self) -> float:
        """s between solves."""
        return self.tick * self.plan_every


@dataclass(frozen=True)
class DriverCommand:
    """What the vehicle is to do until the next tick.

    steer (rad) at the end of the tick, inside the wheels' lock, steer_rate (rad/s) until then; speed (m/s) and a_x (m/s^2) of the
    plan; a_asked: a_x, what the speed's error adds and what the resistance takes away; status: of the last solve, or why it
    halts; lost: there is no plan, the command is the safe one; halt: braking to a stand before what cannot be passed (status
    BLOCKED at first) or as status says; finished: from `end` before the end of the path on, of a position that is known:
    brake; stopped: came to a stand, by the estimated speed, which follows the commanded acceleration where none is measured,
    and never before a first state is known; n, n_std: estimate, the judge's where its verdict is "identified", else the
    filter's; n_used: what the controller drives on; verdict: on n, "inconsistent" where filter and judge contest each other's
    (`CONTESTED`): do not use n for anything else unless it is "identified"; slip: of the wheels; state (n_z,): estimate that
    the driver acts on; solved: whether this tick has a new plan; plan_z (N + 1, n_z), plan_w (N, n_w): the last plan; along,
    left: place along the path and distance left of it (m); steer_command: what gives `steer` by the vehicle's steering map,
    in the map's unit, NaN for a vehicle without one; filter_status: what the filter's rules did in this tick; position_std:
    root of the sum of the variances of x and y (m); dead_reckoned: time since the filter last used a measurement of x, y, u
    or v (s); both NaN before the first state; actuator_lag: of the measured steering angle behind its command (s), as
    `LiveSteering` finds it; disagree: which measurements do (`motion_watch.KINDS`): "course", x and y with u and psi; "heading",
    psi with omega_z; "steering", the angle of the road wheels with omega_z.
    """

    t: float
    steer: float
    steer_rate: float
    speed: float
    a_x: float
    a_asked: float
    status: Status
    lost: bool
    halt: bool
    finished: bool
    stopped: bool
    n: float
    n_std: float
    n_used: float
    verdict: str
    slip: float
    state: Array
    solved: bool
    plan_z: Array
    plan_w: Array
    along: float
    left: float
    steer_command: float
    filter_status: FilterStatus
    position_std: float
    dead_reckoned: float
    actuator_lag: float
    disagree: tuple[str, ...]


class Judge(Protocol):
    """A second estimate of n beside the filter's, with a verdict on it: `LiveHorizon`."""

    @property
    def verdict(self) -> str:
        """Whether n may be used: "identified", or why not."""
        ...

    @property
    def n(self) -> float:
        """Estimate of n."""
        ...

    @property
    def n_std(self) -> float:
        """Its standard deviation."""
        ...

    def start(self, t: float, n0: float) -> None:
        """Begin a drive at t (s) with the initial guess n0."""
        ...

    def tick(self, t: float, inputs: Mapping[str, float], y: Array) -> None:
        """One sample at t (s): inputs by name, measurements y (6,), NaN where none was made."""
        ...


class DrivenVehicle(Protocol):
    """A vehicle or simulator that a driver drives."""

    def measure(self) -> Measured:
        """The measurements now; see `Measured`."""
        ...

    def apply(self, command: DriverCommand, seconds: float) -> None:
        """Carry out the command for so many seconds."""
        ...
