"""Whose lateral velocity a log holds, by how it turns: `python -m benchmarks.velocity_place [../shared/data]`.

Drives of both vehicles of the reference simulator and of vehicles of the plant drawn by seed, with the noise "good" and without
accelerometers: as they are, v of the centre of gravity, and with the v of the rear axle in its place, as odometry of base_link
has it. Printed: the estimate over l_r and how many are doubted (`softsoil.checking.place`). The limit there was set on
these drives.
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
from softsoil.checking.place import place_checks
from softsoil.recording.drive import Recording
from softsoil.recording.evidence import Motion
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.vehicle import load_vehicle

SEEDS, ROBOT_SEEDS = (400, 401, 402, 500, 501, 502, 510, 511, 512, 513), (611, 612, 613, 614)
KINDS = (("multi", 10), ("lock", 11), ("steps", 13))


def drives(data: Path) -> Iterator[tuple[Recording, float]]:
    """Each drive and the l_r (m) of its vehicle."""
    for folder, l_r in (("chrono_vehicle", load_vehicle("reference").l_r), ("chrono_suv", SECOND["l_r"])):
        for path in sorted((data / folder).glob("*.csv.gz")):
            yield read_drive(path), l_r
    for seed in (*SEEDS, *ROBOT_SEEDS):
        case = case_of(seed, ROBOTS) if seed in ROBOT_SEEDS else case_of(seed)
        for kind, number in KINDS:
            yield log_of(case, kind, number).drive, case.drawn.measured["l_r"]


def main() -> None:
    """Print both counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, nargs="?", default=Path("../shared/data"))
    ahead: dict[str, list[float]] = {"centre of gravity": [], "rear axle": []}
    doubted, count = dict.fromkeys(ahead, 0), 0
    for clean, l_r in drives(parser.parse_args().data):
        drive, count = add_noise(clean, "good", 3), count + 1
        bare = {name: values for name, values in drive.channels.items() if not name.startswith("a_")}
        for place, behind in zip(ahead, (0.0, l_r), strict=True):
            log = replace(drive, channels={**bare, "v": drive["v"] - behind * drive["omega_z"]})
            for check in place_checks(Motion.of(log), SimpleNamespace(l_r=l_r)):
                ahead[place].append(float(check.found.split()[3]) / l_r)
                doubted[place] += not check.passed
    for place, values in ahead.items():
        low, middle, high = np.percentile(values, [0, 50, 100])
        print(
            f"v of the {place}: {low:+.2f} to {high:+.2f} of l_r ahead of the rear axle, {middle:+.2f} in the median; doubted "
            f"{doubted[place]} of {len(values)} ({count} drives)"
        )


if __name__ == "__main__":
    main()
