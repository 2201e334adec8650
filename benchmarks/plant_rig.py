"""Our single-wheel rig against the independent simulator's `val` runs: rms force error over the peak lateral force.

    python -m benchmarks.plant_rig ../shared/data/chrono_rig [--set val] [--every 1] [--cast]

Nothing is fitted: the rig's facts are in `softsoil.plant.rig`, the soil is what each run was told.
"""

from __future__ import annotations

import argparse
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


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--set", default="val", choices=("val", "cal"))
    parser.add_argument("--every", type=int, default=1, help="take every so many runs")
    parser.add_argument("--cast", action="store_true", help="find the wheel by the reference's ray cast")
    arguments = parser.parse_args()
    everything = []
    print(f"{'runs':<16}{'':>6}{'F_y median':>12}{'p95':>8}{'F_x median':>14}{'p95':>8}{'height':>12}{'M_y':>12}")
    for path in sorted(arguments.folder.glob(f"*_{arguments.set}.npz")):
        found = errors(path, arguments.every, arguments.cast)
        everything.append(found)
        _row(path.stem, found)
    _row("all", np.concatenate(everything))


def _row(name: str, found: NDArray[np.float64]) -> None:
    x, y = np.percentile(100 * found[:, 0], [50, 95]), np.percentile(100 * found[:, 1], [50, 95])
    print(
        f"{name:<16}{len(found):>6}{y[0]:>10.2f} %{y[1]:>6.2f} %{x[0]:>12.2f} %{x[1]:>6.2f} %"
        f"{np.median(found[:, 3]):>9.2f} mm{np.median(found[:, 4]):>8.1f} N m"
    )


if __name__ == "__main__":
    main()
