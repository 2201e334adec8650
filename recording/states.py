"""States as a drive has them, and the noise of their sensors."""

from __future__ import annotations

import numpy as np

from softsoil.recording.drive import STATE_CHANNELS, Array, Recording
from softsoil.recording.noise_level import NoiseLevel, noise_level


def measured_states(recording: Recording, names: tuple[str, ...] = STATE_CHANNELS) -> Array:
    """(N, 6) measured states, psi unwrapped; missing values stay NaN, and channels that are derived or absent are NaN whole."""
    states = known_states(recording, names)
    for i, name in enumerate(names):
        if not recording.measured(name):
            states[:, i] = np.nan
    return states


def known_states(recording: Recording, names: tuple[str, ...] = STATE_CHANNELS) -> Array:
    """(N, 6) states as far as they are known, derived ones included: where a model may start, not what may judge it."""
    blank = np.full(len(recording), np.nan)
    states = np.column_stack([recording.channels.get(name, blank) for name in names])
    if "psi" in names:
        column = names.index("psi")
        good = np.isfinite(states[:, column])
        states[good, column] = np.unwrap(states[good, column])
    return states


def sensor_std(recording: Recording, floor: Array, names: tuple[str, ...] = STATE_CHANNELS) -> Array:
    """(n,) standard deviation of the noise of each channel, at least `floor` (n,); of correlated noise, of the white one that
    counts as much."""
    return np.maximum([noise.white for noise in _levels(recording, names)], floor)


def sample_std(recording: Recording, floor: Array, names: tuple[str, ...] = STATE_CHANNELS) -> Array:
    """(n,) standard deviation of the noise in a sample of each channel, at least `floor` (n,): that of `sensor_std` where it is
    white, less where a filter has smoothed it."""
    return np.maximum([noise.std for noise in _levels(recording, names)], floor)


def _levels(recording: Recording, names: tuple[str, ...]) -> list[NoiseLevel]:
    states = measured_states(recording, names)
    return [noise_level(states[:, i], recording.dt) for i in range(len(names))]
