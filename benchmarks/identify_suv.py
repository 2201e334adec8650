"""`softsoil identify` judged on the second vehicle of the shared drives, from what its README says that an owner knows.

Run: python -m benchmarks.identify_suv [--data ../shared/data] [--effects] [--vehicle FILE]
Fitted: one lock and one multi-sine drive with the noise named "good". Judged, on all other nominal drives: n by the filter with
Table-5 noise from two first guesses, n by windows, predictions over 2.5 s from clean states; the yaw inertia against what the
true wheel forces balance with (read here only, to judge); with --effects, what `refine` names on the drives with an effect.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.free_windows import FreeWindows, WindowModel
from softsoil.estimator.horizons import Replay
from softsoil.estimator.inputs import sensor_std
from softsoil.estimator.parameters import Free
from softsoil.estimator.shooting import shooting_drive
from softsoil.estimator.terrain import estimate_terrain
from softsoil.estimator.window_fit import fit_windows
from softsoil.mpc_demo.blind_test import score
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.identify import identify
from softsoil.refinement.identify_bench import FASTEST, MODEL_STD, N_NAMES, N_SCALE, NOISE_FLOOR
from softsoil.refinement.identify_bench import HORIZON as HORIZON_OF_FIT
from softsoil.refinement.identify_result import JUDGED_STATES, Identification
from softsoil.refinement.identify_toml import vehicle_toml
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.refine import refine
from softsoil.refinement.vehicle_numbers import declared_vehicle, vehicle_of
from softsoil.symbolic.soil import Soil, load_soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

KNOWN = Known(
    "suv",
    {
        "mass": 1943.0, "l_f": 1.466, "l_r": 1.805, "track": 1.83, "track_rear": 1.935, "radius": 0.405, "width": 0.235,
        "h_cg": 0.7,
    },
    file="data/chrono_suv/README.md",
    simulator=load_vehicle("reference").simulator,
)  # fmt: skip
FITTED = ("suv_lock_clay_n0.55", "suv_multi_sandyloam_n0.65")
HELD = "suv_multi_clay_n0.50"
GUESSES = (0.4, 0.9)
HORIZON = 2.5
EFFECTS = {
    "suv_effect_bank": ("bank", "sandy_loam", {"bank": 0.0698}),
    "suv_effect_steer_lag": ("steering_lag", "clay", {"steering_lag": 0.2}),
    "suv_effect_payload": ("payload", "clay", {"payload_mass": 350.0}),
    "suv_effect_yaw_moment": ("yaw_moment", "sandy_loam", {"yaw_moment": 1000.0}),
    "suv_effect_steer_offset": ("steering_offset", "clay", {"steering_offset": 0.0469}),
}
"""Drive -> effect, soil class, parameters (README of the drives; the offset as the road wheels have it, `_offset`)."""


def main() -> None:
    """Identify, judge and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the shared data")
    parser.add_argument("--effects", action="store_true", help="trace the drives with an effect, and the nominal ones, too")
    parser.add_argument("--vehicle", type=Path, help="judge this vehicle file in the place of a new identification")
    parser.add_argument("--out", type=Path, default=Path("runs/identify_suv.toml"), help="where the vehicle file is written")
    asked = parser.parse_args()
    folder = asked.data / "chrono_suv"
    nominal = sorted(path for path in folder.glob("suv_*.csv.gz") if named_n(_name(path)) is not None)
    if asked.vehicle is None:
        found = _identified(folder)
        asked.out.parent.mkdir(parents=True, exist_ok=True)
        asked.out.write_text(vehicle_toml(found), encoding="utf-8")
        vehicle = found.vehicle
    else:
        vehicle = load_vehicle(asked.vehicle)
    _inertia(vehicle, nominal)
    _judge(vehicle, [path for path in nominal if _name(path) not in FITTED])
    if asked.effects:
        _offset(folder)
        _trace(vehicle, sorted(folder.glob("suv_effect_*.csv.gz")) + [p for p in nominal if _name(p) not in FITTED])


def _identified(folder: Path) -> Identification:
    began = time.perf_counter()
    names = (*FITTED, HELD)
    drives = [add_noise(read_drive(folder / f"{name}.csv.gz"), "good", 10 * i) for i, name in enumerate(names)]
    found = identify(drives, [load_soil(str(named_soil(name))) for name in names], KNOWN)
    print(f"{found.verdict}: {found.reason} ({time.perf_counter() - began:.0f} s)")
    for name, number in found.numbers.items():
        print(
            f"  {name:22s} {number.value:10.4f} ± {number.std:.4f} {number.unit:10s} {number.state:17s} "
            f"n {number.n_percent_per_std:+.1f} %"
        )
    print("asks:", *found.asks, sep="\n  ")
    return found


