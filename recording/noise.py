"""Sensor noise added to clean logs, by name and seed, and the low-pass that some loggers put behind their sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from scipy.signal import filtfilt, lfilter

from softsoil.recording.drive import Array, Recording

TABLE5: Mapping[str, float] = MappingProxyType(
    {"x": 1.2, "y": 1.2, "psi": 0.0175, "u": 0.25, "v": 0.25, "omega_z": 0.0175}
)
"""The paper's Table 5: standard deviations, SI units."""

GOOD: Mapping[str, float] = MappingProxyType(
    {
        "x": 0.05, "y": 0.05, "psi": 0.003, "u": 0.05, "v": 0.05, "omega_z": 0.005, "a_x_imu": 0.15, "a_y_imu": 0.15,
        "steer": 0.002, "omega_fl": 0.1, "omega_fr": 0.1, "omega_rl": 0.1, "omega_rr": 0.1,
    }
)  # fmt: skip
"""A good sensor set (the noise of the `undeclared_*` drives), SI units."""

NOISES: Mapping[str, Mapping[str, float]] = MappingProxyType({"none": {}, "table5": TABLE5, "good": GOOD})


def add_noise(recording: Recording, noise: str | Mapping[str, float], seed: int | Sequence[int]) -> Recording:
    """The drive with independent Gaussian noise on its sensor channels; truth is untouched.

    noise: a name of NOISES or standard deviations by channel; seed: of the generator, several numbers for one that no
    single number gives. ValueError for an unknown name.
    """
    if isinstance(noise, str):
        if noise not in NOISES:
            raise ValueError(f"noise: expected one of {', '.join(NOISES)}; found {noise!r}")
        noise = NOISES[noise]
    rng = np.random.default_rng(seed)
    noisy = {
        name: recording[name] + sigma * rng.standard_normal(len(recording))
        for name, sigma in noise.items()
        if name in recording
    }
    return recording.with_channels(**noisy)


def low_pass(values: Array, dt: float, seconds: float, twice: bool = False) -> Array:
    """(N,) values (N,) of period dt (s) through a first-order low-pass of a time constant of so many seconds, which starts at the
    first value; twice: run backwards as well, so that nothing is late."""
    kept = float(np.exp(-dt / seconds))
    top, below = [1.0 - kept], [1.0, -kept]
    if twice:
        return np.asarray(filtfilt(top, below, values), dtype=float)
    return np.asarray(values[0] + lfilter(top, below, values - values[0]), dtype=float)
