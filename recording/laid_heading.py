"""A heading from the yaw rate and positions together: its turning from the gyro, its direction from where the vehicle went.

The integral of a yaw rate begins anywhere and drifts. Over a few seconds the way that it makes with the speeds, and the way
between the positions, are the same up to a turn; that turn is the heading's error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from softsoil.recording.drive import Array
from softsoil.recording.evidence import interpolated
from softsoil.recording.noise_level import noise_level

WAY = 4.0
"""s: length of the ways that are compared, at most a third of a drive."""
SURE = 5.0
"""Standard deviations of a position that a way must be long at least."""
SHORTEST = 0.5
"""m: the same where positions have no noise."""
LONGEST_GAP = 2.0
"""s between positions up to which a line stands for them."""
LEAST = 1.0
"""Seconds of such ways without which nothing is known of the direction."""
DRIFT = 0.06
"""rad/s: largest bias of a gyro."""
STRETCH, COARSE = 60.0, 0.2
"""s: stretches in which a gyro's bias is one number, and steps in which it is looked for."""
WANDER = 10.0
"""s on each side over which a drift is taken together."""
FAINT = 0.02
"""Share of the square of the shortest way, below which ways of so long a time say no direction: a vehicle that stands."""
SCATTERED = 0.6
"""Length of the mean direction below which positions and yaw rate are not of one body."""


@dataclass(frozen=True)
class Laid:
    """A heading laid on positions.

    psi (N,): rad; agreement: length of the mean direction of the ways between positions, seen from the heading: 1 for a rigid
    body; mirrored: the same of positions with one axis turned round; bias: of the yaw rate (rad/s).
    """

    psi: Array
    agreement: float
    mirrored: float
    bias: float

    @property
    def scattered(self) -> bool:
        """Whether the positions fit no heading with this yaw rate."""
        return self.agreement < SCATTERED


def laid_heading(x: Array, y: Array, ahead: Array, aside: Array, omega: Array, dt: float) -> Laid | None:
    """The heading that fits a yaw rate and positions; None where the positions say no direction.

    x, y (N,): m, NaN where empty; ahead, aside (N,): velocity of that point in the vehicle's frame (m/s); omega (N,): yaw rate
    (rad/s), these without NaN; dt: s.
    """
    psi = np.cumsum(omega) * dt
    way = int(min(WAY / dt, len(psi) / 3))
    if way < 1:
        return None
    reach = round(LONGEST_GAP / dt)
    place = interpolated(x, reach) + 1j * interpolated(y, reach)
    reckoned = np.cumsum((ahead + 1j * aside) * np.exp(1j * psi)) * dt
    gone, claimed = place[way:] - place[:-way], reckoned[way:] - reckoned[:-way]
    least = max(SHORTEST, SURE * max(noise_level(one, dt).white for one in (x, y)))
    good = np.isfinite(gone) & (np.abs(claimed) > least)
    if good.sum() * dt < LEAST:
        return None
    gone, claimed = np.where(good, gone, 0.0), np.where(good, claimed, 0.0)
    t = np.asarray((np.arange(len(gone)) - 0.5 * len(gone)) * dt, dtype=np.float64)
    turn = gone * np.conj(claimed)
    agreement, bias = _agreement(turn, dt)
    mirrored, _ = _agreement(np.conj(gone) * np.conj(claimed), dt)
    rest = turn * np.exp(-1j * bias * t)
    size = min(2 * round(WANDER / dt) + 1, len(rest))
    along, across = (uniform_filter1d(part, size, mode="constant") for part in (rest.real, rest.imag))
    known = np.flatnonzero(np.hypot(along, across) > FAINT * least**2)
    if not len(known):
        return None
    wander = np.interp(np.arange(len(rest)), known, np.unwrap(np.arctan2(across, along)[known]))
    rows = np.clip(np.arange(len(psi)) - way // 2, 0, len(rest) - 1)
    drift = bias * (np.arange(len(psi)) - 0.5 * (len(psi) - 1)) * dt
    return Laid(psi + drift + wander[rows], agreement, mirrored, -bias)


def _agreement(turn: Array, dt: float) -> tuple[float, float]:
    """Length of the mean direction of `turn` (K,), complex, every dt (s), over stretches in each of which one drift within DRIFT
    is left out, and the median of these (rad/s)."""
    block = max(round(COARSE / dt), 1)
    whole = len(turn) // block * block
    small = turn[:whole].reshape(-1, block).sum(axis=1)
    per = max(round(STRETCH / (block * dt)), 1)
    count = max(round(len(small) / per), 1)
    length, drifts = 0.0, []
    for part in np.array_split(small, count):
        at = np.arange(len(part)) * block * dt
        tried = np.linspace(-DRIFT, DRIFT, 2 * int(np.ceil(DRIFT * max(at[-1], 1.0) / 0.05)) + 1)
        sums = np.abs(np.exp(-1j * np.outer(tried, at)) @ part)
        length += float(sums.max())
        if sums.max() > 0.0:
            drifts.append(float(tried[sums.argmax()]))
    return length / max(float(np.abs(turn[:whole]).sum()), 1e-300), float(np.median(drifts)) if drifts else 0.0
