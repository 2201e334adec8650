"""A vehicle's geometry against the motion that a log records: no force law is needed for it.

The front axle's path is the centre of gravity's plus l_f times the heading, (x, y) = integral of (u, v) + l_f (cos psi, sin psi):
that gives l_f. A wheel's speed and the vehicle's give its rolling radius up to the slip.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.clock import on_even_clock
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.symbolic.vehicle import Vehicle

Array = NDArray[np.float64]

WINDOW = 2.0
"""s over which the centre of gravity's velocity is integrated: its noise and its offset gather."""
LEAST_TURN = 1.0
"""Sum of the squared changes of the heading over all windows' rows (rad^2): less says nothing of l_f."""
FEWEST = 4
"""Windows that a standard error needs."""
BODY_MOTION = 0.005
"""m by which l_f on the road differs from that at rest: the body rolls and pitches, and with it the axle's point."""
START = 2.0
"""s left out at the beginning of a log."""
ROLLING = 1.0
"""m/s: slower rows say nothing of a wheel's radius."""
SLIPS = (-0.15, 0.45)
"""Slips that a log's median may have on soil, braked or driven."""
DOUBT_SIGMAS, DOUBT_SHARE = 8.0, 0.15
"""l_f is wrong beyond doubt by so many standard errors, and by this share of the wheelbase."""


@dataclass(frozen=True)
class Measured:
    """A length by motion: value and standard error (m), from so many windows."""

    value: float
    std: float
    windows: int


def front_axle(recordings: Sequence[Recording], start: float = START) -> Measured | None:
    """l_f by the front axle's positions against the centre of gravity's velocity; None where the drives hardly turn.

    start: seconds left out at the beginning of each. Each window has its own place, each drive its own offsets of u and v.
    """
    drives = []
    for recording in recordings:
        log = on_even_clock(recording)
        size = max(round(WINDOW / log.dt), 8)
        first = int(np.searchsorted(log.t, log.t[0] + start))
        parts = (
            {name: log[name][row : row + size] for name in ("x", "y", "psi", "u", "v")}
            for row in range(first, len(log) - size + 1, size)
        )
        found = [_window(part, log.dt) for part in parts if all(np.isfinite(values).all() for values in part.values())]
        if found:
            drives.append(np.array(found))
    count = sum(len(windows) for windows in drives)
    if count < FEWEST or sum(float(windows[:, 0, 0].sum()) for windows in drives) < LEAST_TURN:
        return None
    value = _solve([windows.sum(axis=0) for windows in drives])
    left_out = []
    for d, windows in enumerate(drives):
        sums = [other.sum(axis=0) for other in drives]
        whole = sums[d]
        for window in windows:
            sums[d] = whole - window
            left_out.append(_solve(sums))
    spread = np.array(left_out)
    variance = (count - 1) / count * ((spread - spread.mean()) ** 2).sum()
    return Measured(value, float(np.sqrt(variance + BODY_MOTION**2)), count)


def _solve(sums: Sequence[Array]) -> float:
    """l_f by the normal equations (3, 4) of each drive, in l_f and the drive's offsets of u and v."""
    information = score = 0.0
    for normal in sums:
        own = np.linalg.pinv(normal[1:, 1:3])
        information += normal[0, 0] - normal[0, 1:3] @ own @ normal[1:, 0]
        score += normal[0, 3] - normal[0, 1:3] @ own @ normal[1:, 3]
    return float(score / max(information, 1e-12))


def _window(part: dict[str, Array], dt: float) -> Array:
    """(3, 4) normal equations of one window, its place taken out: columns heading, offsets along and across, right-hand side."""
    psi = np.unwrap(part["psi"])
    cos, sin = np.cos(psi), np.sin(psi)
    path = np.array([_integral(part["u"] * cos - part["v"] * sin, dt), _integral(part["u"] * sin + part["v"] * cos, dt)])
    columns = np.array(
        [
            [cos, sin],
            [_integral(cos, dt), _integral(sin, dt)],
            [_integral(-sin, dt), _integral(cos, dt)],
            [part["x"] - path[0], part["y"] - path[1]],
        ]
    )
    centred = (columns - columns.mean(axis=2, keepdims=True)).reshape(len(columns), -1)
    return centred[:3] @ centred.T


def _integral(rate: Array, dt: float) -> Array:
    return np.concatenate([[0.0], np.cumsum(0.5 * dt * (rate[1:] + rate[:-1]))])


def rolling_radius(recording: Recording) -> float | None:
    """Median of u over the mean wheel speed (m): the radius less the slip's share; None for a drive that hardly moves."""
    spins = [recording[name] for name in WHEEL_CHANNELS if name in recording]
    if not spins:
        return None
    u, spin = recording["u"], np.ma.masked_invalid(spins).mean(axis=0).filled(np.nan)
    rows = (u > ROLLING) & np.isfinite(spin) & (spin > 0)
    return float(np.median(u[rows] / spin[rows])) if rows.sum() >= FEWEST else None


def beyond_doubt(recording: Recording, vehicle: Vehicle) -> str:
    """What in a log contradicts the vehicle's geometry beyond doubt, in one sentence; empty where nothing does."""
    radius = rolling_radius(recording)
    if radius is not None:
        slip = 1.0 - radius / vehicle.radius
        if not SLIPS[0] <= slip <= SLIPS[1]:
            return (
                f"{recording.name}: expected wheels of radius {vehicle.radius:.3g} m as vehicle {vehicle.name} has them, found "
                f"speeds that {radius:.3g} m rolls at"
            )
    place = front_axle([recording])
    if place is not None:
        off = abs(place.value - vehicle.l_f)
        if off > DOUBT_SIGMAS * place.std and off > DOUBT_SHARE * vehicle.wheelbase:
            return (
                f"{recording.name}: expected the front axle {vehicle.l_f:.2f} m ahead of the centre of gravity as vehicle "
                f"{vehicle.name} has it, found it at {place.value:.2f} ± {place.std:.2f} m by position against course"
            )
    return ""
