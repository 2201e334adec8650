"""Manoeuvres: what a driver does with steering and throttle. Angles are road-wheel angles (rad)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.world import Sample

Array = NDArray[np.float64]

STEP_RATE = 10.0
"""A logged steering command that moves faster than this has jumped (rad/s)."""


class Driver(Protocol):
    """A driver sees a sample and gives the commands until the next one."""

    @property
    def name(self) -> str:
        """Name of the recording."""
        ...

    def __call__(self, t: Array, sample: Sample) -> Array:
        """Commands (N, 3): steering (rad), throttle, brake at the times t (N,), given what is seen at t[0]."""
        ...


class Steer(Protocol):
    """A steering angle as a function of time."""

    def __call__(self, t: Array) -> Array:
        """(N,) road-wheel angle (rad) at times t (N,)."""
        ...


@dataclass(frozen=True)
class Sine:
    """amplitude sin(2 pi t / period + phase): the paper's manoeuvre with full lock and 3 s."""

    amplitude: float = 0.47
    period: float = 3.0
    phase: float = 0.0

    def __call__(self, t: Array) -> Array:
        """Steering at t."""
        return self.amplitude * np.sin(2 * np.pi * t / self.period + self.phase)


@lru_cache(maxsize=64)
def _phases(seed: int, count: int) -> Array:
    return np.random.default_rng(seed).uniform(0, 2 * np.pi, count)


@dataclass(frozen=True)
class MultiSine:
    """A sum of sines with random phases, drawn once from the seed; its amplitude stays within `amplitude`."""

    amplitude: float = 0.45
    frequencies: tuple[float, ...] = (0.07, 0.13, 0.22, 0.35, 0.55, 0.8)
    seed: int = 0

    def __call__(self, t: Array) -> Array:
        """Steering at t."""
        frequencies = np.array(self.frequencies)[:, None]
        waves = np.sin(2 * np.pi * frequencies * t + _phases(self.seed, len(self.frequencies))[:, None])
        return np.clip(1.8 * self.amplitude / len(waves) * waves.sum(axis=0), -self.amplitude, self.amplitude)


@dataclass(frozen=True)
class Steps:
    """Alternating steps of growing size: +a, 0, -a, 0, then the next size."""

    sizes: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4)
    hold: float = 2.0

    def __call__(self, t: Array) -> Array:
        """Steering at t."""
        values = np.concatenate([[size, 0.0, -size, 0.0] for size in self.sizes])
        return values[(np.floor(np.maximum(t, 0) / self.hold).astype(int)) % len(values)]


@dataclass(frozen=True)
class Chirp:
    """amplitude sin of a frequency (Hz) that grows linearly from `start` to `stop` over `duration` (s), then holds."""

    amplitude: float = 0.2
    start: float = 0.1
    stop: float = 2.0
    duration: float = 30.0

    def __call__(self, t: Array) -> Array:
        """Steering at t."""
        early = np.minimum(t, self.duration)
        cycles = self.start * early + 0.5 * (self.stop - self.start) * early**2 / self.duration
        return self.amplitude * np.sin(2 * np.pi * (cycles + self.stop * np.maximum(t - self.duration, 0.0)))


@dataclass(frozen=True)
class Speed:
    """Throttle that holds a speed (m/s) waving by `wave` (m/s) over `period` (s): proportional with a base share."""

    speed: float = 5.5
    wave: float = 0.0
    period: float = 11.0
    gain: float = 0.4
    base: float = 0.15

    def __call__(self, t: Array, u: float) -> Array:
        """Throttle at t (N,), given the speed u at its start."""
        target = self.speed + self.wave * np.sin(2 * np.pi * t / self.period)
        return np.clip(self.base + self.gain * (target - u), 0.0, 1.0)


@dataclass(frozen=True)
class SineThrottle:
    """The paper's sinusoidal throttle: mean + wave sin(2 pi t / period), within [0, 1]."""

    mean: float = 0.33
    wave: float = 0.22
    period: float = 3.0

    def __call__(self, t: Array, u: float) -> Array:
        """Throttle at t (N,)."""
        return np.clip(self.mean + self.wave * np.sin(2 * np.pi * t / self.period), 0.0, 1.0)


