"""Grid convergence: forces of a single-wheel run against the spacing of the soil's grid.

    python -m benchmarks.plant_grid [--figure docs/pictures/plant_grid.png]

The paper's Table 3 run (clay, 1 Hz, 20 deg) at constant step; the error is the rms difference of the lateral force (over 25 ms)
to the finest grid, over its peak; so it holds the grid's own noise and its bias.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.ndimage import uniform_filter1d

from softsoil.figures.labels import plain
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, TRUE, page
from softsoil.plant.rig import Rig, RigRun, run_rig
from softsoil.plant.world import SPACING
from softsoil.symbolic.soil import SOILS

FINEST = 0.005
SPACINGS = (0.06, 0.04, 0.03, 0.025, 0.02, 0.015, 0.01, 0.0075)


def main() -> None:
    """Print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figure", type=Path)
    arguments = parser.parse_args()
    table = {}
    for soil in SOILS.values():
        run = RigRun(soil, load=2500.0, slip=0.2, speed=5.5, amplitude=np.deg2rad(20.0), frequency=1.0)
        forces = {}
        for spacing in (FINEST, *SPACINGS):
            t, values = run_rig(run, 2.6, Rig(spacing=spacing), every=1)
            forces[spacing] = uniform_filter1d(values[t >= 1.0, 3], 25)
        exact = forces[FINEST]
        peak = np.abs(exact).max()
        table[soil.name] = [float(np.sqrt(np.mean((forces[s] - exact) ** 2)) / peak) for s in SPACINGS]
    print(f"{'spacing, m':<12}" + "".join(f"{name:>14}" for name in table))
    for k, spacing in enumerate(SPACINGS):
        print(f"{spacing:<12}" + "".join(f"{100 * errors[k]:>12.2f} %" for errors in table.values()))
    if arguments.figure:
        draw(table, arguments.figure)


def draw(table: dict[str, list[float]], path: Path) -> None:
    """Error against spacing, both logarithmic."""
    with page(path, "Error of the soil contact model against its grid", 7, 4) as axis:
        for (name, errors), color in zip(table.items(), (ESTIMATED, REAR, INITIAL), strict=True):
            axis.loglog(1e3 * np.array(SPACINGS), 100 * np.array(errors), "o-", color=color, label=plain(name))
        axis.loglog(1e3 * np.array(SPACINGS), 100 * np.array(SPACINGS), ":", color=TRUE, lw=0.9, label="first order")
        axis.axvline(1e3 * SPACING, color=SOFT, lw=0.9, label="spacing of the drives")
        axis.set_xticks([1e3 * s for s in SPACINGS], [f"{1e3 * s:g}" for s in SPACINGS])
        axis.set_xticks([], minor=True)
        axis.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axis.set(xlabel="grid spacing, mm", ylabel="rms error of the lateral force over its peak, %")
        axis.legend()
    print(path)


if __name__ == "__main__":
    main()
