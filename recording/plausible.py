"""Values against each other: degrees taken for radians, km/h for m/s, milliseconds for seconds, and a flipped sign.

Channels of one drive know each other's units: heading turns as fast as the yaw rate says, positions move as fast as the
speed says. Each is compared over spans of a second, so that noise of a single sample does not matter.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.columns import Source
from softsoil.recording.drive import CHANNEL_UNITS, Array
from softsoil.recording.forward import near_samples

Rows = NDArray[np.integer]

LARGEST = {"steer": 1.3, "omega_z": 6.0}
"""Beyond these a wheeled vehicle's value is taken for degrees (rad, rad/s)."""
LONGEST_STEP = 1.0
"""s: a log with rows farther apart is taken to have its time in other units."""
CLOCKS = ((1e3, "milliseconds", "ms"), (1e6, "microseconds", "us"), (np.inf, "nanoseconds", "ns"))
"""Steps between rows up to which a time is taken for one in these units, and what they are called."""
SPAN = 1.0
"""s over which motions are compared."""
DEGREES, KMH, MODULO = 180 / np.pi, 3.6, 0.3
"""MODULO: rad, modulo 2 pi, by which turns of a heading in degrees miss those of the yaw rate at least."""
FORWARD = 0.5
"""m/s: faster rows drive forward."""
LIKELY = 0.5
"""Least correlation of steering angle and yaw rate that shows whether their signs agree."""


def check_units(path: Path, sources: Mapping[str, Source], channels: Mapping[str, Array]) -> None:
    """Raise ValueError, naming file, column, row and the column map that would help, for values in another unit.

    path: for the message; sources: channel -> column; channels: by name, taken to be in SI units, with a clock that
    increases.
    """
    t = channels["t"]
    if len(t) < 2:
        raise ValueError(f"{path}: expected at least 2 rows, found {len(t)}")
    step = float(np.median(np.diff(t)))
    if step > LONGEST_STEP:
        words, unit = next((words, unit) for most, words, unit in CLOCKS if step <= most)
        raise ValueError(
            f"{path}: column {sources['t'].column!r}, row 2: expected seconds, found rows {step:g} apart: {words}? "
            f'A column map with unit = "{unit}" converts'
        )
    _check_size(path, sources, channels)
    ends = _spans(t)
    if {"psi", "omega_z"} <= set(channels):
        _check_heading(path, sources, t, channels, ends)
    if {"x", "y", "u"} <= set(channels):
        _check_speed(path, sources["u"].column, t, channels, ends)


def _check_size(path: Path, sources: Mapping[str, Source], channels: Mapping[str, Array]) -> None:
    for name, largest in LARGEST.items():
        if name not in channels or not np.isfinite(channels[name]).any():
            continue
        if np.nanpercentile(np.abs(channels[name]), 95) > largest:
            row = int(np.nanargmax(np.abs(channels[name])))
            unit = CHANNEL_UNITS[name]
            raise ValueError(
                f"{path}: column {sources[name].column!r}, row {row + 1}: expected {unit} (95 % within {largest}), found "
                f'{channels[name][row]:.4g}: degrees? A column map with unit = "{unit.replace("rad", "deg")}" converts'
            )


def _spans(t: Array) -> tuple[Rows, Rows]:
    """First and last rows of spans of about SPAN, one after the other."""
    first = np.searchsorted(t, np.arange(t[0], t[-1] - SPAN, SPAN))
    last = np.searchsorted(t, t[first] + SPAN)
    inside = last < len(t)
    return first[inside], last[inside]


def _integral(t: Array, rate: Array, spans: tuple[Rows, Rows]) -> Array:
    """Integral of `rate` over each span, on straight lines between its samples: it may be slower than the rows. NaN over a span
    in which it is missing for longer than usual."""
    good = np.isfinite(rate)
    if good.sum() < 2:
        return np.full(len(spans[0]), np.nan)
    filled, missing = np.interp(t, t[good], rate[good]), np.concatenate([[0], np.cumsum(~near_samples(t, t[good]))])
    total = np.concatenate([[0.0], np.cumsum(0.5 * (filled[1:] + filled[:-1]) * np.diff(t))])
    return np.where(missing[spans[1] + 1] > missing[spans[0]], np.nan, total[spans[1]] - total[spans[0]])


def _check_heading(
    path: Path, sources: Mapping[str, Source], t: Array, channels: Mapping[str, Array], spans: tuple[Rows, Rows]
) -> None:
    """Heading in degrees turns 57.3 times as fast as the yaw rate says, a flipped one against it; which of the two is flipped,
    the steering tells."""
    psi, rate, column = channels["psi"], channels["omega_z"], sources["psi"].column
    turned, expected = psi[spans[1]] - psi[spans[0]], _integral(t, rate, spans)
    good = np.isfinite(turned) & np.isfinite(expected)
    turned, expected = turned[good], expected[good]
    if np.sum(expected**2) < 0.2:
        return
    # Wrapped headings: in radians the turn that fits best modulo 2 pi tells the sign, jumps of 360 are left out for degrees.
    steady = np.abs(turned) < 180
    slope = float(turned[steady] @ expected[steady]) / max(float(expected[steady] @ expected[steady]), 1e-9)
    near, mirrored = (np.median(np.abs(np.angle(np.exp(1j * (turned - side * expected))))) for side in (1.0, -1.0))
    if abs(slope) > 0.5 * DEGREES and near > MODULO:
        raise ValueError(
            f"{path}: column {column!r}: expected rad, found a heading that turns {abs(slope):.0f} times as fast as the yaw "
            'rate says: degrees? A column map with unit = "deg" converts'
        )
    if mirrored < 0.5 * near:
        if against("steer", channels):
            raise ValueError(
                f"{path}: column {sources['omega_z'].column!r}: expected a yaw rate that grows to the left (ISO 8855), found the "
                "opposite of what heading and steering say: a column map with sign = -1 converts, and of an inertial sensor that "
                'hangs upside down a source with frame = "z-down" in the map of softsoil import'
            )
        raise ValueError(
            f"{path}: column {column!r}: expected a heading that grows to the left as the yaw rate does (ISO 8855), found the "
            "opposite: a column map with sign = -1 converts, and a bearing from north one of softsoil import with compass = true"
        )


def against(name: str, channels: Mapping[str, Array]) -> bool:
    """Whether a channel and the yaw rate, driving forward, have opposite signs; False without the channel or the speed."""
    if not {name, "u"} <= set(channels):
        return False
    value, rate = channels[name], channels["omega_z"]
    rows = np.isfinite(value) & np.isfinite(rate) & (channels["u"] > FORWARD)
    moves = rows.any() and value[rows].std() > 0 and rate[rows].std() > 0
    return bool(moves and np.corrcoef(value[rows], rate[rows])[0, 1] < -LIKELY)


def _check_speed(path: Path, column: str, t: Array, channels: Mapping[str, Array], spans: tuple[Rows, Rows]) -> None:
    """Speed in km/h is 3.6 times what the positions say."""
    moved = np.hypot(*(channels[name][spans[1]] - channels[name][spans[0]] for name in ("x", "y")))
    said = _integral(t, channels["u"], spans)
    good = np.isfinite(moved) & (np.abs(said) > 2.0)
    if good.sum() < 3:
        return
    ratio = float(np.median(np.abs(said[good])) / max(float(np.median(moved[good])), 1e-9))
    if 0.7 * KMH < ratio < 1.4 * KMH:
        raise ValueError(
            f"{path}: column {column!r}: expected m/s, found speeds {ratio:.1f} times as fast as the positions move: km/h? "
            'A column map with unit = "km/h" converts'
        )
