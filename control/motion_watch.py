"""Whether what is measured of the motion agrees: position with speed and heading, heading and steering with yaw rate."""

from __future__ import annotations

import math

from softsoil.control.driver_checks import FARTHEST, LARGEST
from softsoil.control.driver_types import Measured
from softsoil.control.inbox import given
from softsoil.control.live_steering import STEER_LIMIT

COURSE, HEADING, STEERING = "course", "heading", "steering"
KINDS = (COURSE, HEADING, STEERING)
"""Comparisons: x, y with u and psi; psi with omega_z; the measured angle at the road wheels with omega_z. In C the bits of
`softsoil_driver_command_t.disagreement`."""
CHANNELS = {"x": FARTHEST, "y": FARTHEST, "psi": LARGEST, "u": LARGEST, "v": LARGEST, "omega_z": LARGEST, "steer": STEER_LIMIT}
"""What is compared, and the size from which on a number is none."""
HELD = 1.0
"""s for which a measurement is held."""
PAUSE = 0.5
"""s between two calls beyond which a stretch begins anew."""
SHORTEST, STALE, LONGEST = 0.5, 2.0, 8.0
"""s: least length of a stretch; after which one ends though what it ends with has not changed; after which one is given up."""
LEAST_WAY, WAY_STDS, MOST_STD = 3.0, 12.0, 2.0
"""m, standard deviations of the position, m: least way that is compared, and the most that their noise is taken for."""
FROZEN = 4.0
"""Least ways by which positions move on while u makes none, for u to be wrong: a receiver wanders around a parked vehicle."""
LEAST_TURN, TURN_STDS, MOST_TURN_STD = 0.3, 14.0, 0.1
"""rad, standard deviations of the heading, rad: the same of turns."""
MOVING = 0.3
"""m/s: slower, no turn is compared: the heading of a receiver that stands is any."""
OFFSET = 0.06
"""rad: what a steering angle may be off by its zero, a slope or the slip of the axles."""
NEW = 0.05
"""Share of a new position's or heading's noise in its running mean."""
SHARE = 0.5
"""Share of the greater of two ways or turns by which they must differ to disagree."""
COUNT = 3
"""Stretches that disagree, less those that agree, from which on measurements disagree, until none is left."""


