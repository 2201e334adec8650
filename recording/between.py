"""Rows between the samples of a slower sensor: a value that is held, or a straight line, measures nothing there.

Tables of one rate often hold slower channels so. Taken for measurements, such rows make the sensor's noise look smaller than it
is, and a good model looks wrong.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Array, Recording

Rows = NDArray[np.bool_]
LONGEST = {
    **dict.fromkeys(STATE_CHANNELS, 1.5), **dict.fromkeys(("steer", *WHEEL_CHANNELS, "a_x_imu", "a_y_imu"), 0.25),
}  # fmt: skip
"""Channel -> longest time (s) between its samples; a steering angle that stands for longer is held by the driver."""
FEWEST = 20
"""Samples in a drive below which nothing is said of their rate."""
REGULAR = 0.9
"""Share of the distances between samples that stand within a row, or a quarter, of their mean."""
LASTING = 0.5
"""Share of the time between samples that such distances take: where few long ones take the rest, a channel stands still."""
STRAIGHT, BENT = 0.02, 0.995
"""Change of slope up to which a line is straight, over that at samples: over the quantile of all rows that is surely one."""
ROUNDED = 2.5
"""Steps of a channel's numbers over a row, as they are rounded, up to which a change of slope is none."""
HIDDEN = 0.2
"""The same over a change at samples, from which rounding hides where samples are."""
CURVED = 0.05
"""Share of the rows that bend that do so between two others that do, beyond which the channel is a curve: a line bends at one
row, or at the two beside a sample."""
MOST_ROWS = 0.6
"""Share of all rows that may hold samples: where more do, most rows are measured."""


def only_samples(recording: Recording) -> Recording:
    """The drive with channels empty (NaN) in rows between their samples, which a note says; unchanged where every row is
    measured: states are not compared there, and inputs are interpolated.

    recording: as it was read.
    """
    channels, notes = dict(recording.channels), []
    for name in LONGEST:
        if name not in channels or recording.state_of(name) != "measured":
            continue
        found = samples(name, recording.t, channels[name])
        if found is not None:
            channels[name] = np.where(found[0], channels[name], np.nan)
            notes.append(found[1])
    return replace(recording, channels=channels, notes=(*recording.notes, *notes)) if notes else recording


def samples(name: str, t: Array, values: Array) -> tuple[Rows, str] | None:
    """(N,) which rows of the channel called `name` hold a sample, and a note that says so; None where all do, as far as it shows.

    name: of the channel; t (N,): s; values (N,), NaN in rows that are empty already.
    """
    good = np.isfinite(values)
    found, words = held(values[good]), "each value is held"
    if found is None and name in STATE_CHANNELS:  # of an input that is a line, nothing would be another
        found, words = straight(t[good], values[good]), "a straight line"
    if found is None:
        return None
    rows = np.zeros(len(t), dtype=bool)
    rows[good] = found
    every = float(np.median(np.diff(t[rows])))
    if not every <= LONGEST.get(name, 0.0):
        return None
    return rows, f"{name}: {words} between samples {every:.3g} s from each other; the rows between are left empty"


def held(values: Array) -> Rows | None:
    """(N,) which rows hold a new sample, of a channel that repeats each until the next; None for any other channel.

    values (N,): of the channel, finite.
    """
    new = np.ones(len(values), dtype=bool)
    new[1:] = values[1:] != values[:-1]
    return new if _regular(new) else None


def straight(t: Array, values: Array) -> Rows | None:
    """(N,) which rows hold a sample, of a channel (N,) that is a straight line between them; None for any other channel.

    t (N,): s; values (N,): of the channel, finite. Where a sample stood between two rows, the line bends at both: the nearer one,
    which bends more, is taken.
    """
    if len(values) < FEWEST:
        return None
    bend = np.zeros(len(values))
    bend[1:-1] = np.abs(np.diff(np.diff(values) / np.diff(t)))
    steps = np.diff(np.unique(values))
    rounded = ROUNDED * float(steps.min()) / float(np.median(np.diff(t))) if len(steps) else np.inf
    sharp = float(np.quantile(bend, BENT))
    bent = bend > max(STRAIGHT * sharp, rounded)
    curved = (bent[2:] & bent[1:-1] & bent[:-2]).sum() > CURVED * bent.sum()
    if curved or rounded > HIDDEN * sharp or not _regular(bent & ~np.concatenate([[False], bent[:-1]])):
        return None
    after, before = np.append(bend[1:], 0.0), np.insert(bend[:-1], 0, 0.0)
    return bent & (bend >= before) & (bend > after)


def _regular(rows: Rows) -> bool:
    """Whether rows (N,) stand at one distance from each other and are less than MOST_ROWS of all."""
    places = np.flatnonzero(rows)
    if len(places) < FEWEST or rows.mean() > MOST_ROWS:
        return False
    apart = np.diff(places)
    usual = float(np.mean(apart[apart <= 3.0 * np.median(apart)]))
    near = np.abs(apart - usual) < max(1.0, 0.25 * usual)
    lasts = apart[near].sum() >= LASTING * apart.sum()
    return bool(near.mean() >= REGULAR and lasts and usual * MOST_ROWS >= 1.0)
