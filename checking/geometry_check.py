"""A vehicle's geometry against the motion that a log records: no force law is needed for it.

The front axle's path is the centre of gravity's plus l_f times the heading, (x, y) = integral of (u, v) + l_f (cos psi, sin psi),
less the sway of the rolling body, -c a_y (-sin psi, cos psi): that gives l_f. A wheel's speed and the vehicle's give its rolling
radius up to the slip.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter, savgol_filter

from softsoil.recording.clock import REACH, at_clock, on_even_clock, unwrapped
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Array, Recording
from softsoil.recording.geometry import Geometry, radius_of
from softsoil.recording.states import sensor_std

WINDOW = 2.0
"""s: stretches that are left out in turn for the standard error."""
MEMORY = (0.5, 4.0)
"""s: bounds of the time over which the whitening filter remembers a place."""
NOISE_FLOOR = np.array([0.01, 0.01, 1e-3, 0.01, 0.01, 1e-3])
"""Noise of the states (m, m, rad, m/s, m/s, rad/s) at least: what a rigid body on a level road leaves is no smaller."""
SLOPE_TIME = 0.2
"""s over which the lateral velocity's slope is taken."""
SWAY, SWAY_STD = 0.002, 0.002
"""m per m/s^2 by which the centre of gravity leaves the front axle's middle sideways: the body rolls by 1 to 8 degrees per g,
0.1 to 0.4 m above the axle. In a slalom part of it is in phase with the heading, as l_f is."""
LEAST_KNOWN = 0.1
"""m: standard error of l_f by sensor noise alone beyond which the drives say nothing of it: they hardly turn."""
FEWEST = 4
"""Windows that a standard error needs."""
BODY_MOTION = 0.005
"""m by which l_f on the road differs from that at rest: one degree of pitch, the centre of gravity 0.3 m above the axle."""
START = 2.0
"""s left out at the beginning of a log."""
ROLLING = 1.0
"""m/s: slower rows say nothing of a wheel's radius."""
SLIPS = (-0.15, 0.45)
"""Slips that a log's median may have on soil, braked or driven."""
DOUBT_SIGMAS, DOUBT_SHARE = 8.0, 0.15
"""l_f is wrong beyond doubt by so many standard errors, and by this share of the wheelbase."""
MOST_ROWS = 0.8
"""Share of all rows: a channel with fewer numbers has a clock of its own."""
SHARED = 2
"""Columns of the normal equations that all drives share, l_f and the sway; offsets of u and v and the right-hand side follow."""


@dataclass(frozen=True)
class Measured:
    """A length by motion: value and standard error (m), from so many windows."""

    value: float
    std: float
    windows: int


def front_axle(recordings: Sequence[Recording], start: float = START) -> Measured | None:
    """l_f by the front axle's positions against the centre of gravity's velocity; None where the drives hardly turn, or do
    not measure all six states.

    Least squares, positions with white noise and the integrated velocity with a random walk: both sides are filtered by
    (1 - B)/(1 - (1 - K) B), B one sample back, which makes that noise white; K^2/(1 - K) is the walk's variance per sample over
    the position's. Each drive has its own offsets of u and v; the sway is known to SWAY_STD.
    start: seconds left out at the beginning of each.
    """
    drives = [windows for windows in (_windows(one, start) for one in recordings) if len(windows)]
    count = sum(len(windows) for windows in drives)
    if count < FEWEST:
        return None
    sums = [windows.sum(axis=0) for windows in drives]
    value, white = _solve(sums)
    if white > LEAST_KNOWN:
        return None
    left_out = []
    for d, windows in enumerate(drives):
        whole = sums[d]
        for window in windows:
            sums[d] = whole - window
            left_out.append(_solve(sums)[0])
        sums[d] = whole
    spread = np.array(left_out)
    variance = (count - 1) / count * ((spread - spread.mean()) ** 2).sum()
    return Measured(value, float(np.sqrt(max(variance, white**2) + BODY_MOTION**2)), count)


def _solve(sums: Sequence[Array]) -> tuple[float, float]:
    """l_f and its standard error by white noise (m) from the normal equations of each drive."""
    information = np.diag([1e-12, SWAY_STD**-2])
    score = np.array([0.0, SWAY / SWAY_STD**2])
    for normal in sums:
        shared, own = slice(SHARED), slice(SHARED, -1)
        taken = normal[shared, own] @ np.linalg.pinv(normal[own, own])
        information = information + normal[shared, shared] - taken @ normal[own, shared]
        score = score + normal[shared, -1] - taken @ normal[own, -1]
    covariance = np.linalg.inv(information)
    return float((covariance @ score)[0]), float(np.sqrt(covariance[0, 0]))


