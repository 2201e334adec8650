"""Drift monitor: the corrections that measurements make to the motion, summed over time, with an alarm and its likely class.

A right model is corrected as often to one side as to the other. What it lacks, or what a sensor gains, corrects it to one side:
a velocity that its position contradicts, a lateral force that never ends, a yaw acceleration whenever the steering moves. Each
channel j is a two-sided CUSUM (Page, Biometrika 41, 1954) of corrections c_j (a share of the state's own unit),

    S_j <- max(0, S_j +- c_j - a_j dt),   alarm where S_j > h_j,

with the allowance a_j per second and the limit h_j of `DriftRules`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.symbolic.effect import Effect

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DriftChannel:
    """name; allowance: correction per second that a right model needs at most; limit: of the sum (units of the state); state:
    whose sensor's noise raises the limit where it is above the floor; signatures: of effects that correct this channel.
    """

    name: str
    allowance: float
    limit: float
    state: str
    signatures: tuple[str, ...]


CHANNELS = (
    DriftChannel("along", 0.0206, 0.086, "x", ("late or displaced sensor",)),
    DriftChannel("side", 0.0174, 0.105, "y", ("late or displaced sensor",)),
    DriftChannel("heading", 0.0038, 0.012, "psi", ("late or displaced sensor",)),
    DriftChannel("speed", 0.12, 0.152, "u", ("resistance",)),
    DriftChannel("lateral", 0.0269, 0.216, "v", ("constant side force",)),
    DriftChannel("yaw", 0.0317, 0.094, "omega_z", ("constant side force",)),
    DriftChannel("yaw_turning", 0.0227, 0.071, "omega_z", ("turning moment",)),
    DriftChannel("yaw_steering", 0.0222, 0.074, "omega_z", ("late steering",)),
    DriftChannel("n", 0.0181, 0.278, "", ("cornering slope",)),
)
"""along, side: of the vehicle's position, in its own frame (m); heading (rad); speed, lateral (m/s); yaw (rad/s): what is
corrected whatever happens, in turning to the side of the turn, and while the steering moves to the side it moves to; n: the soil.

Allowance: the 95 % quantile of |mean correction over 2.5 s|, worst fit drive; limit: twice the largest sum on the fit drives.
`python -m benchmarks.drift_alarms ../shared/data/chrono_vehicle` prints both as the fit drives give them, and the alarms.
The speed's allowance is four times that: an accelerometer's own bias and a ground tilted by half a degree are there in every
drive."""


@dataclass(frozen=True)
class DriftRules:
    """after: s of driving from the start in which nothing is said, the estimate being on its way; gap: s after unknown inputs
    in which nothing is said, the first corrections making up for that time; turning: m/s^2, lateral acceleration from which a
    vehicle turns; steering: rad/s, rate from which its steering moves; most: limits that a sum may reach, so that it comes back
    when the cause has gone; settles: s after an alarm in which its channel is decided; channels.
    """

    after: float = 6.0
    gap: float = 2.0
    turning: float = 1.0
    steering: float = 0.3
    most: float = 3.0
    settles: float = 2.0
    channels: tuple[DriftChannel, ...] = CHANNELS


@dataclass(frozen=True)
class Drift:
    """An alarm. t (s); channel: name of the one with the largest sum over its limit, `settles` seconds after; likely: the class
    (soil, vehicle, steering, sensor) to which most effects of the catalogue belong that look so; also: classes of the others.
    """

    t: float
    channel: str
    likely: str
    also: tuple[str, ...] = ()


class DriftMonitor:
    """The sums of all channels.

    scale (9,): factor on each limit, of sensors that are noisier than the floor; rules. level: largest sum over its limit;
    channel: its index; highest: largest level since the start; added (9,): by the last correction; alarm: the first, t (s) and
    channel.
    """

    def __init__(self, scale: Array, rules: DriftRules | None = None) -> None:
        self.rules = rules or DriftRules()
        self._allowance = np.array([channel.allowance for channel in self.rules.channels])
        self._limit = scale * np.array([channel.limit for channel in self.rules.channels])
        self.start(0.0)

    def start(self, t: float) -> None:
        """Begin at t (s)."""
        self._up, self._down = np.zeros_like(self._limit), np.zeros_like(self._limit)
        self._from, self._last = t + self.rules.after, t
        self.level, self.channel = 0.0, 0
        self.highest, self.added = 0.0, np.zeros_like(self._limit)
        self.alarm: tuple[float, int] | None = None

    def wait(self, t: float) -> None:
        """Say nothing for `gap` s from t (s) on, when inputs are unknown."""
        self._from = max(self._from, t + self.rules.gap)

    def stand(self, t: float, dt: float) -> None:
        """A vehicle stands from t (s) on for dt (s): a time in which nothing is said does not pass meanwhile."""
        if self._from > t:
            self._from += dt

    def see(
        self, t: float, moved: Sequence[float] | Array, n: float, motion: tuple[float, float, float], steer_rate: float
    ) -> bool:
        """Take in a correction at t (s): moved (6,) of x, y, psi, u, v, omega_z; n: of the soil; motion: psi, u, omega_z before
        it; steer_rate: rad/s. Returns whether a sum is over its limit.
        """
        step, self._last = t - self._last, t
        if t < self._from:
            return False
        dx, dy, heading, speed, lateral, yaw = moved
        psi, u, omega_z = motion
        cos, sin = math.cos(psi), math.sin(psi)
        turning = math.tanh(u * omega_z / self.rules.turning)
        steering = math.tanh(steer_rate / self.rules.steering)
        sums = (dx * cos + dy * sin, dy * cos - dx * sin, heading, speed, lateral, yaw, yaw * turning, yaw * steering, n)
        self.added = np.array(sums)
        most = self.rules.most * self._limit
        self._up = np.clip(self._up + self.added - self._allowance * step, 0.0, most)
        self._down = np.clip(self._down - self.added - self._allowance * step, 0.0, most)
        levels = np.maximum(self._up, self._down) / self._limit
        self.channel = int(levels.argmax())
        self.level = float(levels[self.channel])
        self.highest = max(self.highest, self.level)
        over = self.level > 1.0
        if over and (self.alarm is None or t <= self.alarm[0] + self.rules.settles):
            self.alarm = (t if self.alarm is None else self.alarm[0], self.channel)
        return over

    def first_alarm(self, effects: Iterable[Effect]) -> Drift | None:
        """The first alarm since the start with its likely class, by the effects of a catalogue; None where there was none."""
        if self.alarm is None:
            return None
        channel = self.rules.channels[self.alarm[1]]
        likely, *also = likely_classes(channel, effects)
        return Drift(self.alarm[0], channel.name, likely, tuple(also))


CLASSES = {
    "soil": "soil", "steering": "steering", "sensor": "sensor", "body": "vehicle", "load": "vehicle", "slope": "vehicle",
    "tyre": "vehicle",
}  # fmt: skip
"""Kind of an effect -> class of an alarm; a slope acts on the vehicle as a load does."""


def likely_classes(channel: DriftChannel, effects: Iterable[Effect]) -> list[str]:
    """Classes of the effects of the catalogue that share a signature with the channel, the most frequent first.

    Raises ValueError where there is no such effect.
    """
    kinds = [CLASSES[effect.kind] for effect in effects if set(channel.signatures) & set(effect.signatures)]
    if not kinds:
        raise ValueError(f"drift channel {channel.name}: expected an effect that looks like {channel.signatures}, found none")
    return sorted(set(kinds), key=lambda name: (-kinds.count(name), name))
