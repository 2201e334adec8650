"""A receiver's velocities to the east and north, which the heading turns into u and v."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from softsoil.recording.drive import Array
from softsoil.recording.evidence import interpolated

EARTH = {"velocity_east": "u", "velocity_north": "v"}
"""Entries of a map -> the channels in whose place they stand until the heading has turned them."""
TURNED = 0.5
"""s from a heading within which velocities are turned: a line between two is 0.02 rad off at most in ordinary bends."""
DRIVEN = 1.0
"""m/s from which on a course says what a heading says."""
COURSE = 0.3
"""Across a heading the velocities vary by their noise at least; by less than this share of it across their own course."""


def in_their_place(channels: Mapping[str, Any], where: str) -> dict[str, Any]:
    """A map's channels (name -> origin) with those of EARTH in the place of u and v.

    Raises ValueError naming `where` for one of them alone, for u or v beside them, and for two sources.
    """
    given = [name for name in EARTH if name in channels]
    if not given:
        return dict(channels)
    beside = [name for name in EARTH.values() if name in channels]
    if len(given) < len(EARTH) or beside or len({channels[name].source for name in given}) > 1:
        found = ", ".join(f"{name} of {channels[name].source}" for name in (*given, *beside))
        raise ValueError(f"{where}: channels: expected {' and '.join(EARTH)} of one source, and then no u and v; found {found}")
    return {EARTH.get(name, name): replace(one, earth=name in EARTH) for name, one in channels.items()}


def turned_by_heading(east: Array, north: Array, psi: Array | None, dt: float) -> tuple[Array, Array]:
    """Velocities ahead and to the left (N,) of a place on the vehicle, from those to the east and north (N,).

    psi (N,): heading (rad), NaN between its samples, None without one; dt: s per row. Where no heading is near, the length ahead
    and none to the left. Raises ValueError for a heading that is the course of these velocities: to the left would be nothing.
    """
    length = np.hypot(east, north)
    if psi is None:
        return length, np.full(len(length), np.nan)
    heading = interpolated(psi, round(2.0 * TURNED / dt))
    ahead = east * np.cos(heading) + north * np.sin(heading)
    aside = north * np.cos(heading) - east * np.sin(heading)
    driven = aside[np.isfinite(aside) & (length > DRIVEN)]  # a receiver holds its course where the vehicle stands
    left, noise = float(np.sqrt(np.mean(driven**2))) if len(driven) else math.inf, min(_noise(east), _noise(north))
    if left < COURSE * noise:
        raise ValueError(
            f"psi: expected a heading of the vehicle; found the course of {' and '.join(EARTH)} (across it {left:.2g} m/s, where "
            f"their noise alone makes {noise:.2g}): map no psi, or that of two antennas, an INS or a magnetometer"
        )
    return np.where(np.isfinite(heading), ahead, length), aside


def _noise(values: Array) -> float:
    """Standard deviation of white noise on a channel (N,), NaN between its samples, by third differences; 0 for a few samples."""
    thirds = np.abs(np.diff(values[np.isfinite(values)], 3))
    return 1.4826 * float(np.median(thirds)) / math.sqrt(20.0) if len(thirds) else 0.0
