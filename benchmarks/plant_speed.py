"""How fast the plant is, whether that depends on the distance, and what its ruts cost.

    python -m benchmarks.plant_speed [--distance 1000]

Prints real-time factors on one core at 2 ms and 0.03 m (and coarser and finer grids), time per step over the distance, and
the memory of the ruts.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from softsoil.plant.manoeuvres import MANOEUVRES, Manoeuvre, MultiSine, Speed
from softsoil.plant.simulate import drive
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.symbolic.soil import CLAY, SANDY_LOAM


def factor(plant: Plant, duration: float) -> float:
    """Simulated over processor time of a multi-sine drive (one thread; other programs on the machine do not count)."""
    begin = time.process_time()
    drive(plant, MANOEUVRES["multi"], duration)
    return duration / (time.process_time() - begin)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--distance", type=float, default=1000.0, help="m")
    arguments = parser.parse_args()
    drive(Plant(CLAY, start=Start(u=5.0)), MANOEUVRES["multi"], 0.1)  # compile
    for spacing in (0.04, 0.03, 0.02):
        found = [factor(Plant(s, start=Start(u=5.0), spacing=spacing), 15.0) for s in (CLAY, SANDY_LOAM)]
        print(f"real-time factor at 2 ms, {spacing} m: clay {found[0]:.1f}, sandy loam {found[1]:.1f}")
    cast = factor(Plant(CLAY, start=Start(u=5.0), cast=True), 15.0)
    print(f"with the reference's ray cast, 0.03 m: clay {cast:.1f}")
    plant, times, covered = Plant(SANDY_LOAM, start=Start(u=6.0)), [], 0.0
    driver = Manoeuvre("long", MultiSine(0.3), Speed(6.5))
    while covered < arguments.distance:
        begin = time.process_time()
        recording = drive(plant, driver, 10.0)
        times.append((time.process_time() - begin) / 10.0 * plant.dt)
        covered += float(np.sum(np.hypot(np.diff(recording["x"]), np.diff(recording["y"]))))
    third = max(len(times) // 3, 1)
    print(
        f"{covered:.0f} m: {1e6 * np.median(times[:third]):.0f} us a step in the first third, "
        f"{1e6 * np.median(times[-third:]):.0f} us in the last; {plant.grid.tiles} tiles, "
        f"{plant.grid.memory / 1e6:.1f} MB in use, {plant.grid.nodes.nbytes / 1e6:.1f} MB held"
    )


if __name__ == "__main__":
    main()
