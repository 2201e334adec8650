"""Sensor noise added to clean logs, by name and seed."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from softsoil.recording.drive import Recording

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


def add_noise(recording: Recording, noise: str | Mapping[str, float], seed: int) -> Recording:
    """The drive with independent Gaussian noise on its sensor channels; truth is untouched.

    noise: a name of NOISES or standard deviations by channel; seed: of the generator. ValueError for an unknown name.
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
