"""Whose lateral velocity a log holds, or position, by how it turns: `python -m benchmarks.velocity_place [../shared/data]`.

Drives of both vehicles of the reference simulator and of vehicles of the plant drawn by seed, with the noise "good" and without
accelerometers: as they are, v of the centre of gravity, and with the v of the rear axle in its place, as odometry of base_link
has it; and without v, with positions of the front axle, as they are, and of the centre of gravity. Printed: the estimate over l_r
and how many are doubted (`softsoil.checking.place`). The limits there were set on these drives.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from benchmarks.identify_suv import KNOWN as SECOND
from benchmarks.judges.plant_vehicles import ROBOTS, case_of, log_of
from softsoil.checking.place import place_checks, position_checks
from softsoil.recording.drive import Recording
from softsoil.recording.evidence import Motion
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.vehicle import load_vehicle

SEEDS, ROBOT_SEEDS = (400, 401, 402, 500, 501, 502, 510, 511, 512, 513), (611, 612, 613, 614)
POINTS = {"v": ("centre of gravity", "rear axle"), "positions": ("front axle", "centre of gravity")}
KINDS = (("multi", 10), ("lock", 11), ("steps", 13))


def drives(data: Path) -> Iterator[tuple[Recording, float, float]]:
    """Each drive and l_f, l_r (m) of its vehicle."""
    reference = load_vehicle("reference")
    for folder, places in (("chrono_vehicle", (reference.l_f, reference.l_r)), ("chrono_suv", (SECOND["l_f"], SECOND["l_r"]))):
        for path in sorted((data / folder).glob("*.csv.gz")):
            yield read_drive(path), *places
    for seed in (*SEEDS, *ROBOT_SEEDS):
        case = case_of(seed, ROBOTS) if seed in ROBOT_SEEDS else case_of(seed)
        for kind, number in KINDS:
            yield log_of(case, kind, number).drive, case.drawn.measured["l_f"], case.drawn.measured["l_r"]


def main() -> None:
    """Print both counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, nargs="?", default=Path("../shared/data"))
    places = [f"{of} of the {point}" for of, points in POINTS.items() for point in points]
    ahead: dict[str, list[float]] = {place: [] for place in places}
    doubted, count = dict.fromkeys(ahead, 0), 0
    for clean, l_f, l_r in drives(parser.parse_args().data):
        drive, count, vehicle = add_noise(clean, "good", 3), count + 1, SimpleNamespace(l_f=l_f, l_r=l_r)
        bare = {name: values for name, values in drive.channels.items() if not name.startswith("a_")}
        blind = {name: values for name, values in drive.channels.items() if name != "v"}
        forward = l_f * np.cos(drive["psi"]), l_f * np.sin(drive["psi"])
        variants = (
            bare, {**bare, "v": drive["v"] - l_r * drive["omega_z"]},
            blind, {**blind, "x": drive["x"] - forward[0], "y": drive["y"] - forward[1]},
        )  # fmt: skip
        for place, channels in zip(places, variants, strict=True):
            motion = Motion.of(replace(drive, channels=channels))
            found = place_checks(motion, vehicle) if place.startswith("v") else position_checks(motion, vehicle)
            for check in found:
                seen = float(check.found.split()[3]) - (0.0 if place.startswith("v") else l_f)
                ahead[place].append(seen / l_r)
                doubted[place] += not check.passed
    for place, values in ahead.items():
        low, middle, high = np.percentile(values, [0, 50, 100])
        print(
            f"{place}: {low:+.2f} to {high:+.2f} of l_r ahead of the rear axle (positions less l_f), {middle:+.2f} in the "
            f"median; doubted {doubted[place]} of {len(values)} ({count} drives)"
        )


if __name__ == "__main__":
    main()
