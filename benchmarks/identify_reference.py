"""`softsoil identify` judged on the reference vehicle of the shared drives, from what an owner knows of it.

Run: python -m benchmarks.identify_reference ../shared/data/chrono_vehicle [--declared] [--effects] [--vehicle FILE]
Known: mass, axle loads, design track, wheels and height of the centre of gravity (README of the drives, the given numbers of
vehicles/paper.toml) and `[simulator]`; no effect and no number that logs have identified. Fitted: of each kind that excites (full
lock and multi-sine) and each soil class with both, the drive that comes first by name. Everything else is judged, sand and the
step drives among it; how: `benchmarks/judges/identified.py`.

With --declared, the numbers of vehicles/reference.toml that logs can see, in the structure that the file declares: windows with
free initial states, weighted as the moving horizon weights them, on one multi-sine and one full-lock drive of clay and of sandy
loam. Numbers of the hardpoints count with the error of measuring them, yaw inertia, kappa and the pull with their priors, and the
radius as a tape says it. The file's numbers are that fit; its standard deviations are of an earlier form of the law in ruts,
and wider: with the printed ones of that time, `refine` named a load beside the bank of effect_bank.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.judges.identified import CONTACT_SEARCH, Case, add_options, run
from benchmarks.judges.true_inertia import START_UP
from benchmarks.judges.true_soil import nominal_logs
from benchmarks.refine_drives import EFFECTS
from softsoil.codegen.predictor import substeps_for
from softsoil.estimator.moving_horizon import LEAST_NOISE, HorizonRules
from softsoil.files.package_data import REFERENCE_VEHICLE
from softsoil.identification.errors import errors_of
from softsoil.identification.rules import RULES
from softsoil.recording.log_names import named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.recording.states import sensor_std
from softsoil.refinement.known_vehicle import Known, load_known
from softsoil.refinement.vehicle_numbers import NUMBERS, by_name, expected, free_layout
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import SOIL_SIGNALS, load_soil
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive
from softsoil.windows.window_fit import ITERATIONS, WindowFit, fit_windows

KNOWN = Known(
    "reference",
    {
        "mass": 1378.33, "l_f": 1.546, "l_r": 1.175, "track": 1.232, "radius": 0.330229, "width": 0.2121, "h_cg": 0.63,
        "max_steer": 0.47, "max_steer_rate": 1.0,
    },
    file="vehicles/paper.toml",
    simulator=load_vehicle("reference").simulator,
    search=CONTACT_SEARCH,
)  # fmt: skip

FITTED = ("multi_clay_n0.50", "multi_sandyloam_n0.55", "paper_clay_n0.50", "paper_sandyloam_n0.70")
HELD = "multi_clay_n0.65"
DECLARED_FITTED = ("multi_clay_n0.50", "multi_sandyloam_n0.70", "paper_clay_n0.70", "paper_sandyloam_n0.90")
SEEN = (
    "yaw_inertia", "radius", "scrub", "toe", "toe_rear", "ackermann", "yaw_moment", "kappa", "transfer_height", "roll_sweep",
    "pressure_share",
)  # fmt: skip
"""Numbers of the reference file that such drives see; the tracks and the roll of the body need circles (as identify asks for),
and how the front wheels lean with steering is what the hardpoints say: motion alone cannot separate it from yaw inertia."""
UNKNOWN = ("yaw_inertia", "kappa", "yaw_moment")
"""Those that nobody measures."""


def main() -> None:
    """Identify, judge and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder of the reference drives")
    add_options(parser, "runs/identify_reference.toml")
    parser.add_argument("--declared", action="store_true", help="fit the numbers of the reference file in its own structure")
    asked = parser.parse_args()
    if asked.declared:
        print_declared(asked.folder)
        return
    case = Case(
        known=KNOWN,
        fitted=FITTED,
        held=HELD,
        nominal=tuple(nominal_logs(asked.folder)),
        tracks=(1.232, 1.232),
        effects=EFFECTS,
    )
    run(case, asked)


def print_declared(folder: Path) -> None:
    """Print the numbers of the reference file's structure that its drives see, with their standard deviations."""
    found = declared_fit(folder)
    std = errors_of(found).std
    print(f"cost {found.cost:.4f} on {', '.join(DECLARED_FITTED)}")
    for name, (value, _) in found.named().items():
        print(f"  {name:18s} {value:10.4f} ± {RULES.model_error * std[name]:.4f}")
    print("[uncertainty]: with all other numbers as they are")
    for name, alone in declared_uncertainty(folder, found).items():
        print(f"{name} = {alone:.4g}")


def declared_uncertainty(folder: Path, found: WindowFit) -> dict[str, float]:
    """Standard deviation of each number that identify frees, with all others as they are, as identify writes it: every number
    free at the values `found` of the seen ones.

    folder: of the reference drives.
    """
    vehicle = load_vehicle("reference")
    table = {k: v for values in vehicle.effects.values() for k, v in values.items()}
    names = [n.name for n in NUMBERS if n.free and n.name not in vehicle.simulator and (not n.effect or n.name in table)]
    every = declared_fit(folder, names, {name: value for name, (value, _) in found.named().items()})
    errors = errors_of(every)
    std = {f.name: min(RULES.model_error * errors.std[f.name], f.known[1]) for f in every.free if f.known is not None}
    return {name: std[name] * float(share) for name, share in zip(errors.names, errors.alone, strict=True) if name in std}


def declared_fit(folder: Path, names: Sequence[str] = SEEN, at: Mapping[str, float] | None = None) -> WindowFit:
    """Numbers of the reference file's structure, and each drive's n, fitted jointly to windows of the drives.

    folder: of the reference drives; names: of the numbers; at: values by name at which derivatives are taken in the place of a
    fit.
    """
    vehicle, rules, n = load_vehicle("reference"), HorizonRules(), SOIL_SIGNALS["n"]
    known = load_known(REFERENCE_VEHICLE).without(*UNKNOWN).with_numbers(radius=KNOWN["radius"])
    before: Mapping[str, tuple[float, float]] = expected(known)
    windows, p = [], []
    compiled = None
    for i, name in enumerate(DECLARED_FITTED):
        drive = add_noise(read_drive(folder / f"{name}.csv.gz"), "good", 10 * i)
        model = bicycle(vehicle, load_soil(str(named_soil(name))), "turn_slip", None, free_layout(known))
        ready = shooting_drive(drive, model, START_UP)
        compiled = compiled or WindowModel(model, ready.dt, substeps_for(ready.dt))
        sigma = np.hypot(sensor_std(drive, LEAST_NOISE), rules.model_error)
        windows.append(FreeWindows(compiled, ready, rules.length, sigma, rules.fastest))
        p.append(model.p.nominal)
    numbers = by_name()
    free = [
        Free(name, (name,), before[name][1] / 2, numbers[name].lower, numbers[name].upper, known=before[name]) for name in names
    ]
    free += [Free(f"n_{i}", ("n_f", "n_r"), 0.1, n.lower, n.upper, drive=i) for i in range(len(windows))]
    index = model.p.index
    given = {f.name: before[f.name][0] if f.drive is None else float(p[f.drives[0]][index("n_f")]) for f in free}
    start = np.array([(at or {}).get(name, value) for name, value in given.items()])
    rows = np.array(p)
    for name, value in (at or {}).items():
        if name in SEEN:
            rows[:, index(name)] = value
    return fit_windows(windows, free, start, rows, iterations=ITERATIONS if at is None else 0)


if __name__ == "__main__":
    main()
