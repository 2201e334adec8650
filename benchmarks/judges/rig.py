"""The plant's single-wheel rig against runs of the independent simulator's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.rig import CHANNELS, run_rig
from softsoil.plant.rig_sweep import run_of

CLOCK_LEAD = 0.002
"""The reference's rows lie 2 ms after their label (s): the phase of its yaw angle says so."""


def errors(path: Path, every: int, cast: bool = False) -> NDArray[np.float64]:
    """(runs, 5) rms error of fx, fy, fz over the reference's peak lateral force, mean error of the wheel's height (mm) and
    of the moment about its axle (N m)."""
    data = np.load(path, allow_pickle=False)
    times, found = data["t"], []
    for row, reference in zip(data["conditions"][::every], data["series"][::every].astype(float), strict=True):
        t, ours = run_rig(run_of(row, path.stem.split("_")[0]), duration=float(times[-1]) + 0.01, every=1, cast=cast)
        rows = np.searchsorted(t, times + CLOCK_LEAD - 1e-6)
        peak = np.abs(reference[:, CHANNELS.index("fy")]).max()
        difference = {name: ours[rows, k] - reference[:, k] for k, name in enumerate(CHANNELS)}
        forces = [np.sqrt(np.mean(difference[name] ** 2)) / peak for name in ("fx", "fy", "fz")]
        found.append([*forces, 1e3 * difference["wheel_z"].mean(), difference["my"].mean()])
    return np.array(found)
