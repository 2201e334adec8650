"""The same drives without v, without wheel speeds, without pose and without all of them: n with its verdict, and the effects.

    python benchmarks/absent_channels.py ../shared/data/chrono_vehicle [--effects steer_lag ...] [--without v ...] [--write PAGE]

With --without only those sets of absent channels; with --no-estimates the effects alone. With --write the tables replace what
stands between the marks in that document.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

from softsoil.checking.usable import mark_checked
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.estimate import estimate
from softsoil.files.package_data import REFERENCE_VEHICLE
from softsoil.recording.derive import completed
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.refine import refine
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import SOILS
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

POSE = ("x", "y", "psi")
WITHOUT = {
    "nothing": (), "v": ("v",), "wheel speeds": WHEEL_CHANNELS, "three wheels": WHEEL_CHANNELS[1:],
    "one wheel": WHEEL_CHANNELS[3:], "one wheel of each axle": WHEEL_CHANNELS[1::2], "pose": POSE,
    "v, wheels, pose": ("v", *WHEEL_CHANNELS, *POSE),
    "v, wheels, pose, accelerometer": ("v", *WHEEL_CHANNELS, *POSE, "a_x_imu", "a_y_imu"),
}  # fmt: skip
DRIVES = ("multi_clay_n0.50", "multi_clay_n0.65", "multi_sandyloam_n0.55", "multi_sandyloam_n0.70")
EFFECT_SOILS = {"bank": "sandy_loam", "payload": "clay", "steer_lag": "sandy_loam", "steer_offset": "clay", "wind": "sandy_loam",
                "yaw_moment": "clay", "backlash": "sandy_loam"}  # fmt: skip
EFFECT_N = {"clay": 0.5, "sandy_loam": 0.7}
FOR_EFFECTS = ("nothing", "v", "wheel speeds", "pose", "v, wheels, pose")
MARKS = ("<!-- absent channels: begin -->", "<!-- absent channels: end -->")
SLOWER = "nothing, 10 Hz"
SLOW = 8
"""Every so many rows of the log at about 10 Hz."""


def main() -> None:
    """Print the tables, write them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--effects", nargs="*", default=list(EFFECT_SOILS))
    parser.add_argument("--without", nargs="*", choices=[*WITHOUT, SLOWER], default=[*WITHOUT, SLOWER])
    parser.add_argument("--no-estimates", action="store_true")
    parser.add_argument("--write", type=Path)
    arguments = parser.parse_args()
    vehicle = load_vehicle(REFERENCE_VEHICLE)
    rows = []
    tables = [] if arguments.no_estimates else [estimates(arguments.folder, vehicle, arguments.without)]
    if arguments.effects:
        tables += [iter([""]), effects(arguments.folder, vehicle, arguments.effects, arguments.without)]
    for row in chain.from_iterable(tables):
        print(row, flush=True)
        rows.append(row)
    if arguments.write:
        before, rest = arguments.write.read_text(encoding="utf-8").split(MARKS[0])
        after = rest.split(MARKS[1])[1]
        arguments.write.write_text(f"{before}{MARKS[0]}\n" + "\n".join(rows) + f"\n{MARKS[1]}{after}", encoding="utf-8")


def bare(drive: Recording, dropped: tuple[str, ...], vehicle: Vehicle) -> Recording:
    """The drive without the channels `dropped`, completed as every command does."""
    return completed(replace(drive, channels={k: v for k, v in drive.channels.items() if k not in dropped}), vehicle)


def estimates(folder: Path, vehicle: Vehicle, labels: list[str]) -> Iterator[str]:
    """Rows of n with a good sensor set's noise, per drive and per set of absent channels."""
    yield "| without | " + " | ".join(DRIVES) + " |"
    yield "|---" * (len(DRIVES) + 1) + "|"
    logs = [add_noise(read_drive(folder / f"{name}.csv.gz"), "good", 1) for name in DRIVES]
    for name in labels:
        cells = []
        for log in logs:
            soil = SOILS[named_soil(log.name) or "clay"]
            drive = bare(log, WITHOUT.get(name, ()), vehicle)
            if name == SLOWER:
                drive = replace(drive, channels={k: v[::SLOW] for k, v in drive.channels.items()}, truth={})
            truth = named_n(log.name) or float("nan")
            found = estimate(mark_checked(drive), bicycle(vehicle, soil), truth + 0.2, start=2.0)
            n, std, verdict = found.n_front[-1], found.n_front_std[-1], found.verdict
            doubt = "" if verdict is None or verdict.usable else f" {verdict.word}"
            cells.append(f"{n:.3f} ± {std:.3f} ({100 * (n / truth - 1):+.0f} %){doubt}")
        yield f"| {name} | " + " | ".join(cells) + " |"


def effects(folder: Path, vehicle: Vehicle, names: list[str], labels: list[str]) -> Iterator[str]:
    """Rows of what refine says of drives with one effect added, per set of absent channels."""
    labels = [label for label in FOR_EFFECTS if label in labels]
    yield "| effect added | " + " | ".join(f"without {name}" for name in labels) + " |"
    yield "|---" * (len(labels) + 1) + "|"
    for name in names:
        soil = SOILS[EFFECT_SOILS[name]].with_(n=EFFECT_N[EFFECT_SOILS[name]])
        log = read_drive(folder / f"effect_{name}.csv.gz")
        cells = []
        for label in labels:
            found = refine([bare(log, WITHOUT[label], vehicle)], Declaration(vehicle, soil), workers=1)
            said = "; ".join(f"{e.name} {_lead(e.parameters)}" for e in found.effects) or found.verdict
            said += "".join(f", like {name}" for name in found.selection.unnamable)
            cells.append(f"{said}, n {found.n_after[0]:.2f}")
            print(f"  {name}, without {label}: {cells[-1]}", flush=True)
        yield f"| {name} | " + " | ".join(cells) + " |"


def _lead(parameters: dict[str, tuple[float, float, str]]) -> str:
    value, std, unit = next(iter(parameters.values()))
    return f"{value:.3g} ± {std:.1g} {unit}".strip()


if __name__ == "__main__":
    main()
