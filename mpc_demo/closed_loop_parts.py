"""Parts of the closed loop: noisy sensors, the estimator on them, the plan that is followed, and the pedals."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.estimator.terrain import ForceError, Jumps, SoilChange, Tuning, terrain_model
from softsoil.estimator.ukf import UnscentedKalmanFilter
from softsoil.plant.world import Sample
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.noise import TABLE5
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]

TICK = 0.012
"""s: the estimator's prediction step."""
STOPPING = 0.6
"""Share of the asked deceleration that soil and brakes give for certain."""
LOOP_TUNING = Tuning(force_error=(0.0, 0.0), n_walk=0.01, n_std=0.5, patience=12)
"""The filter's numbers in the loop. Plans keep away from the full lock where the force law errs most, so that its error
need not grow with the force; n may be far off at first and change underway, with a manoeuvre waiting for neither; and a
vehicle that is believed 14 m away brakes or swerves, so that a burst of outliers must not pass for a jump."""
FIRST_SPREAD = (0.3, 0.3, 0.01, 0.1, 0.1, 0.02)
"""Standard deviations of the state that a drive begins with: x, y, psi, u, v, omega_z, SI units."""


@dataclass(frozen=True)
class Faults:
    """What goes wrong with the sensors: `dropout` (from, to) s without any of the six states; `burst` (from, to) s in which
    every third measurement of each state jumps by 12 standard deviations.
    """

    dropout: tuple[float, float] | None = None
    burst: tuple[float, float] | None = None


@dataclass
class NoisySensors:
    """The six measured states with Table-5 noise; wheel speeds, steering and accelerometer are taken as read.

    seed: of the noise; faults: see Faults. `read` gives (6,) values, NaN where there is none.
    """

    seed: int
    faults: Faults = field(default_factory=Faults)

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self.std = np.array([TABLE5[name] for name in STATE_CHANNELS])

    def read(self, t: float, sample: Sample) -> Array:
        """(6,) x, y, psi, u, v, omega_z as measured at t (s)."""
        y = np.array([sample[name] for name in STATE_CHANNELS]) + self.std * self._rng.standard_normal(6)
        jump = self._rng.random(6) < 1.0 / 3.0
        sign = self._rng.choice([-1.0, 1.0], 6)
        if self.faults.burst and self.faults.burst[0] <= t < self.faults.burst[1]:
            y = np.where(jump, y + 12.0 * sign * self.std, y)
        if self.faults.dropout and self.faults.dropout[0] <= t < self.faults.dropout[1]:
            y[:] = np.nan
        return y


class LoopEstimator:
    """The terrain filter on live measurements, with one n for both axles: the parts of `estimate_terrain`, step by step.

    model: bicycle with its effects; std (6,): of the sensors. `start` begins a drive; the compiled filter is kept.
    """

    def __init__(self, model: Model, std: Array, tuning: Tuning | None = None) -> None:
        self.tuning = tuning = tuning or LOOP_TUNING
        self.augmented = terrain_model(model, tied=True)
        self._n_at = self.augmented.x.index("n")
        self._kept = np.array([i for i in range(len(self.augmented.x)) if i != self._n_at])
        self._names = self.augmented.external.names
        self._walks = np.array([name == "n" for name in self.augmented.x.names[6:]])
        size = len(self.augmented.x)
        self.filter = UnscentedKalmanFilter(
            self.augmented, TICK, q=np.ones(size), r=np.asarray(std) ** 2, x0=self.augmented.x.nominal, p0=np.ones(size),
            gate=tuning.gate,
        )  # fmt: skip
        self.learn = True
        self.start(self.augmented.x.nominal[:6], float(self.augmented.x.nominal[self._n_at]), True)

    def start(self, x0: ArrayLike, n0: float, learn: bool) -> None:
        """Begin a drive at x0 (6,) with the first guess n0; learn: whether n is estimated or stays what `set_n` says."""
        tuning, self.learn = self.tuning, learn
        first = np.concatenate([np.asarray(x0, dtype=float), self.augmented.x.nominal[6:]])
        first[self._n_at] = n0
        spread = np.where(self._walks, tuning.n_std if learn else 0.0, 1e-2)
        walk = np.where(self._walks, tuning.n_walk if learn else 0.0, 1e-4)
        q = np.concatenate([tuning.model_error, walk]) ** 2 * TICK
        self.filter.set_process_variance(range(len(q)), q)
        self.filter.restart(first, np.concatenate([FIRST_SPREAD, spread]) ** 2)
        self._noise = ForceError(self.augmented, tuning, TICK)
        self._jumps = Jumps(tuning.patience)
        lookback = max(round(tuning.change_after / (TICK * tuning.update_every)), 1)
        self._soil = SoilChange(tuning, [self._n_at], lookback)
        self._count, self._sound = 0, n0

    def set_n(self, n: float) -> None:
        """Tell a filter that does not learn what n is."""
        if not self.learn:
            x = self.filter.x
            x[self._n_at] = n
            self.filter.x = x

    def tick(self, inputs: dict[str, float], y: Array) -> None:
        """Predict over one tick with the inputs by name, update with y (6,) every second one."""
        self._noise.apply(self.filter)
        self.filter.predict(np.array([inputs[name] for name in self._names]))
        self._count += 1
        if self._count % self.tuning.update_every == 0:
            near = y.copy()
            near[2] += 2 * np.pi * np.round((self.filter["psi"] - y[2]) / (2 * np.pi))
            seen = self.filter.update(near)
            if seen.dof < len(seen.used) or self._jumps.waiting:
                self._jumps.see(self.filter, seen, near)
            if self.learn:
                self._soil.see(self.filter)
            self._keep(y)

    def _keep(self, y: Array) -> None:
        """Remember a sound n; a filter that has broken down (near standstill) starts again where it is measured."""
        if np.isfinite(self.filter.x).all():
            self._sound = self.n
        elif np.isfinite(y).all():
            self.start(y, self._sound, self.learn)

    @property
    def n(self) -> float:
        """Estimate of n."""
        return self.filter.at(self._n_at)

    @property
    def n_std(self) -> float:
        """Its standard deviation."""
        return float(np.sqrt(self.filter.variance[self._n_at]))

    @property
    def states(self) -> Array:
        """(n_x,) states of the model, n left out."""
        return self.filter.x[self._kept]

    @property
    def gated(self) -> int:
        """Measurements left out because they were outside the gate."""
        return sum(self.filter.counts.gated.values())


