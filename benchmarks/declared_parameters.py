"""Where drives put the declared effects' parameters: `python benchmarks/declared_parameters.py ../shared/data/chrono_vehicle`.

Sensor channels of the multi-sine and step drives, by soil: the parameters of load_transfer and multipass, the vehicle's pull
(as a constant yaw moment), and with them those of the front wheels' lean, each fitted together with every drive's n; for
several yaw inertias, which are no parameter of the model: the cost says which it is. `paper_*` drives are not in it. Last, and
apart from it, what the simulator's own wheel loads (`true_fz_*`, a weighing of the wheels that no sensor of the vehicle gives)
say of transfer_height.

`python benchmarks/declared_parameters.py plant` does the same for vehicles/plant.toml, on the clean drives that the blind
test draws for the seeds 11 to 14, once without wheel_lean, then with the shares of aligning_moment and pressure_offset in the
last fit; the yaw inertia of the plant's bodies together is 1795 kg m^2, and its front suspension's hardpoints lean the wheels by
-0.14 of the steering angle and 0.02 rad per m/s^2 (tests/test_effects_lean.py).
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from mpc_demo.blind_cases import draw_cases, drive_case
from recording.drive import Recording
from recording.read import read_drive
from refinement.fit import Fit, Free, fit
from refinement.trace import Bench, everything, free_n, make_bench
from symbolic.declaration import Declaration
from symbolic.soil import load_soil
from symbolic.vehicle import Vehicle, load_vehicle

VEHICLES = Path(__file__).resolve().parents[1] / "vehicles"
DRIVES = {
    "clay": ("multi_clay_n0.50", "multi_clay_n0.65", "steps_clay_n0.50"),
    "sandy_loam": ("multi_sandyloam_n0.55", "multi_sandyloam_n0.70", "steps_sandyloam_n0.80"),
}
FREE = {
    "kappa": Free("kappa", ("kappa",), 0.2, 0.0, 1.5),
    "roll_sweep": Free("roll_sweep", ("roll_sweep",), 0.3, -2.0, 2.0),
    "transfer_height": Free("transfer_height", ("transfer_height",), 0.3, 0.0, 2.0),
    "shaft_share": Free("shaft_share", ("shaft_share",), 0.1, -1.0, 1.0),
    "pull": Free("pull", ("yaw_moment",), 20.0, -5000.0, 5000.0),
}
LEAN = {
    "lean_steer": Free("lean_steer", ("lean_steer",), 0.05, -0.5, 0.5),
    "lean_roll": Free("lean_roll", ("lean_roll",), 0.5, -2.0, 2.0),
}
SOIL_MOMENTS = {name: Free(name, (name,), 0.3, 0.0, 2.0) for name in ("aligning_f", "aligning_r", "pressure_share")}
INERTIAS = {"plant": (1690.0, 1740.0, 1795.0, 1840.0), "reference": (1790.0, 1820.0, 1850.0, 1880.0)}
"""kg m^2."""
PLANT_SEEDS = (11, 12, 13, 14)
START_UP = 2.0


def from_sensors(recordings: list[Recording], told: Declaration, sets: list[tuple[Free, ...]], inertias) -> None:
    """Print the fits of each set of parameters for each yaw inertia, all weighed alike."""
    weights = None
    for inertia in inertias:
        straight = replace(told, vehicle=told.vehicle.with_(yaw_inertia=inertia, pull=0.0))
        aligning = told.vehicle.effects.get("aligning_moment", {"aligning_f": 0.0, "aligning_r": 0.0})
        pull = {"yaw_moment": told.vehicle.pull}
        declared = straight.with_effects({"aligning_moment": aligning, "yaw_moment": pull})
        bench = make_bench(recordings, declared, START_UP, names=())
        weights = bench.weights if weights is None else weights
        for known in sets:
            found = fitted(replace(bench, weights=weights), known)
            print(
                f"{told.soil.name:10s} yaw inertia {inertia:.0f} kg m^2: cost {found.cost:.4f}; {told_of(found)}",
                flush=True,
            )


def fitted(bench: Bench, known: tuple[Free, ...]) -> Fit:
    """The known parameters and every drive's n, fitted to all of the drives."""
    free = [*known, *free_n(bench)]
    start = np.array([bench.absent[f.drive or 0, bench.model.p.index(f.sets[0])] for f in free])
    bench = everything(bench)
    return fit(bench.shootings, bench.fitted, bench.weights, free, start, bench.absent)


def told_of(found: Fit) -> str:
    """Values and standard errors in a line."""
    return ", ".join(f"{name} {value:.4f} ± {std:.4f}" for name, (value, std) in found.named().items())


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
        effects = (*FREE.values(), *LEAN.values())
        sets = [tuple(FREE.values()), effects, (*effects, *SOIL_MOMENTS.values())]
        upright = vehicle.with_(effects={key: told for key, told in vehicle.effects.items() if key != "wheel_lean"})
        print("without wheel_lean:")
        from_sensors(recordings, Declaration(upright, load_soil(soil)), sets[:1], INERTIAS["plant"])
        print("with it:")
        from_sensors(recordings, Declaration(vehicle, load_soil(soil)), sets, INERTIAS["plant"])


def of_the_reference(folder: Path) -> None:
    """The fits on the reference drives, and the weighing."""
    vehicle = load_vehicle(VEHICLES / "reference.toml")
    for soil, names in DRIVES.items():
        recordings = [read_drive(folder / f"{name}.csv.gz") for name in names]
        effects = (*FREE.values(), *LEAN.values())
        sets = [tuple(FREE.values()), effects, (*effects, *SOIL_MOMENTS.values())]
        from_sensors(recordings, Declaration(vehicle, load_soil(soil)), sets, INERTIAS["reference"])
        for recording in recordings:
            print(
                f"{recording.name}: transfer_height {from_wheel_loads(recording, vehicle):.2f} m by the wheels' loads"
            )


def main() -> None:
    """Print what each source says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", help="folder of the reference drives, or the word plant")
    told = parser.parse_args().drives
    of_the_plant() if told == "plant" else of_the_reference(Path(told))


if __name__ == "__main__":
    main()