class MotionWatch:
    """Compares what was measured over stretches of the way, tick by tick, in fixed memory.

    A stretch of way ends at a position that is new, when way was made: the one between its two positions is compared with the one
    that u, v, psi and omega_z make of it. A stretch of turning ends at a heading that is new: its change is compared with the
    integral of omega_z, and that one's sign with the sign of what a measured steering angle makes of u, beyond `OFFSET`. A unit,
    a sign or an axis that is wrong disagrees in every stretch, a position that jumps in one. A stretch that disagrees ends one
    measurement later: one that is alone in its place is none. A stretch that shows nothing lets one that disagreed be forgotten.
    The least way and turn follow the noise of positions and headings from one to the next.

    l_f, l_r: m from the centre of gravity to the axles; position_std (m), heading_std (rad): of that noise, at first. `disagree`:
    the comparisons that fail now.
    """

    def __init__(self, l_f: float, l_r: float, position_std: float, heading_std: float) -> None:
        self.l_f, self.l_r = l_f, l_r
        self._variance, self._turn_variance = position_std**2, heading_std**2
        self._way_doubted = self._turn_doubted = False
        self._off, self._turn_off = (0.0, 0.0), 0.0
        self.forget()

    @property
    def disagree(self) -> tuple[str, ...]:
        """Of `KINDS`, what disagrees."""
        return tuple(kind for kind in KINDS if self._failed[kind])

    @property
    def least_way(self) -> float:
        """Way that is compared at least (m)."""
        return max(LEAST_WAY, WAY_STDS * math.sqrt(self._variance))

    @property
    def least_turn(self) -> float:
        """Turn that is compared at least (rad)."""
        return max(LEAST_TURN, TURN_STDS * math.sqrt(self._turn_variance))

    def forget(self) -> None:
        """A drive begins anew: nothing disagrees yet."""
        self._counts = dict.fromkeys(KINDS, 0)
        self._failed = dict.fromkeys(KINDS, False)
        self._begin()

    def _begin(self) -> None:
        """Stretches begin anew, as after a pause."""
        self._t = math.nan
        self._held: dict[str, tuple[float, float]] = {}
        self._heading = math.nan
        self._begin_way(math.nan, (math.nan, math.nan))
        self._begin_turn(math.nan)

    def take(self, t: float, measured: Measured, steer: float) -> None:
        """What was measured at t (s), by name; steer: the measured angle of the road wheels (rad), NaN for none."""
        elapsed = t - self._t
        if not 0.0 <= elapsed <= PAUSE:
            self._begin()
        elif elapsed > 0.0:
            self._roll(elapsed, t)
        self._t = t
        read = {name: steer if name == "steer" else given(measured, name, math.nan) for name in CHANNELS}
        now = {name: value for name, value in read.items() if abs(value) < CHANNELS[name]}
        if "psi" in now:
            self._turn_to(t, now["psi"])
        if "x" in now and "y" in now:
            self._come_to(t, now["x"], now["y"])
        self._held.update({name: (t, value) for name, value in now.items()})

    def _value(self, name: str, t: float) -> float:
        """The last measurement of that name where it is held at t (s), else NaN."""
        at, value = self._held.get(name, (-math.inf, math.nan))
        return value if t - at <= HELD else math.nan

    def _roll(self, elapsed: float, t: float) -> None:
        """Way and turn over the time elapsed until t (s), by what was measured before."""
        u, v, omega = (self._value(name, t) for name in ("u", "v", "omega_z"))
        turn = omega if math.isfinite(omega) else 0.0
        side = (v if math.isfinite(v) else self.l_r * turn) + self.l_f * turn
        if not math.isfinite(self._value("psi", t)):
            self._heading = math.nan
        self._way[0] += elapsed * (u * math.cos(self._heading) - side * math.sin(self._heading))
        self._way[1] += elapsed * (u * math.sin(self._heading) + side * math.cos(self._heading))
        self._heading += elapsed * turn
        self._turned += elapsed * omega
        pace = elapsed * u / (self.l_f + self.l_r)
        self._steered += pace * math.tan(self._value("steer", t))
        self._slack += abs(pace) * OFFSET

    def _turn_to(self, t: float, psi: float) -> None:
        """A heading psi (rad) measured at t (s)."""
        last, u = self._value("psi", t), self._value("u", t)
        new = psi != last
        if not math.isfinite(last) or abs(u) < MOVING:
            self._heading = psi
            self._begin_turn(t)
            return
        if new:
            self._heading = psi
            self._changed += math.remainder(psi - last, math.tau)
            off = self._changed - self._turned
            if math.isfinite(off):
                step = off - self._turn_off
                self._turn_variance += NEW * (min(0.5 * step * step, MOST_TURN_STD**2) - self._turn_variance)
                self._turn_off = off
        seconds, most = t - self._turn_began, max(abs(self._turned), abs(self._changed))
        known, ends = math.isfinite(self._turned), seconds >= SHORTEST and (new or seconds >= STALE)
        if known and ends and most >= self.least_turn:
            differs = abs(self._turned - self._changed) > SHARE * most
            if differs and not self._turn_doubted:
                self._turn_doubted = True
                return
            self._count(HEADING, differs)
            if abs(self._turned) >= LEAST_TURN and abs(self._steered) - self._slack >= SHARE * LEAST_TURN:
                self._count(STEERING, self._turned * self._steered < 0.0)
            self._begin_turn(t)
        elif seconds > LONGEST or (ends and not known):
            self._fade(HEADING)
            self._fade(STEERING)
            self._begin_turn(t)
        elif new:
            self._turn_doubted = False

    def _come_to(self, t: float, x: float, y: float) -> None:
        """A position x, y (m) measured at t (s)."""
        new = (x, y) != (self._value("x", t), self._value("y", t))
        seconds = t - self._way_began
        off = (x - self._from[0] - self._way[0], y - self._from[1] - self._way[1])
        if not math.isfinite(off[0]):
            if new:
                self._begin_way(t, (x, y))
            return
        if new:
            step = (off[0] - self._off[0], off[1] - self._off[1])
            variance = min((step[0] * step[0] + step[1] * step[1]) / 4.0, MOST_STD**2)
            self._variance += NEW * (variance - self._variance)
            self._off = off
        made, way, least = math.hypot(x - self._from[0], y - self._from[1]), math.hypot(*self._way), self.least_way
        far = max(made, way) >= least and (way >= SHARE * least or made >= FROZEN * least)
        if far and seconds >= SHORTEST and (new or seconds >= STALE):
            differs = math.hypot(*off) > SHARE * max(made, way)
            if differs and not self._way_doubted:
                self._way_doubted = True
                return
            self._count(COURSE, differs)
            self._begin_way(t, (x, y))
        elif seconds > LONGEST:
            self._fade(COURSE)
            self._begin_way(t, (x, y))
        elif new:
            self._way_doubted = False

    def _begin_way(self, t: float, place: tuple[float, float]) -> None:
        self._way_began, self._from, self._way = t, place, [0.0, 0.0]
        self._off, self._way_doubted = (0.0, 0.0), False

    def _begin_turn(self, t: float) -> None:
        self._turn_began = t
        self._turned = self._changed = self._steered = self._slack = self._turn_off = 0.0
        self._turn_doubted = False

    def _count(self, kind: str, differs: bool) -> None:
        """One more stretch that agrees or not."""
        self._counts[kind] = min(self._counts[kind] + 1, COUNT) if differs else max(self._counts[kind] - 1, 0)
        if self._counts[kind] in (0, COUNT):
            self._failed[kind] = self._counts[kind] == COUNT

    def _fade(self, kind: str) -> None:
        """A stretch that shows nothing."""
        if not self._failed[kind]:
            self._counts[kind] = max(self._counts[kind] - 1, 0)
