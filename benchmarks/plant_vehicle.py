"""The plant against the independent simulator's drives: the same start, steering and throttle, 15 s windows.

    python -m benchmarks.plant_vehicle ../shared/data/chrono_vehicle [--drives paper multi steps] [--figure docs/x.png]

The plant's wheels find the soil as the independent simulator's do (`plant/reference/raycast.py`); as cylinders with --exact; with
--carried the vehicle's own steering, whose idler arm pushes the chassis as it is pushed.
The drives paper_*, multi_* and steps_* judge; the effect_* drives were looked at while the plant was built (--drives
effect); change_* has a border in its soil (--drives change).
Per window: yaw rate and lateral velocity, rms error over their own rms; per-axle lateral force correlation and gain;
the ratio of rear to front lateral force and the yaw moment -c M a_y of the wheels' longitudinal forces, each against
the log's.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed

from benchmarks.judges.drive_windows import axle_force, compare, window, windows, with_the_others_steering
from softsoil.figures.labels import Quantity, quantity
from softsoil.figures.style import ESTIMATED, TRUE, page
from softsoil.plant.machine import load_plant_vehicle
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--drives", nargs="+", default=["paper", "multi", "steps"], help="beginnings of the names")
    parser.add_argument("--figure", type=Path, help="draw the last window of the last drive")
    parser.add_argument("--hold-speed", action="store_true", help="give the plant the log's u and wheel speeds")
    parser.add_argument("--hold-gear", action="store_true", help="shift the plant's gears when the log's were")
    parser.add_argument(
        "--exact", action="store_true", help="wheels as cylinders, not as the other's ray cast finds them"
    )
    parser.add_argument("--carried", action="store_true", help="the vehicle's own steering, not the other's")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    columns = ("omega_z", "v", "u", "corr_f", "corr_r", "gain_f", "gain_r", "ratio", "c", "c_log")
    print(f"{'drive':<24}{'from':>5}" + "".join(f"{name:>9}" for name in columns))
    logs = [read_drive(path) for d in arguments.drives for path in sorted(arguments.folder.glob(f"{d}_*.csv.gz"))]
    tasks = [(log, begin) for log in sorted(logs, key=lambda log: log.name) for begin in windows(log)]
    vehicle = load_plant_vehicle() if arguments.carried else with_the_others_steering()
    options = {"vehicle": vehicle, "hold_speed": arguments.hold_speed, "hold_gear": arguments.hold_gear}
    options["cast"] = not arguments.exact
    runs = Parallel(n_jobs=arguments.workers, return_as="generator")(
        delayed(window)(log, begin, **options) for log, begin in tasks
    )
    table = []
    for (log, begin), (ours, theirs) in zip(tasks, runs, strict=True):
        found = compare(ours, theirs)
        table.append([found[name] for name in columns])
        print(f"{log.name:<24}{begin:>5.0f}" + "".join(f"{value:>9.3f}" for value in table[-1]), flush=True)
    for label, reduce in (("median", np.median), ("greatest", np.max), ("least", np.min)):
        print(f"{label:<29}" + "".join(f"{value:>9.3f}" for value in reduce(table, axis=0)))
    tracked = np.mean([max(row[0], row[1]) <= 0.15 for row in table])
    correlated = np.mean([min(row[3], row[4]) >= 0.97 for row in table])
    print(f"omega_z and v within 15 %: {tracked:.0%} of {len(table)} windows; correlation >= 0.97: {correlated:.0%}")
    if arguments.figure:
        draw(ours, theirs, arguments.figure)


def draw(ours: Recording, log: Recording, path: Path) -> None:
    """Yaw rate, lateral velocity, speed and rear lateral force of both."""
    with page(path, f"{log.name}: same start, steering and throttle", 9, 5, 2, 2, sharex=True) as axes:
        for axis, name in zip(axes.flat, ("omega_z", "v", "u", ""), strict=True):
            shown = quantity(name) if name else Quantity("lateral force, rear axle", "N")
            for drive, color, line, who in ((log, TRUE, "-", "independent simulator"), (ours, ESTIMATED, "--", "plant")):
                values = shown.factor * drive[name] if name else axle_force(drive, "r")
                axis.plot(drive.t, values, line, color=color, lw=1.1, label=who)
            axis.set_ylabel(shown.label)
        for axis in axes[1]:
            axis.set_xlabel("time, s")
        axes[1, 0].legend(loc="lower left")
    print(path)


if __name__ == "__main__":
    main()
