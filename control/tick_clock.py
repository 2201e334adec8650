"""The clock of a driver's ticks: what it may say, and how long obstacles have moved."""

from __future__ import annotations

import math

from softsoil.control.driver_checks import check_time


class TickClock:
    """Time of the last tick (`at`, s), and the time at which obstacles stood where they were declared (`origin`, s; NaN before).

    A clock that is set back goes on where it was: obstacles have moved as long as before. After a stamp far ahead that is where
    the clock was before it. pause: s by which a clock is set back at least.
    """

    def __init__(self, pause: float) -> None:
        self.pause, self.at, self.origin = pause, -math.inf, math.nan
        self._before = self._leapt = math.nan

    def check(self, t: float) -> bool:
        """Whether t (s) is of a clock set back; ValueError for a t that is not finite or less far before the last tick's."""
        return check_time(t, self.at, self.pause)

    def take(self, t: float, back: bool) -> None:
        """A tick at t (s); back: what `check` says of it."""
        if back:
            leapt = self.at - self._leapt <= self.pause and abs(t - self._before) <= 2.0 * self.pause
            last = self._before if leapt else self.at
            if t < last:
                self.origin = t - (last - self.origin)
            self._before = self._leapt = math.nan
        elif math.isfinite(self.at) and t - self.at > self.pause:
            again = self.at - self._leapt <= self.pause  # of several stamps far ahead the first counts
            self._before, self._leapt = self._before if again else self.at, t
        self.at = t

    def begin(self, t: float) -> None:
        """The first state is known at t (s)."""
        if math.isnan(self.origin):
            self.origin = t
