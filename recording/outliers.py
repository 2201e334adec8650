"""Samples that stand out from their neighbours: a sensor's or a bus's fault, which a least-squares fit would follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Array, Recording

LEAST = {
    **dict(zip(STATE_CHANNELS, (0.3, 0.3, 0.05, 0.3, 0.2, 0.1), strict=True)), "steer": 0.05,
    **dict.fromkeys(WHEEL_CHANNELS, 2.0), "a_x_imu": 4.0, "a_y_imu": 4.0,
}  # fmt: skip
"""Channel -> distance from the median of its neighbours (unit of the channel) up to which a sample is none."""
BEYOND = 8.0
"""The same in robust standard deviations of all distances: noise, and motion between slow samples, are in them."""
SIDE = 2
"""Neighbours to each side."""
SPREAD = 3.0
"""The same in the spread of the three neighbours that agree best: a peak of the motion has risen before and falls after."""
FEWEST = 20
"""Samples of a channel below which nothing is said."""
GLIMPSE = 2
"""Samples of a channel that say nothing of its course."""
ABSURD = {
    "x": 1e8, "y": 1e8, "psi": 1e4, "u": 1e3, "v": 1e3, "omega_z": 1e3, "steer": 1e3, **dict.fromkeys(WHEEL_CHANNELS, 1e4),
    "a_x_imu": 1e4, "a_y_imu": 1e4,
}  # fmt: skip
"""Channel -> size that no number of it has in any unit in use (rad and degrees, m and mm)."""
FEW, MOST = 0.005, 0.1
"""Shares of a channel's samples: fewer may be jolts of the vehicle, which robust fits bear; more are no outliers."""


def without_absurd(recording: Recording) -> Recording:
    """The drive with numbers that no vehicle's sensor can mean, infinite ones among them, empty (NaN), which a note says.

    recording: unchanged where there is none; a channel that has more than FEW of them is in another unit, and stays as it is.
    """
    channels, counts = dict(recording.channels), {}
    for name, limit in ABSURD.items():
        values = channels.get(name)
        if values is None or recording.state_of(name) == "absent":
            continue
        infinite = np.isinf(values)
        far = np.abs(np.where(infinite, np.nan, values)) > limit
        out = infinite | far if far.mean() < FEW else infinite
        if out.any():
            channels[name], counts[name] = np.where(out, np.nan, values), int(out.sum())
    if not counts:
        return recording
    words = ", ".join(f"{name} {count}" for name, count in counts.items())
    return replace(recording, channels=channels, notes=(*recording.notes, f"numbers that cannot be are left out: {words}"))


def without_glimpses(recording: Recording) -> Recording:
    """The drive without channels of at most GLIMPSE samples, as a heading that is stated once: absent, which a note says.

    recording: unchanged where there is none, or where it has no more rows; positions are one channel.
    """
    if len(recording) <= GLIMPSE:
        return recording
    groups = (("x", "y"), *((name,) for name in recording.channels if name in ABSURD and name not in ("x", "y")))
    state, notes = dict(recording.state), []
    for group in groups:
        most = min(int(np.isfinite(recording[name]).sum()) if name in recording else 0 for name in group)
        if 0 < most <= GLIMPSE and all(recording.state_of(name) == "measured" for name in group):
            state |= dict.fromkeys(group, "absent")
            notes.append(f"{', '.join(group)}: at most {GLIMPSE} values in the whole log say nothing of a course; set aside")
    return replace(recording, state=state, notes=(*recording.notes, *notes)) if notes else recording


def without_outliers(recording: Recording) -> Recording:
    """The drive with samples that stand out from their neighbours empty (NaN), which a note says; unchanged where there is none.

    recording: as it was read.
    """
    channels, counts = dict(recording.channels), {}
    for name in LEAST:
        if name in channels and recording.state_of(name) == "measured":
            out = outliers(name, channels[name])
            if out.any():
                channels[name] = np.where(out, np.nan, channels[name])
                counts[name] = int(out.sum())
    if not counts:
        return recording
    return replace(recording, channels=channels, notes=(*recording.notes, left_out(counts)))


def left_out(counts: Mapping[str, int]) -> str:
    """The note that says how many samples of each channel are left out; counts: channel -> how many."""
    words = ", ".join(f"{name} {count}" for name, count in counts.items())
    return f"samples that stand out from their neighbours are left out: {words}"


def outliers(name: str, values: Array) -> NDArray[np.bool_]:
    """(N,) which samples of the channel called `name`, values (N,), stand out from their neighbours; none where they are few,
    or of a channel that LEAST does not name."""
    out, rows = np.zeros(len(values), dtype=bool), np.flatnonzero(np.isfinite(values))
    if len(rows) < FEWEST or name not in LEAST:
        return out
    seen = np.unwrap(values[rows]) if name == "psi" else values[rows]
    around = np.lib.stride_tricks.sliding_window_view(np.pad(seen, SIDE, mode="reflect"), 2 * SIDE + 1)
    others = np.sort(np.delete(around, SIDE, axis=1), axis=1)
    spread = np.minimum(others[:, 2] - others[:, 0], others[:, 3] - others[:, 1])
    away = np.abs(seen - 0.5 * (others[:, 1] + others[:, 2]))
    found = (away > max(LEAST[name], BEYOND * 1.4826 * float(np.median(away)))) & (away > SPREAD * spread)
    if FEW <= found.mean() <= MOST:
        out[rows] = found
    return out
