"""Our single-wheel rig against the independent simulator's `val` runs: rms force error over the peak lateral force.

    python -m benchmarks.plant_rig ../shared/data/chrono_rig [--set val] [--every 1] [--cast]

Nothing is fitted: the rig's facts are in `softsoil.plant.rig`, the soil is that of each run.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.rig import errors


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