def _inertia(vehicle: Vehicle, paths: list[Path]) -> None:
    """The yaw inertia that the true wheel forces balance with, least squares on d(omega_z)/dt, lock and multi-sine drives."""
    values = []
    for path in paths:
        if "steps" in path.name:
            continue
        drive = read_drive(path)
        moment = np.zeros(len(drive))
        for wheel in ("fl", "fr", "rl", "rr"):
            arm = KNOWN["l_f"] if wheel[0] == "f" else -KNOWN["l_r"]
            side = (0.5 if wheel[1] == "l" else -0.5) * (1.90 if wheel[0] == "f" else 1.935)
            moment += arm * drive.truth[f"true_fy_{wheel}"] - side * drive.truth[f"true_fx_{wheel}"]
        kernel = np.ones(9) / 9
        rate = np.convolve(np.gradient(drive["omega_z"], drive.dt), kernel, "same")
        rows = drive.t > 2.0
        columns = np.column_stack([rate, np.ones(len(rate))])[rows]
        values.append(np.linalg.lstsq(columns, np.convolve(moment, kernel, "same")[rows], rcond=None)[0][0])
    true = float(np.mean(values))
    off = 100 * (vehicle.yaw_inertia / true - 1)
    print(f"yaw inertia {vehicle.yaw_inertia:.0f}, the true forces balance with {true:.0f}: {off:+.1f} %")


def _offset(folder: Path) -> None:
    """The steering offset as the road wheels have it: mean of their true angles over `steer`, which its README rounds."""
    for name in ("suv_effect_steer_offset", HELD):
        drive = read_drive(folder / f"{name}.csv.gz")
        rows = drive.t > 2.0
        wheels = 0.5 * (drive.truth["true_delta_fl"] + drive.truth["true_delta_fr"])
        print(f"{name}: road wheels beyond steer {float(np.mean((wheels - drive['steer'])[rows])):+.4f} rad in the mean")


def _judge(vehicle: Vehicle, paths: list[Path]) -> None:
    errors: dict[str, list[float]] = {"filter": [], "windows": []}
    logs: list[np.ndarray] = []
    for i, path in enumerate(paths):
        name, soil = _name(path), load_soil(str(named_soil(path.name)))
        clean, n_true = read_drive(path), named_n(_name(path))
        noisy = add_noise(clean, "table5", 100 + i)
        model = Declaration(vehicle, soil).build()
        line = []
        for guess in GUESSES:
            n = float(estimate_terrain(noisy, model, guess, tied=True, start=2.0).n_front[-1])
            errors["filter"].append(n / n_true - 1)
            line.append(f"{100 * errors['filter'][-1]:+.1f}")
        mse = []
        for numbers in (declared_vehicle(KNOWN), _known_vehicle(), vehicle):
            n = _n_by_windows(numbers, noisy, soil)
            built = Declaration(numbers, soil.with_(n=n)).build()
            mse.append(Replay(clean, built).windows(built.p.nominal, HORIZON).mse)
        errors["windows"].append(n / n_true - 1)
        ratio = [float(np.exp(np.mean([np.log(one[s] / mse[2][s]) for s in JUDGED_STATES]))) for one in mse[:2]]
        logs.append(np.log(ratio))
        print(
            f"{name:28s} n {n_true:.2f}: filter {', '.join(line)} %, windows {100 * errors['windows'][-1]:+.1f} %; "
            f"mse at {HORIZON} s {ratio[0]:.1f} ({ratio[1]:.1f}) times smaller",
            flush=True,
        )
    for kind, values in errors.items():
        size = 100 * np.abs(values)
        print(f"n by {kind}, Table-5 noise: median {np.median(size):.1f} %, worst {size.max():.1f} %")
    plain, expected = np.exp(np.mean(logs, axis=0))
    print(
        f"mse at {HORIZON} s, geometric mean: {plain:.1f} times smaller than with the known file as it stands (no effects), "
        f"{expected:.1f} times than with everything else as expected of any vehicle"
    )


def _known_vehicle() -> Vehicle:
    """The vehicle as expected from what is known, before any log."""
    return vehicle_of(KNOWN, {"max_steer": 0.6})


def _n_by_windows(vehicle: Vehicle, drive: Recording, soil: Soil) -> float:
    """n of a drive by windows with free initial states."""
    model = Declaration(vehicle, soil).build()
    ready = shooting_drive(drive, model, 2.0)
    sigma = np.hypot(MODEL_STD, sensor_std(drive, NOISE_FLOOR))
    windows = FreeWindows(WindowModel(model, ready.dt), ready, HORIZON_OF_FIT, sigma, FASTEST)
    free = [Free("n", N_NAMES, N_SCALE, 0.2, 1.6)]
    fits = []
    for guess in GUESSES:
        p = model.p.pack(n_f=guess, n_r=guess)
        fits.append(fit_windows([windows], free, np.array([guess]), p))
    return float(min(fits, key=lambda fit: fit.cost).value[0])


def _trace(vehicle: Vehicle, paths: list[Path]) -> None:
    right = 0
    for path in paths:
        name = _name(path)
        effect, soil, truth = EFFECTS.get(name, ("", str(named_soil(name)), {}))
        found = refine([read_drive(path)], Declaration(vehicle, load_soil(soil)), workers=1)
        good, why = score({"kind": "effect" if effect else "clean", "name": effect, "truth": truth}, found)
        right += good
        best = ", ".join(f"{c.name} {100 * c.gain:.0f} %" for c in found.ranking[:3])
        print(f"{name:28s} {'right' if good else 'WRONG'} {found.verdict} {why}; best {best}; {found.seconds:.0f} s", flush=True)
    print(f"{right} of {len(paths)} right")


def _name(path: Path) -> str:
    return path.name.removesuffix(".csv.gz")


if __name__ == "__main__":
    main()