def _windows(log: Recording, start: float) -> Array:
    """(W, 5, 5) normal equations of the log's stretches of WINDOW s, in the units of its positions' noise; none where a state
    is not measured: one that is derived from the others is no evidence."""
    if not log.measured(*STATE_CHANNELS):
        return np.zeros((0, 5, 5))
    log = _on_clock_of_the_slowest(on_even_clock(log), STATE_CHANNELS)
    dt = log.dt
    size = max(round(WINDOW / dt), 8)
    std = sensor_std(log, NOISE_FLOOR)
    place = float(np.sqrt(np.mean(std[:2] ** 2)))
    speed = float(np.nanmean(np.abs(log["u"])))
    walk = float(np.sqrt(np.mean(std[3:5] ** 2) + (std[2] * speed) ** 2)) * dt
    ratio = (walk / place) ** 2
    gain = float(np.clip(0.5 * (np.sqrt(ratio**2 + 4.0 * ratio) - ratio), dt / MEMORY[1], min(dt / MEMORY[0], 1.0)))
    seen = np.isfinite(np.column_stack([log[name] for name in STATE_CHANNELS])).all(axis=1) & (log.t >= log.t[0] + start)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(int))).reshape(-1, 2)
    found = []
    for first, last in edges:
        if last - first >= size:
            columns = _columns({name: log[name][first:last] for name in STATE_CHANNELS}, dt)
            white = lfilter([1.0, -1.0], [1.0, gain - 1.0], columns - columns[..., :1]) / place
            # Where a stretch begins is unknown: what that is after the filter decays with its memory, and is taken out.
            start_of = (1.0 - gain) ** np.arange(last - first)
            white = white - (white @ start_of)[..., None] * start_of / (start_of @ start_of)
            parts = (white[..., row : row + size].reshape(len(white), -1) for row in range(0, last - first - size + 1, size))
            found += [part @ part.T for part in parts]
    return np.array(found)


def _columns(part: dict[str, Array], dt: float) -> Array:
    """(5, 2, N) of a stretch without gaps: heading, sway, offsets along and across, positions less the integrated velocity."""
    psi, u, v = np.unwrap(part["psi"]), part["u"], part["v"]
    cos, sin = np.cos(psi), np.sin(psi)
    lateral = u * part["omega_z"] + savgol_filter(v, max(2 * round(0.5 * SLOPE_TIME / dt) + 1, 5), 2, deriv=1, delta=dt)
    path = np.array([_integral(u * cos - v * sin, dt), _integral(u * sin + v * cos, dt)])
    return np.array(
        [
            [cos, sin],
            [-lateral * sin, lateral * cos],
            [_integral(cos, dt), _integral(sin, dt)],
            [_integral(-sin, dt), _integral(cos, dt)],
            [part["x"] - path[0], part["y"] - path[1]],
        ]
    )


def _integral(rate: Array, dt: float) -> Array:
    return np.concatenate([[0.0], np.cumsum(0.5 * dt * (rate[1:] + rate[:-1]))])


def rolling_radius(recording: Recording) -> float | None:
    """Median of u over the mean wheel speed (m), means over 1 s: the radius less the slip's share; None for a drive that hardly
    moves. Single rows of a noisy speed above ROLLING would be those whose noise is above it."""
    spins = [recording[name] for name in WHEEL_CHANNELS if name in recording]
    if not spins:
        return None
    u, spin = recording["u"], np.ma.masked_invalid(spins).mean(axis=0).filled(np.nan)
    both = np.isfinite(u) & np.isfinite(spin)
    second = np.floor(recording.t[both] - recording.t[0]).astype(int)
    count = np.bincount(second)
    u, spin = (np.bincount(second, values[both])[count > 0] / count[count > 0] for values in (u, spin))
    rows = (u > ROLLING) & (spin > 0)
    return float(np.median(u[rows] / spin[rows])) if rows.sum() >= FEWEST else None


def beyond_doubt(recording: Recording, geometry: Geometry) -> str:
    """What in a log contradicts the vehicle's geometry beyond doubt, in one sentence; empty where nothing does."""
    radius, name = rolling_radius(recording), getattr(geometry, "name", "declared")
    if radius is not None:
        wheels = [radius_of(geometry, wheel) for wheel in WHEEL_CHANNELS if wheel in recording]
        declared = len(wheels) / sum(1.0 / one for one in wheels)
        if not SLIPS[0] <= 1.0 - radius / declared <= SLIPS[1]:
            return (
                f"{recording.name}: expected wheels of radius {declared:.3g} m as vehicle {name} has them, found "
                f"speeds that {radius:.3g} m rolls at"
            )
    place = front_axle([recording])
    if place is not None:
        off = abs(place.value - geometry.l_f)
        if off > DOUBT_SIGMAS * place.std and off > DOUBT_SHARE * (geometry.l_f + geometry.l_r):
            return (
                f"{recording.name}: expected the front axle {geometry.l_f:.2f} m ahead of the centre of gravity as vehicle "
                f"{name} has it, found it at {place.value:.2f} ± {place.std:.2f} m by position against course"
            )
    return ""


def _on_clock_of_the_slowest(recording: Recording, names: Sequence[str]) -> Recording:
    """The channels `names` on equal steps of the slowest of them; unchanged where each has a number in most rows.

    A drive from sources of several rates keeps the fastest one's clock, and the others are empty between their samples: rows in
    which all are measured are few. Each time takes the sample nearest to it, as `on_even_clock` does.
    """
    there = {name: np.isfinite(recording[name]) for name in names}
    slowest = min(there, key=lambda name: int(there[name].sum()))
    seen = recording.t[there[slowest]]
    if len(seen) < 2 or len(seen) > MOST_ROWS * len(recording):
        return recording
    apart = np.diff(seen)
    dt = float(np.mean(apart[apart < 2.0 * np.median(apart)]))
    clock = seen[0] + dt * np.arange(int((seen[-1] - seen[0]) / dt) + 1)
    channels = {
        name: at_clock(clock, recording.t[rows], unwrapped(name, recording[name][rows]), REACH * dt)
        for name, rows in there.items()
    }
    return replace(recording, channels={"t": clock, **channels}, truth={})
