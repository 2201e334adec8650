"""One even clock: a drive with jitter or gaps brought to equal steps, nothing invented inside a gap; too fast ones slowed."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import STATE_CHANNELS, Array, Recording
from softsoil.recording.forward import near_samples

LARGEST_JITTER = 0.1
"""Share of a step: below it, the clock is even enough for equal steps to be taken for granted."""
REACH = 0.75
"""Steps: a sample farther away than this is not taken; a gap stays empty (NaN)."""
SLOWEST_STEP, FINE_STEP = 0.0135, 0.0125
"""s: a log whose steps are longer than the first is run on steps of the second or less: a steering angle that is held lags by
half a step, which makes n of a fast steering too low (`tests/estimator/test_rates.py`)."""
SLOWER = 1.5
"""Steps: a channel with longer intervals than this is slower than the rows."""
SLOPE_REACH = 3
"""Samples to each side that the local slope is taken over."""


def is_even(recording: Recording) -> bool:
    """Whether every sample stands within LARGEST_JITTER of its place on a clock of equal steps."""
    t = recording.t
    if len(t) < 3:
        return True
    step = (t[-1] - t[0]) / (len(t) - 1)
    places = t[0] + step * np.arange(len(t))
    return bool(np.abs(t - places).max() <= LARGEST_JITTER * step)


def on_even_clock(recording: Recording) -> Recording:
    """The drive on a clock of equal steps, its median interval; unchanged where it already is.

    Each time takes the sample of each channel nearest to it, at most REACH steps away, and NaN where there is none; one of a
    channel that lacks rows goes to one time only. psi is unwrapped first.
    """
    if is_even(recording):
        return recording
    t, dt = recording.t, recording.dt
    clock = t[0] + dt * np.arange(int(np.floor((t[-1] - t[0]) / dt + 1e-6)) + 1)
    channels = {
        name: clock if name == "t" else _own_samples(clock, t, unwrapped(name, values), dt)
        for name, values in recording.channels.items()
    }
    truth = {name: _own_samples(clock, t, values, dt) for name, values in recording.truth.items()}
    note = f"t: uneven steps brought to {dt:.4g} s; gaps stay empty"
    return replace(recording, channels=channels, truth=truth, notes=(*recording.notes, note))


def on_fine_clock(recording: Recording) -> Recording:
    """A drive on equal steps slower than SLOWEST_STEP on a clock an even number of times finer, for a model to run on.

    Inputs are straight lines between samples, empty in gaps; state channels stand at their own samples and are empty between:
    nothing is measured there. Unchanged where it is fast enough.
    """
    dt = recording.dt
    if dt <= SLOWEST_STEP or len(recording) < 2:
        return recording
    times = 2 * int(np.ceil(dt / FINE_STEP / 2 - 1e-9))
    t = recording.t
    clock = np.interp(np.arange(times * (len(t) - 1) + 1) / times, np.arange(len(t)), t)  # dt is rounded: a product would drift
    channels = {"t": clock}
    for name, values in recording.channels.items():
        if name in STATE_CHANNELS:
            channels[name] = np.full(len(clock), np.nan)
            channels[name][::times] = values
        elif name != "t":
            good = np.isfinite(values)
            line = np.interp(clock, t[good], values[good]) if good.any() else np.full(len(clock), np.nan)
            channels[name] = np.where(near_samples(clock, t[good]), line, np.nan)
    truth = {name: np.interp(clock, t, values) for name, values in recording.truth.items()}
    note = f"inputs interpolated from {dt:.4g} to {dt / times:.4g} s"
    return replace(recording, channels=channels, truth=truth, notes=(*recording.notes, note))


def on_coarse_clock(recording: Recording) -> Recording:
    """A drive on steps of which two or more fit into FINE_STEP as medians of blocks of as many; else unchanged.

    What the equations miss is not white: ten times as many rows would be believed three times as far. A block's time is the
    mean of its rows' times; it is empty where all of them are, and rows at the end that fill no block are left out.
    """
    rows = int(FINE_STEP / recording.dt + 1e-6) if len(recording) > 1 else 1
    if rows < 2 or len(recording) < 2 * rows:
        return recording
    log = on_even_clock(recording)
    channels = {name: _blocks(unwrapped(name, values), rows) for name, values in log.channels.items()}
    truth = {name: _blocks(values, rows) for name, values in log.truth.items()}
    note = f"t: {rows} rows of {log.dt:.4g} s made one, their median"
    return replace(log, channels=channels, truth=truth, notes=(*log.notes, note))


def _blocks(values: Array, rows: int) -> Array:
    """(N // rows,) medians of blocks of `rows` values, NaN where a block has none."""
    blocks = values[: len(values) // rows * rows].reshape(-1, rows)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of a block without a number
        return np.nanmedian(blocks, axis=1)


def unwrapped(name: str, values: Array) -> Array:
    """The values (N,) of the channel called `name`, a heading without jumps."""
    if name != "psi":
        return values
    out, good = values.copy(), np.isfinite(values)
    out[good] = np.unwrap(out[good])
    return out


def _own_samples(clock: Array, t: Array, values: Array, dt: float) -> Array:
    """`at_clock` of the samples that a channel has among the rows t (N,): sources of a log may have rows of their own. Of a
    channel that lacks rows each sample goes to one time only, the nearest."""
    rows = np.isfinite(values)
    if rows.all():
        return at_clock(clock, t, values, REACH * dt)
    own = t[rows]
    slower = bool(np.median(np.diff(own)) > SLOWER * dt) if len(own) > 1 else True
    out = at_clock(clock, own, values[rows], REACH * dt, 1 if slower else SLOPE_REACH)
    if len(own):
        nearest = _nearest(own, clock)
        apart, same = np.abs(clock - own[nearest]), nearest[1:] == nearest[:-1]
        out[1:][same & (apart[1:] >= apart[:-1])] = np.nan
        out[:-1][same & (apart[1:] < apart[:-1])] = np.nan
    return out


def at_clock(clock: Array, t: Array, values: Array, reach: float, slope_reach: int = SLOPE_REACH) -> Array:
    """The sample nearest to each time of `clock` (M,), moved along the local slope by what it lies apart; NaN beyond reach (s).

    t, values (N,): the samples; slope_reach: how many to each side the local slope is taken over, none beyond a gap where there
    are others. Interpolation would halve the noise of some samples and tie neighbours together; this keeps it.
    """
    good = np.isfinite(values)
    out = np.full(len(clock), np.nan)
    if not good.any():
        return out
    nearest = _nearest(t, clock)
    apart = clock - t[nearest]
    near = (np.abs(apart) <= reach) & good[nearest]
    slope = np.zeros(len(clock))
    if len(t) > 1:
        filled, far = np.interp(t, t[good], values[good]), (slope_reach + 0.5) * float(np.median(np.diff(t)))
        first = np.maximum(nearest - slope_reach, np.searchsorted(t, t[nearest] - far))
        last = np.minimum(nearest + slope_reach, np.searchsorted(t, t[nearest] + far, side="right") - 1)
        alone = first == last
        first = np.where(alone, np.maximum(nearest - 1, 0), first)
        last = np.where(alone, np.minimum(nearest + 1, len(t) - 1), last)
        slope = (filled[last] - filled[first]) / (t[last] - t[first])
    out[near] = (values[nearest] + slope * apart)[near]
    return out


def _nearest(t: Array, clock: Array) -> NDArray[np.int_]:
    """(M,) index of the sample nearest to each time of `clock` (M,); t (N,): times of the samples, increasing."""
    after = np.clip(np.searchsorted(t, clock), 1, max(len(t) - 1, 1))
    return np.where((len(t) == 1) | (clock - t[after - 1] < t[np.minimum(after, len(t) - 1)] - clock), after - 1, after)
