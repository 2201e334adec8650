"""Where drives put the declared effects' parameters: `python benchmarks/declared_parameters.py ../shared/data/chrono_vehicle`.

Sensor channels of the multi-sine drives, two per soil: kappa alone, with roll_sweep, and with transfer_height too, each fitted
together with every drive's n to the first two thirds of the drives. Last, and apart from it, what the simulator's own wheel
loads (`true_fz_*`, a weighing of the wheels that no sensor of the vehicle gives) say of transfer_height.

`python benchmarks/declared_parameters.py plant` does the same for vehicles/plant.toml, on the clean drives that the blind
test draws for the seeds 11 to 14: kappa, roll_sweep and transfer_height, and aligning_share with them in the last fit.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mpc_demo.blind_cases import draw_cases, drive_case
from recording.drive import Recording
from recording.read import read_drive
from refinement.fit import Free, fit
from refinement.trace import free_n, make_bench
from symbolic.declaration import Declaration
from symbolic.soil import load_soil
from symbolic.vehicle import Vehicle, load_vehicle

VEHICLES = Path(__file__).resolve().parents[1] / "vehicles"
DRIVES = {
    "clay": ("multi_clay_n0.50", "multi_clay_n0.65"),
    "sandy_loam": ("multi_sandyloam_n0.55", "multi_sandyloam_n0.70"),
}
FREE = {
    "kappa": Free("kappa", ("kappa",), 0.2, 0.0, 1.5),
    "roll_sweep": Free("roll_sweep", ("roll_sweep",), 0.003, -0.03, 0.03),
    "transfer_height": Free("transfer_height", ("transfer_height",), 0.3, 0.0, 2.0),
}
ALIGNING = Free("aligning_share", ("aligning_share",), 0.3, 0.0, 2.0)
PLANT_SEEDS = (11, 12, 13, 14)
START_UP = 2.0


def from_sensors(recordings: list[Recording], declaration: Declaration, known: tuple[Free, ...]) -> None:
    """Print the fits: of the first of the known parameters, of the first two, and so on."""
    bench = make_bench(recordings, declaration, START_UP, names=())
    at = bench.model.p.index
    for count in range(1, len(known) + 1):
        free = [*known[:count], *free_n(bench)]
        start = np.array([bench.absent[f.drive or 0, at(f.sets[0])] for f in free])
        found = fit(bench.shootings, bench.fitted, bench.weights, free, start, bench.absent).named()
        told = ", ".join(f"{name} {value:.4f} ± {std:.4f}" for name, (value, std) in found.items())
        print(f"{declaration.soil.name:10s} {told}", flush=True)


def from_wheel_loads(recording: Recording, vehicle: Vehicle) -> float:
    """transfer_height (m) with which M a_y h/T is the wheels' own difference of loads, both axles together."""
    load = {wheel: recording.truth[f"true_fz_{wheel}"] for wheel in ("fl", "fr", "rl", "rr")}
    moved = (load["fr"] + load["rr"] - load["fl"] - load["rl"]) / 2
    rows = recording.t > recording.t[0] + START_UP
    a_y = (recording["u"] * recording["omega_z"])[rows]
    slope = np.polyfit(a_y, moved[rows], 1)[0]
    return float(slope * vehicle.track / vehicle.mass)


def of_the_plant() -> None:
    """The fits on the plant's clean drives."""
    cases = [case for seed in PLANT_SEEDS for case in draw_cases(10, seed) if case["kind"] == "clean"]
    vehicle = load_vehicle(VEHICLES / "plant.toml")
    for soil in DRIVES:
        recordings = [drive_case(case) for case in cases if case["soil"] == soil]
        print(f"{soil:10s} true n " + ", ".join(f"{case['n']:.4f}" for case in cases if case["soil"] == soil))
        from_sensors(recordings, Declaration(vehicle, load_soil(soil)), (*FREE.values(), ALIGNING))


def of_the_reference(folder: Path) -> None:
    """The fits on the reference drives, and the weighing."""
    vehicle = load_vehicle(VEHICLES / "reference.toml")
    for soil, names in DRIVES.items():
        recordings = [read_drive(folder / f"{name}.csv.gz") for name in names]
        from_sensors(recordings, Declaration(vehicle, load_soil(soil)), tuple(FREE.values()))
        for recording in recordings:
            print(f"{recording.name}: transfer_height {from_wheel_loads(recording, vehicle):.2f} m by the wheels' loads")


def main() -> None:
    """Print what each source says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", help="folder of the reference drives, or the word plant")
    told = parser.parse_args().drives
    of_the_plant() if told == "plant" else of_the_reference(Path(told))


if __name__ == "__main__":
    main()