@dataclass
class PlanFollower:
    """Follows the last good plan; without a new one for `patience` s it straightens and slows down.

    dt: step of the plan (s). steer(t), speed(t), a_x(t) from the plan's own time; `halt`: its steering, but the brakes.
    steer_rate: of the straightening (rad/s); slowing, braking: accelerations without a plan and to a halt (m/s^2).
    """

    dt: float
    patience: float = 1.0
    steer_rate: float = 0.3
    slowing: float = -1.5
    braking: float = -4.0
    halt: bool = False

    def __post_init__(self) -> None:
        self._t0, self._steer, self._u, self._a = 0.0, np.zeros(2), np.full(2, 5.0), np.zeros(2)

    def take(self, t0: float, steer: Array, u: Array, a_x: Array, halt: bool = False) -> None:
        """A plan whose first state stands at t0 (s): steering angles and speeds (N + 1,), accelerations (N,)."""
        self._t0, self._steer, self._u, self._a, self.halt = t0, steer.copy(), u.copy(), a_x.copy(), halt

    def lost(self, t: float) -> bool:
        """Whether the plan is too old to be followed."""
        return t - self._t0 > self.patience

    def command(self, t: float, steer_now: float) -> tuple[float, float, float]:
        """(steering angle at t, speed, acceleration): of the plan, or the safe ones where it is lost."""
        if self.lost(t):
            away = TICK * self.steer_rate
            return steer_now - float(np.clip(steer_now, -away, away)), 0.0, self.slowing
        age = (t - self._t0) / self.dt
        k = min(int(age), len(self._a) - 1)
        places = np.arange(len(self._steer))
        steer = float(np.interp(age, places, self._steer))
        if self.halt:
            return steer, 0.0, self.braking
        return steer, float(np.interp(age, places, self._u)), float(self._a[k])

    def must_halt(self, u: float, ahead: float) -> bool:
        """Whether a vehicle at u (m/s) has to brake now for what stands `ahead` (m): stopping distance and a little more."""
        return ahead < u * u / (-2.0 * STOPPING * self.braking) + 1.5


@dataclass
class Pedals:
    """Throttle and brake for an acceleration and a speed: feed-forward, proportional and integral."""

    base: float = 0.15
    gain: float = 0.12
    proportional: float = 0.35
    integral: float = 0.15
    brake: float = 0.12
    _sum: float = 0.0

    def __call__(self, a_x: float, wanted: float, u: float) -> tuple[float, float]:
        """(throttle, brake) in [0, 1] for a_x (m/s^2) now and the speeds wanted and present (m/s)."""
        error = wanted - u
        asked = self.base + self.gain * a_x + self.proportional * error + self._sum
        if 0.0 < asked < 1.0:
            self._sum = float(np.clip(self._sum + self.integral * error * TICK, -0.3, 0.5))
        braking = float(np.clip(-self.brake * (a_x + 1.0) if a_x < -1.0 else 0.0, 0.0, 1.0))
        return float(np.clip(asked, 0.0, 1.0)) if braking == 0.0 else 0.0, braking


def wheel_slip(sample: Sample, u: float, radius: float) -> float:
    """Mean slip 1 - u/(r omega) of the measured wheel speeds (rad/s) at the speed u (m/s), within [-0.3, 0.6]."""
    spin = float(np.mean([sample[name] for name in WHEEL_CHANNELS]))
    return float(np.clip(1.0 - u / max(radius * spin, 0.1), -0.3, 0.6))
