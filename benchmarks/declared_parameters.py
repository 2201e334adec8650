"""Where drives put the declared numbers: `python -m benchmarks.declared_parameters ../shared/data/chrono_vehicle`.

Sensor channels of the multi-sine and step drives; `paper_*` drives are not in it. First how far ahead of the centre of gravity
the front axle is, by the motion of its own point. Then the four numbers that nothing else says: the cost over wheel radius and
yaw inertia, kappa and the vehicle's pull (a constant yaw moment) fitted with every drive's n, and where a paraboloid through
the costs has its least. Then, by soil and for several yaw inertias, where the drives put the parameters of load_transfer and
multipass, and with them those of the front wheels' lean. Last, and separately, what the simulator's own wheel loads
(`true_fz_*`, a weighing of the wheels that no sensor of the vehicle gives) say of transfer_height.

`python -m benchmarks.declared_parameters plant` does the same for vehicles/plant.toml, whose radius is known, on the clean
drives that the blind test draws for the seeds 11 to 14, once without wheel_lean, then with the shares of aligning_moment and
pressure_offset in the last fit; the yaw inertia of the plant's bodies together is 1795 kg m^2, and what its suspensions'
hardpoints do to the wheels stands in tests/symbolic/test_effects_lean.py.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from scipy.signal import savgol_filter

from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.blind_cases import draw_cases, drive_case
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive
from softsoil.refinement.fit import Fit, Free, fit
from softsoil.refinement.trace import Bench, everything, make_bench
from softsoil.symbolic.soil import load_soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

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
INERTIAS = {"plant": (1690.0, 1740.0, 1795.0, 1840.0), "reference": (1800.0, 1840.0, 1880.0)}
"""kg m^2."""
RADII = (0.3302, 0.3309, 0.3316)
"""m, about the 0.330229 m that the reference's wheels are."""
PLANT_SEEDS = (11, 12, 13, 14)
START_UP = 2.0


def front_axle_ahead(recording: Recording) -> float:
    """l_f (m) by which the front axle's point moves sideways as v + l_f omega_z says; the roll's part follows d(omega_z)/dt."""
    log = recording.between(recording.t[0] + START_UP, np.inf)

    def rate(values: np.ndarray) -> np.ndarray:
        return savgol_filter(values, 9, 3, deriv=1, delta=log.dt)

    aside = rate(log["y"]) * np.cos(log["psi"]) - rate(log["x"]) * np.sin(log["psi"]) - log["v"]
    turning = np.column_stack([log["omega_z"], rate(log["omega_z"])])
    return float(np.linalg.lstsq(turning, aside, rcond=None)[0][0])


def least_of(points: np.ndarray, costs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the paraboloid through costs (N,) at points (N, 2) has its least, and how far from it the cost doubles (2,)."""
    middle, span = points.mean(axis=0), np.ptp(points, axis=0)
    a, b = ((points - middle) / span).T
    c = np.linalg.lstsq(np.column_stack([np.ones_like(a), a, b, a * a, a * b, b * b]), costs, rcond=None)[0]
    bowl = np.array([[2 * c[3], c[4]], [c[4], 2 * c[5]]])
    at = np.linalg.solve(bowl, -c[1:3])
    least = c[0] + 0.5 * c[1:3] @ at
    return middle + span * at, span * np.sqrt(2.0 * least * np.diag(np.linalg.inv(bowl)))


def radius_and_inertia(drives: dict[str, list[Recording]], vehicle: Vehicle) -> None:
    """Print the costs over radius and yaw inertia with kappa and the pull free, and their least."""
    declared = {soil: Declaration(vehicle, load_soil(soil)) for soil in drives}
    weights = {soil: make_bench(drives[soil], declared[soil], START_UP, names=()).weights for soil in drives}

    def tried_at(soil: str, radius: float, inertia: float) -> tuple[float, float, float]:
        told = replace(declared[soil], vehicle=vehicle.with_(radius=radius, yaw_inertia=inertia))
        bench = replace(make_bench(drives[soil], told, START_UP, names=()), weights=weights[soil])
        found = fitted(bench, (FREE["pull"], FREE["kappa"]))
        return found.cost, found.named()["pull"][0], found.named()["kappa"][0]

    grid = [(radius, inertia) for radius in RADII for inertia in INERTIAS["reference"]]
    tasks = [delayed(tried_at)(soil, *point) for point in grid for soil in drives]
    table = np.array(Parallel(n_jobs=-1)(tasks)).reshape(len(grid), len(drives), 3)
    for point, row in zip(grid, table, strict=True):
        told = ", ".join(
            f"{soil} {cost:.4f} (pull {pull:.0f} N m, kappa {kappa:.3f})"
            for soil, (cost, pull, kappa) in zip(drives, row, strict=True)
        )
        print(f"radius {point[0]:.4f} m, yaw inertia {point[1]:.0f} kg m^2: cost {told}", flush=True)
    at, doubles = least_of(np.array(grid), table[:, :, 0].sum(axis=1))
    pull, kappa = (plane_at(np.array(grid), table[:, :, k].mean(axis=1), at) for k in (1, 2))
    print(
        f"least cost: radius {at[0]:.5f} m (doubles within {doubles[0]:.5f}), yaw inertia {at[1]:.0f} kg m^2 "
        f"({doubles[1]:.0f}), pull {pull:.0f} N m, kappa {kappa:.3f}"
    )


def plane_at(points: np.ndarray, values: np.ndarray, at: np.ndarray) -> float:
    """Value at a place (2,) of the plane through values (N,) at points (N, 2)."""
    plane = np.column_stack([np.ones(len(points)), points])
    return float(np.r_[1.0, at] @ np.linalg.lstsq(plane, values, rcond=None)[0])


def from_sensors(recordings: list[Recording], told: Declaration, sets: list[tuple[Free, ...]], inertias) -> None:
    """Print the fits of each set of parameters for each yaw inertia, all weighed alike."""
    weights = None
    for inertia in inertias:
        straight = replace(told, vehicle=told.vehicle.with_(yaw_inertia=inertia))
        aligning = told.vehicle.effects.get("aligning_moment", {"aligning_f": 0.0, "aligning_r": 0.0})
        pull = told.vehicle.effects.get("yaw_moment", {"yaw_moment": 0.0})
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
    free = [*known, *bench.ground]
    start = bench.values(free)
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
    return float(slope * 0.5 * (vehicle.track + vehicle.rear_track) / vehicle.mass)


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
    drives = {soil: [read_drive(folder / f"{name}.csv.gz") for name in names] for soil, names in DRIVES.items()}
    for recording in (r for recordings in drives.values() for r in recordings):
        print(f"{recording.name}: l_f {front_axle_ahead(recording):.4f} m when driving")
    radius_and_inertia(drives, vehicle)
    for soil, recordings in drives.items():
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
