"""The parts of a drive that a vehicle model can use: driven forwards, on fresh soil, with inputs that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Array, Recording

STANDING = 0.2
"""m/s: below this the vehicle stands, crawls or reverses: slip has no meaning there."""
STANDSTILL = 0.2
"""s: a standstill lasts this long at least; a shorter one is noise."""
REVERSING = -0.2
"""m/s: below this it reverses."""
NO_WINDOW = "n learns little there, and no window of a fit or of predictions runs across it"
"""What follows where inputs are missing."""
HELD_INPUTS = 0.25
"""s: how long a steering angle or a wheel's speed that is missing is taken to stay as it was, or to follow a line."""
MISSED = 2.5
"""The same for a slower sensor, in its usual intervals."""
LONGEST_INTERVAL = 2.0
"""s: between rarer samples of a state nothing is known of it."""
ROUNDING = 1e-6
"""s: times closer than this are one."""


def driven(recording: Recording, start: float = 0.0) -> NDArray[np.bool_]:
    """(N,) whether each row is driven forwards, and by `start` seconds later than the last standstill or reversing.

    Missing speeds are interpolated. A drive without a speed stands.
    """
    t = recording.t
    if not np.isfinite(recording["u"]).any():
        return np.zeros(len(t), dtype=bool)
    forwards = np.ones(len(t), dtype=bool)
    for first, last in slower(recording, STANDING):
        forwards[first : max(last, int(np.searchsorted(t, t[last - 1] + start, side="right")))] = False
    return forwards


def in_ruts(recording: Recording) -> NDArray[np.bool_]:
    """(N,) whether a wheel runs in a rut of earlier in the drive at each time, as `Recording.ruts` says."""
    inside = np.zeros(len(recording), dtype=bool)
    for first, last in recording.ruts:
        inside |= (recording.t >= first) & (recording.t <= last)
    return inside


def inputs_known(recording: Recording) -> NDArray[np.bool_]:
    """(N,) whether steering angle and wheel speeds are known in each row: of each that the drive has, there is a number, or one
    before and one after no farther from each other than HELD_INPUTS or MISSED intervals of the sensor; at its ends, one within
    HELD_INPUTS."""
    known = np.ones(len(recording), dtype=bool)
    for name in ("steer", *WHEEL_CHANNELS):
        if name in recording and recording.measured(name):
            known &= near_samples(recording.t, recording.t[np.isfinite(recording[name])], HELD_INPUTS)
    return known


def states_known(recording: Recording, least: float) -> NDArray[np.bool_]:
    """(N,) whether each row lies near samples of every state that is measured: as `near_samples` with `least` (s), or within that
    of one where they are rarer than every LONGEST_INTERVAL."""
    known = np.ones(len(recording), dtype=bool)
    for name in STATE_CHANNELS:
        seen = recording.t[np.isfinite(recording[name])] if recording.measured(name) else np.zeros(0)
        if len(seen) > 1 and np.median(np.diff(seen)) <= LONGEST_INTERVAL:
            known &= near_samples(recording.t, seen, least)
        elif len(seen):
            known &= np.abs(recording.t[:, None] - seen).min(axis=1) <= least
    return known


def accelerometer_known(recording: Recording) -> NDArray[np.bool_]:
    """(N,) whether the accelerometer along the vehicle, where there is one, has a number near each row, as `inputs_known`."""
    if "a_x_imu" not in recording or not np.isfinite(recording["a_x_imu"]).any():
        return np.ones(len(recording), dtype=bool)
    return near_samples(recording.t, recording.t[np.isfinite(recording["a_x_imu"])], HELD_INPUTS)


def usable_rows(recording: Recording) -> NDArray[np.bool_]:
    """(N,) whether a window may run across each row: the inputs are known, and no wheel runs in a rut of the drive's own."""
    return inputs_known(recording) & ~in_ruts(recording)


def near_samples(t: Array, seen: Array, least: float = 0.0) -> NDArray[np.bool_]:
    """(N,) whether each time t (N,) is that of a sample, or lies between two that are no farther from each other than `least` (s)
    or MISSED times as far as is usual, or lies within `least` of the first or last; seen (K,): times of the samples (s)."""
    if len(seen) < 2:
        return np.ones(len(t), dtype=bool)
    after = np.minimum(np.searchsorted(seen, t - ROUNDING), len(seen) - 1)
    before = np.searchsorted(seen, t + ROUNDING, side="right") - 1
    inside = (t >= seen[0] - least - ROUNDING) & (t <= seen[-1] + least + ROUNDING)
    apart = seen[after] - seen[np.maximum(before, 0)]
    return inside & (apart <= max(least, MISSED * float(np.median(np.diff(seen)))) + ROUNDING)


def slower(recording: Recording, speed: float) -> list[tuple[int, int]]:
    """(first row, row after the last) of each stretch of a STANDSTILL or longer below a speed (m/s)."""
    u, t = recording["u"], recording.t
    good = np.isfinite(u)
    slow = np.interp(t, t[good], u[good]) < speed if good.any() else np.zeros(len(t), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]]).astype(int))).reshape(-1, 2)
    return [(int(first), int(last)) for first, last in edges if t[last - 1] - t[first] >= STANDSTILL]


def with_note_of_reversing(recording: Recording) -> Recording:
    """The recording with a note of how long the vehicle reverses in it, where it does for longer than a STANDSTILL."""
    t = recording.t
    times = [(float(t[last - 1] - t[first]), float(t[first])) for first, last in slower(recording, REVERSING)]
    if not times:
        return recording
    note = (
        f"u: the vehicle reverses for {sum(length for length, _ in times):.3g} s in this log, first at {times[0][1]:.4g} s; the "
        "model does not: n is held there, and no window of a fit or of predictions runs across it"
    )
    return recording if note in recording.notes else replace(recording, notes=(*recording.notes, note))


def with_note_of_gaps(recording: Recording) -> Recording:
    """The recording with a note of how long its inputs are unknown, where they are."""
    gaps = (
        (~inputs_known(recording), "steering or wheel speeds", NO_WINDOW),
        (~accelerometer_known(recording), "a_x_imu", "the slope of u stands in for it there"),
    )
    notes = tuple(
        f"{what} missing for {float(unknown.sum()) * recording.dt:.3g} s in this log, first at "
        f"{recording.t[int(np.argmax(unknown))]:.4g} s: {then}"
        for unknown, what, then in gaps
        if unknown.any()
    )
    new = tuple(note for note in notes if note not in recording.notes)
    return replace(recording, notes=(*recording.notes, *new)) if new else recording
