"""One even clock: a drive with jitter or gaps brought to equal steps, nothing invented inside a gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from recording.drive import Array, Recording

LARGEST_JITTER = 0.1
"""Share of a step: below it, the clock is even enough for equal steps to be taken for granted."""
BRIDGED = 1.5
"""Steps: samples at most this far apart are joined by a straight line; a wider gap stays empty (NaN)."""


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

    Values are interpolated between samples at most BRIDGED steps apart, and NaN elsewhere; psi is unwrapped first.
    """
    if is_even(recording):
        return recording
    t, dt = recording.t, recording.dt
    clock = t[0] + dt * np.arange(int(np.floor((t[-1] - t[0]) / dt + 1e-6)) + 1)
    channels = {
        name: clock if name == "t" else _at(clock, t, _unwrapped(name, v), dt) for name, v in recording.channels.items()
    }
    truth = {name: _at(clock, t, values, dt) for name, values in recording.truth.items()}
    note = f"t: uneven steps brought to {dt:.4g} s; gaps stay empty"
    return replace(recording, channels=channels, truth=truth, notes=(*recording.notes, note))


def _unwrapped(name: str, values: Array) -> Array:
    if name != "psi":
        return values
    out, good = values.copy(), np.isfinite(values)
    out[good] = np.unwrap(out[good])
    return out


def _at(clock: Array, t: Array, values: Array, dt: float) -> Array:
    good = np.isfinite(values)
    if not good.any():
        return np.full(len(clock), np.nan)
    t, values = t[good], values[good]
    out = np.interp(clock, t, values)
    after = np.clip(np.searchsorted(t, clock), 0, len(t) - 1)
    before = np.maximum(after - 1, 0)
    near = np.minimum(np.abs(t[after] - clock), np.abs(t[before] - clock))
    wide = (t[after] - t[before] > BRIDGED * dt) & (near > 0.01 * dt)
    outside = (clock < t[0]) | (clock > t[-1])
    out[wide | outside] = np.nan
    return out
