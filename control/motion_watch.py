"""Whether what is measured of the motion agrees: position with speed and heading, heading and steering with yaw rate."""

from __future__ import annotations

import math

from softsoil.control.driver_types import Measured
from softsoil.control.inbox import given

COURSE, HEADING, STEERING = "course", "heading", "steering"
KINDS = (COURSE, HEADING, STEERING)
"""Comparisons: x, y with u and psi; psi with omega_z; the angle at the road wheels with omega_z. In C the bits of
`softsoil_driver_command_t.disagreement`."""
HELD = 1.0
"""s for which a measurement is held."""
PAUSE = 0.5
"""s between two calls beyond which a stretch begins anew."""
SHORTEST, STALE, LONGEST = 0.5, 2.0, 8.0
"""s: least length of a stretch; after which one ends though what it ends with has not changed; after which one is given up."""
LEAST_WAY, WAY_STDS, LEAST_TURN = 3.0, 12.0, 0.3
"""m, standard deviations of the position, rad: least way and turn that are compared."""
NEW = 0.05
"""Share of a new position's noise in its running mean."""
SHARE = 0.5
"""Share of the greater of two ways or turns by which they must differ to disagree."""
COUNT = 3
"""Stretches that disagree, less those that agree, from which on measurements disagree, until none is left."""


class MotionWatch:
    """Compares what was measured over stretches of the way, tick by tick, in fixed memory.

    A stretch of way ends at a position that is new, when way was made: the one between its two positions is compared with the one
    that u, v, psi and omega_z make of it. A stretch of turning ends at a heading that is new: its change is compared with the
    integral of omega_z, and that one's sign with the sign of what the steering angle makes of u. A unit, a sign or an axis that
    is wrong disagrees in every stretch, a position that jumps in one. A stretch that disagrees ends one measurement later: one
    that is alone in its place is none.

    The least way follows the noise of the positions from one to the next, at most the declared one.

    l_f, l_r: m from the centre of gravity to the axles; position_std: of x and y (m). `disagree`: the comparisons that fail now.
    """

    def __init__(self, l_f: float, l_r: float, position_std: float) -> None:
        self.l_f, self.l_r = l_f, l_r
        self._variance = self._most_variance = position_std**2
        self._counts = dict.fromkeys(KINDS, 0)
        self._failed = dict.fromkeys(KINDS, False)
        self._way_doubted = self._turn_doubted = False
        self._off = (0.0, 0.0)
        self.begin()

    @property
    def disagree(self) -> tuple[str, ...]:
        """Of `KINDS`, what disagrees."""
        return tuple(kind for kind in KINDS if self._failed[kind])

    def begin(self) -> None:
        """Begin anew, as after a pause; what disagreed still does."""
        self._t = math.nan
        self._held: dict[str, tuple[float, float]] = {}
        self._heading = math.nan
        self._begin_way(math.nan, (math.nan, math.nan))
        self._begin_turn(math.nan)

    def take(self, t: float, measured: Measured, steer: float) -> None:
        """What was measured at t (s), by name; steer: the road wheels' angle (rad), measured or where they are expected."""
        elapsed = t - self._t
        if not 0.0 <= elapsed <= PAUSE:
            self.begin()
        elif elapsed > 0.0:
            self._roll(elapsed, t, steer)
        self._t = t
        now = {name: given(measured, name, math.nan) for name in ("x", "y", "psi", "u", "v", "omega_z")}
        x, y, psi = now["x"], now["y"], now["psi"]
        if math.isfinite(psi):
            self._turn_to(t, psi)
        if math.isfinite(x) and math.isfinite(y):
            self._come_to(t, x, y)
        self._held.update({name: (t, value) for name, value in now.items() if math.isfinite(value)})

    def _value(self, name: str, t: float) -> float:
        """The last measurement of that name where it is held at t (s), else NaN."""
        at, value = self._held.get(name, (-math.inf, math.nan))
        return value if t - at <= HELD else math.nan

    def _roll(self, elapsed: float, t: float, steer: float) -> None:
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
        self._steered += elapsed * u * math.tan(steer) / (self.l_f + self.l_r)

    def _turn_to(self, t: float, psi: float) -> None:
        """A heading psi (rad) measured at t (s)."""
        last = self._value("psi", t)
        new = psi != last
        if not math.isfinite(last):
            self._heading = psi
            self._begin_turn(t)
        elif new:
            self._heading = psi
            self._changed += math.remainder(psi - last, math.tau)
        seconds = t - self._turn_began
        if seconds >= SHORTEST and (new or seconds >= STALE):
            most = max(abs(self._turned), abs(self._changed))
            known = math.isfinite(self._turned)
            if known and most >= LEAST_TURN:
                differs = abs(self._turned - self._changed) > SHARE * most
                if differs and not self._turn_doubted:
                    self._turn_doubted = True
                    return
                self._count(HEADING, differs)
                if abs(self._turned) >= LEAST_TURN and abs(self._steered) >= SHARE * LEAST_TURN:
                    self._count(STEERING, self._turned * self._steered < 0.0)
                self._begin_turn(t)
            elif seconds > LONGEST or not known:
                self._begin_turn(t)

    def _come_to(self, t: float, x: float, y: float) -> None:
        """A position x, y (m) measured at t (s)."""
        new = (x, y) != (self._value("x", t), self._value("y", t))
        seconds = t - self._way_began
        made, way = (x - self._from[0], y - self._from[1]), (self._way[0], self._way[1])
        if not math.isfinite(made[0]) or not math.isfinite(way[0]):
            if new:
                self._begin_way(t, (x, y))
            return
        if new:
            step = [made[i] - way[i] - self._off[i] for i in (0, 1)]
            variance = min((step[0] ** 2 + step[1] ** 2) / 4.0, self._most_variance)
            self._variance += NEW * (variance - self._variance)
            self._off = (made[0] - way[0], made[1] - way[1])
        most = max(math.hypot(*made), math.hypot(*way))
        if seconds >= SHORTEST and (new or seconds >= STALE) and most >= self.least_way:
            differs = math.hypot(made[0] - way[0], made[1] - way[1]) > SHARE * most
            if differs and not self._way_doubted:
                self._way_doubted = True
                return
            self._count(COURSE, differs)
            self._begin_way(t, (x, y))
        elif seconds > LONGEST:
            self._begin_way(t, (x, y))

    @property
    def least_way(self) -> float:
        """Way that is compared at least (m)."""
        return max(LEAST_WAY, WAY_STDS * math.sqrt(self._variance))

    def _begin_way(self, t: float, place: tuple[float, float]) -> None:
        self._way_began, self._from, self._way = t, place, [0.0, 0.0]
        self._off, self._way_doubted = (0.0, 0.0), False

    def _begin_turn(self, t: float) -> None:
        self._turn_began = t
        self._turned = self._changed = self._steered = 0.0
        self._turn_doubted = False

    def _count(self, kind: str, differs: bool) -> None:
        """One more stretch that agrees or not."""
        self._counts[kind] = min(self._counts[kind] + 1, COUNT) if differs else max(self._counts[kind] - 1, 0)
        if self._counts[kind] in (0, COUNT):
            self._failed[kind] = self._counts[kind] == COUNT
