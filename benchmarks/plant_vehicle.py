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
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from softsoil.plant.effects import Effects
from softsoil.plant.machine import PlantVehicle, load_plant_vehicle
from softsoil.plant.replay import replay
from softsoil.plant.soil_field import SoilField
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive
from softsoil.symbolic.soil import CLAY, SAND, SANDY_LOAM, Soil

Array = NDArray[np.float64]

WINDOW = 15.0
SETTLE = 2.0
"""The logs' first two seconds hold the start-up transient (s)."""
PRESCRIBED = 1e6
"""Natural frequency of a servo that is there within a step (rad/s)."""
HALF_TRACK = 0.616
MASS = 1378.33
CLASSES = {"clay": CLAY, "sandyloam": SANDY_LOAM, "sand": SAND}
EFFECTS = {
    "effect_backlash": (SANDY_LOAM, Effects(steer_backlash=0.0528)),
    "effect_bank": (SANDY_LOAM, Effects(bank=0.0873)),
    "effect_locked_axles": (SANDY_LOAM, Effects(locked_front=True, locked_rear=True)),
    "effect_payload": (CLAY, Effects(payload=300.0, payload_at=(-2.4, 0.0, 0.9))),
    "effect_steer_lag": (SANDY_LOAM, Effects(steer_lag=0.2)),
    "effect_steer_offset": (CLAY, Effects(steer_offset=0.0353)),
    "effect_wind": (SANDY_LOAM, Effects(wind=(0.0, 900.0))),
    "effect_yaw_moment": (CLAY, Effects(yaw_moment=700.0)),
}
"""What the data's README says of the effect drives."""


def conditions(name: str) -> tuple[Soil | SoilField, Effects]:
    """Soil and effects of a drive, from its name."""
    if name in EFFECTS:
        return EFFECTS[name]
    if name == "change_clay_n0.50_to_0.75":
        return SoilField.change_at(CLAY.with_(n=0.5), CLAY.with_(n=0.75), 90.0), Effects()
    match = re.fullmatch(r"\w+?_(clay|sandyloam|sand)_n([\d.]+)", name)
    if not match:
        raise ValueError(f"drive: expected a name such as multi_clay_n0.50, found {name!r}")
    return CLASSES[match[1]].with_(n=float(match[2])), Effects()


def compare(ours: Recording, log: Recording) -> dict[str, float]:
    """Figures of one window."""
    found: dict[str, float] = {}
    for name in ("omega_z", "v", "u"):
        found[name] = _rms(ours[name] - log[name]) / _rms(log[name])
    for axle in "fr":
        a, b = (_axle(r, axle) for r in (ours, log))
        found[f"corr_{axle}"] = float(np.corrcoef(a, b)[0, 1])
        found[f"gain_{axle}"] = float(a @ b / (b @ b))
    found["ratio"] = _rear_over_front(ours) / _rear_over_front(log)
    found["c"], found["c_log"] = yaw_moment_arm(ours), yaw_moment_arm(log)
    return found


def yaw_moment_arm(drive: Recording) -> float:
    """c (m) of M_z = -c sum(F_y), least squares: longitudinal forces times half the track."""
    moment = sum(HALF_TRACK * (drive.truth[f"true_fx_{a}r"] - drive.truth[f"true_fx_{a}l"]) for a in "fr")
    side = _axle(drive, "f") + _axle(drive, "r")
    return float(-np.linalg.lstsq(np.stack([side, np.ones_like(side)], axis=1), moment, rcond=None)[0][0])


def _axle(drive: Recording, axle: str) -> Array:
    return drive.truth[f"true_fy_{axle}l"] + drive.truth[f"true_fy_{axle}r"]


def _rear_over_front(drive: Recording) -> float:
    return _rms(_axle(drive, "r")) / _rms(_axle(drive, "f"))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def windows(log: Recording) -> list[float]:
    """Starts of the windows: after the transient, then every 15 s that fit, the last one flush with the end."""
    starts = list(np.arange(SETTLE, log.t[-1] - WINDOW, WINDOW))
    last = float(np.floor(log.t[-1] - WINDOW))
    return [*starts, last] if last - starts[-1] > 0.5 * WINDOW else starts


def with_the_others_steering() -> PlantVehicle:
    """The plant's vehicle with the other's steering: its angle is prescribed, its idler arm breaks Newton's third law."""
    vehicle = load_plant_vehicle()
    machine = vehicle.machine._replace(idler_error=1.0, servo=np.array([PRESCRIBED, *vehicle.machine.servo[1:]]))
    return replace(vehicle, machine=machine)


def window(log: Recording, begin: float, **options: Any) -> tuple[Recording, Recording]:
    """The plant and the log over one window, on the soil and with the effects of its name; options: of `replay`."""
    soil, effects = conditions(log.name)
    return replay(log, soil, begin, begin + WINDOW, effects=effects, **options)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--drives", nargs="+", default=["paper", "multi", "steps"], help="beginnings of the names")
    parser.add_argument("--figure", type=Path, help="draw the first window of the last drive")
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
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(9, 5), sharex=True)
    rows = [("yaw rate, rad/s", "omega_z"), ("lateral velocity, m/s", "v"), ("speed, m/s", "u"), ("rear F_y, N", "")]
    for axis, (label, name) in zip(axes.flat, rows, strict=True):
        for drive, style, who in ((log, "C0", "independent simulator"), (ours, "C1", "plant")):
            axis.plot(drive.t, drive[name] if name else _axle(drive, "r"), style, lw=0.9, label=who)
        axis.set_title(label, fontsize=9)
        axis.grid(alpha=0.3)
    axes[0, 0].legend(fontsize=8, loc="lower left")
    figure.suptitle(f"{log.name}: same start, steering and throttle", fontsize=10)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    print(path)


if __name__ == "__main__":
    main()
