"""The steering while driving: where the wheels are by the commands, how far they lag, and whether they follow."""

from __future__ import annotations

import math

import numpy as np

STEER_LIMIT = 1.6
"""rad: beyond it a value is no steering angle."""
JUMP = 0.1
"""rad by which a measured angle may differ from the last one, beyond what twice the declared rate allows since then."""
SMOOTH, MEMORY, MOST_LAG = 0.2, 5.0, 0.5
"""s: time constants of the filter through which a lag is seen, and of its regression; greatest lag."""
SLOWEST = 1e-3
"""rad^2/s^2: variance of the steering's rate from which the measured lag counts for more than the first guess."""
QUICK, WHILE = 0.1, 1.0
"""s: time constants of running means: of the angle without its noise, and of angle and lead over the last while."""
MOVES, STILL = 0.25, 0.5
"""Share of the greatest gap by which the means of an angle that moves differ, and s without that, of wheels that are led."""
LEAD = 2.0
"""Greatest lead of the expected angle over the measured one, in greatest gaps."""


class LiveSteering:
    """Follows the commanded and the measured steering angle, tick by tick.

    The wheels are expected (`wheels`, rad) where a first-order lag takes the commands. Plans begin there and not at the measured
    angle: an offset of its sensor does not drive the command on, and a steering that lags is asked for what takes it along the
    plan, the plan's angle a lag later. The lag (`lag`, s) is the slope of the command's lead over the measured angle against the
    rate of that angle, both through one state-variable filter, over the last seconds. The measured angle bounds the lead of the
    expected one, and shows a steering, or a sensor, that is stuck (`stuck`): a mean lead above `gap` over an angle that has not
    moved for `STILL`, until it has moved and the mean is below half of `gap`.

    rate: greatest rate of the steering (rad/s); tick: s; gap: rad; lag: its first guess (s), kept where nothing is measured.
    """

    def __init__(self, rate: float, tick: float, gap: float, lag: float) -> None:
        self.rate, self.tick, self.gap, self.first_lag = rate, tick, gap, lag
        self.command, self.wheels, self.lag, self.stuck = 0.0, 0.0, lag, False
        self._last, self._age = math.nan, 0.0
        self._filtered = np.zeros(2)
        self._means, self._variance, self._covariance = np.zeros(2), 0.0, 0.0
        self._angle = self._mean = self._lead = self._still = 0.0
        self._moved = False

    def begin(self, measured: float) -> None:
        """Start at a measured angle (rad), or straight on where that is none."""
        angle = measured if abs(measured) < STEER_LIMIT else 0.0
        self.command = self.wheels = self._angle = self._mean = angle
        self._filtered = np.full(2, angle)
        self._last, self._age = (measured if angle == measured else math.nan), 0.0

    def take(self, measured: float, ticks: int = 1) -> float:
        """The wheels' angle (rad) after so many ticks of the last command: measured where that may be one, else where they are
        expected."""
        self.wheels += (_share(ticks * self.tick, self.lag) if self.lag > 0.0 else 1.0) * (self.command - self.wheels)
        self._age += ticks * self.tick
        if not abs(measured) < STEER_LIMIT or abs(measured - self._last) > JUMP + 2.0 * self.rate * self._age:
            return self.wheels
        self._learn_lag(measured, self._age)
        self._watch(measured, self._age)
        self._last, self._age = measured, 0.0
        most, lead = self.rate * ticks * self.tick, LEAD * self.gap
        back = float(np.clip(self.wheels, measured - lead, measured + lead)) - self.wheels
        self.wheels += float(np.clip(back, -most, most))
        return measured

    def ask(self, command: float) -> None:
        """The command from now on (rad)."""
        self.command = command

    def _learn_lag(self, measured: float, elapsed: float) -> None:
        """lag * rate = command - angle, all filtered alike, by least squares over the last seconds, around their means."""
        memory, before = _share(elapsed, MEMORY), self._filtered
        self._filtered = before + _share(elapsed, SMOOTH) * (np.array([self.command, measured]) - before)
        midway = 0.5 * (before + self._filtered)
        off = np.array([(self._filtered[1] - before[1]) / elapsed, midway[0] - midway[1]]) - self._means
        self._means += memory * off
        self._variance = (1.0 - memory) * (self._variance + memory * off[0] * off[0])
        self._covariance = (1.0 - memory) * (self._covariance + memory * off[0] * off[1])
        more = (self._covariance - self.first_lag * self._variance) / (self._variance + SLOWEST)
        self.lag = float(np.clip(self.first_lag + more, 0.0, MOST_LAG))

    def _watch(self, measured: float, elapsed: float) -> None:
        """Whether the wheels are stuck, by running means."""
        while_ = _share(elapsed, WHILE)
        self._angle += _share(elapsed, QUICK) * (measured - self._angle)
        self._mean += while_ * (measured - self._mean)
        self._lead += while_ * (self.wheels - measured - self._lead)
        moves = abs(self._angle - self._mean) > MOVES * self.gap
        self._still = self._still + elapsed if abs(self._lead) > self.gap and not moves else 0.0
        self._moved = self._moved or moves
        if self._still > STILL:
            self.stuck, self._moved = True, False
        elif self._moved and abs(self._lead) < 0.5 * self.gap:
            self.stuck = False


def _share(elapsed: float, constant: float) -> float:
    """Share of the way to its input that a first-order lag of a time constant (s) goes within the elapsed time (s)."""
    return 1.0 - math.exp(-elapsed / constant)