@dataclass(frozen=True)
class Manoeuvre:
    """Open-loop steering with a throttle rule.

    name; steer: angle over time; throttle. TypeError where steering or throttle stand in another's place.
    """

    name: str
    steer: Steer = field(default_factory=Sine)
    throttle: Speed | SineThrottle = field(default_factory=Speed)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not callable(self.steer) or not callable(self.throttle):
            found = ", ".join(map(repr, (self.name, self.steer, self.throttle)))
            raise TypeError(f"Manoeuvre: expected a name, a steering and a throttle, found {found}")

    def __call__(self, t: Array, sample: Sample) -> Array:
        """Commands at t."""
        return np.stack([self.steer(t), self.throttle(t, sample["u"]), np.zeros_like(t)], axis=1)


@dataclass
class PathFollower:
    """Pure pursuit: steer for the point a look-ahead distance along the path (m), hold a speed.

    path: (N, 2) points (m); the front-axle point is steered: delta = atan(2 L sin(bearing) / look), wheelbase L.
    ValueError for a path of another shape.
    """

    path: Array
    throttle: Speed = field(default_factory=Speed)
    look_ahead: float = 4.0
    wheelbase: float = 2.706
    limit: float = 0.47
    name: str = "path"
    _at: int = 0
    _until: float = -math.inf

    def __post_init__(self) -> None:
        self.path = np.asarray(self.path, dtype=float)
        if self.path.ndim != 2 or self.path.shape[1] != 2 or len(self.path) < 2:
            raise ValueError(f"path: expected points (N, 2) with N >= 2, found shape {self.path.shape}")

    def __call__(self, t: Array, sample: Sample) -> Array:
        """Commands at t, held; a time before the last one begins the path anew."""
        if t[0] < self._until:
            self._at = 0
        self._until = float(t[-1])
        here = np.array([sample["x"], sample["y"]])
        ahead = self.path[self._at : self._at + 400]
        self._at += int(np.argmin(np.linalg.norm(ahead - here, axis=1)))
        far = np.flatnonzero(np.linalg.norm(self.path[self._at :] - here, axis=1) >= self.look_ahead)
        goal = self.path[self._at + far[0]] if len(far) else self.path[-1]
        dx, dy = goal - here
        bearing = math.atan2(dy, dx) - sample["psi"]
        steer = math.atan(2.0 * self.wheelbase * math.sin(bearing) / self.look_ahead)
        commands = np.zeros((len(t), 3))
        commands[:, 0] = min(max(steer, -self.limit), self.limit)
        commands[:, 1] = self.throttle(t, sample["u"])
        return commands


@dataclass(frozen=True)
class Logged:
    """The steering, throttle and brake of a log, by linear interpolation; a step of the steering stays one (STEP_RATE),
    halfway between its rows."""

    t: Array
    commands: Array
    name: str = "logged"

    def __call__(self, t: Array, sample: Sample) -> Array:
        """Commands at t."""
        steering = np.interp(t, *self._steering)
        return np.stack([steering, *(np.interp(t, self.t, column) for column in self.commands.T[1:])], axis=1)

    @cached_property
    def _steering(self) -> tuple[Array, Array]:
        """Times and steering with both sides of each step between its rows."""
        steering = self.commands[:, 0]
        at = np.flatnonzero(np.abs(np.diff(steering)) > STEP_RATE * np.diff(self.t))
        middle = 0.5 * (self.t[at] + self.t[at + 1])
        times = np.stack([middle, np.nextafter(middle, np.inf)], axis=1).ravel()
        both = np.stack([steering[at], steering[at + 1]], axis=1).ravel()
        rows = np.repeat(at + 1, 2)
        return np.insert(self.t, rows, times), np.insert(steering, rows, both)


def lane_change(length: float = 120.0, width: float = 3.5, every: float = 0.5, changes: int = 2) -> Array:
    """(N, 2) path along x that changes lanes and back, by smooth steps."""
    x = np.arange(0.0, length, every)
    y = np.zeros_like(x)
    for k in range(changes):
        s = np.clip((x - length * (k + 0.5) / (changes + 0.5)) / 15.0 + 0.5, 0.0, 1.0)
        y += (-1) ** k * width * s * s * (3.0 - 2.0 * s)
    return np.stack([x, y], axis=1)


MANOEUVRES = {
    "paper": Manoeuvre("paper", Sine(), SineThrottle()),
    "multi": Manoeuvre("multi", MultiSine(), Speed(5.5, 1.5)),
    "steps": Manoeuvre("steps", Steps(), Speed(5.0)),
    "chirp": Manoeuvre("chirp", Chirp(), Speed(5.0)),
    "straight": Manoeuvre("straight", Sine(0.0), Speed(5.0)),
}
"""Open-loop manoeuvres by name."""


def names() -> Sequence[str]:
    """What `simulate` knows by name."""
    return (*MANOEUVRES, "path")
