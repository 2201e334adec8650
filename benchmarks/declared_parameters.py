"""Where logs put the declared effects' parameters: `python benchmarks/declared_parameters.py ../shared/data/chrono_vehicle`.

Sensor channels of the multi-sine drives, two per soil: kappa alone, with roll_sweep, and with transfer_height too, each fitted
together with every drive's n to the first two thirds of the drives. Last, and apart from it, what the simulator's own wheel
loads (`true_fz_*`, a weighing of the wheels that no sensor of the vehicle gives) say of transfer_height.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from recording.drive import Recording
from recording.read import read_drive
from refinement.fit import Free, fit
from refinement.trace import free_n, make_bench
from symbolic.declaration import Declaration
from symbolic.soil import load_soil
from symbolic.vehicle import Vehicle, load_vehicle

VEHICLE = Path(__file__).resolve().parents[1] / "vehicles" / "reference.toml"
DRIVES = {
    "clay": ("multi_clay_n0.50", "multi_clay_n0.65"),
    "sandy_loam": ("multi_sandyloam_n0.55", "multi_sandyloam_n0.70"),
}
FREE = {
    "kappa": Free("kappa", ("kappa",), 0.2, 0.0, 1.5),
    "roll_sweep": Free("roll_sweep", ("roll_sweep",), 0.003, -0.03, 0.03),
    "transfer_height": Free("transfer_height", ("transfer_height",), 0.3, 0.0, 2.0),
}
START_UP = 2.0


def from_sensors(recordings: list[Recording], declaration: Declaration) -> None:
    """Print the three fits."""
    bench = make_bench(recordings, declaration, START_UP, names=())
    at = bench.model.p.index
    for count in range(1, len(FREE) + 1):
        free = [*list(FREE.values())[:count], *free_n(bench)]
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


def main() -> None:
    """Print what each source says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder, vehicle = parser.parse_args().folder, load_vehicle(VEHICLE)
    for soil, names in DRIVES.items():
        recordings = [read_drive(folder / f"{name}.csv.gz") for name in names]
        from_sensors(recordings, Declaration(vehicle, load_soil(soil)))
        for recording in recordings:
            print(f"{recording.name}: transfer_height {from_wheel_loads(recording, vehicle):.2f} m by the wheels' loads")


if __name__ == "__main__":
    main()
