"""How often a verdict is right: `python -m benchmarks.verdicts ../shared/data/chrono_vehicle`.

Nominal drives with sensor noise, each with the right declaration and with a wrong one (yaw inertia, soil class), with a
channel's sign flipped, and cut down to its first seconds. A verdict is right where "identified" is said of an n within 10 % of
the truth, and another word of an n that is not. Nothing is fitted here; the truth is in the drives' names.
"""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.judges.true_soil import drive_name, nominal_logs, true_soil
from softsoil.estimator.estimate import METHODS, estimate
from softsoil.files.package_data import VEHICLES
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import SOILS, Soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

RIGHT = 0.10
"""Share of the true n within which an estimate is right."""
GUESSES = (0.2, -0.15)
MIXED_UP = {"clay": "sandy_loam", "sandy_loam": "clay", "sand": "clay"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--vehicle", type=Path, default=VEHICLES / "reference.toml")
    parser.add_argument("--method", default="ukf", choices=METHODS)
    parser.add_argument("--noise", default="good")
    parser.add_argument("--seeds", type=int, default=1)
    options = parser.parse_args()
    counts: dict[str, Counter[str]] = {}
    for log in nominal_logs(options.folder):
        soil, clean = true_soil(drive_name(log)), read_drive(log)
        for seed in range(options.seeds):
            for name, drive, vehicle, declared in cases(clean, load_vehicle(options.vehicle), soil):
                noisy = add_noise(drive, options.noise, seed)
                n0 = float(np.clip(soil.n + GUESSES[seed % 2], 0.25, 1.5))
                try:
                    found = estimate(noisy, bicycle(vehicle, declared), n0, method=options.method)
                except ValueError as error:  # channels that contradict each other
                    counts.setdefault(name, Counter())["refused, wrong"] += 1
                    print(f"{drive_name(log):24s} {name:22s} refused: {error}", flush=True)
                    continue
                right = abs(found.n_front[-1] / soil.n - 1) <= RIGHT
                word = "unjudged" if found.verdict is None else found.verdict.word
                counts.setdefault(name, Counter())[f"{word}, {'right' if right else 'wrong'}"] += 1
                print(f"{drive_name(log):24s} {name:22s} n {found.n_front[-1]:.3f} (true {soil.n:.2f}) {word}", flush=True)
    total: Counter[str] = sum(counts.values(), Counter())
    for name, counter in {**counts, "all": total}.items():
        print(f"{name:22s} " + "; ".join(f"{key} {value}" for key, value in sorted(counter.items())))
    good = sum(value for key, value in total.items() if key.endswith("right"))
    bad = sum(value for key, value in total.items() if key.endswith("wrong"))
    said_good, said_bad = total["identified, right"], total["identified, wrong"]
    print(f'"identified" said of {said_good} of {good} estimates within 10 %, and of {said_bad} of {bad} that are not')


def cases(clean: Recording, vehicle: Vehicle, soil: Soil) -> Iterator[tuple[str, Recording, Vehicle, Soil]]:
    """Name of the case, drive, and the vehicle and soil that are declared for it."""
    guess = soil.with_(n=SOILS[soil.name].n)
    yield "nominal", clean, vehicle, guess
    for factor in (1.4, 0.65):
        yield f"yaw inertia x {factor}", clean, vehicle.with_(yaw_inertia=factor * vehicle.yaw_inertia), guess
    yield "wrong soil class", clean, vehicle, SOILS[MIXED_UP[soil.name]]
    for channel in ("steer", "v"):
        yield f"sign of {channel} flipped", clean.with_channels(**{channel: -clean[channel]}), vehicle, guess
    yield "first 5 s", clean.between(clean.t[0], clean.t[0] + 7.0), vehicle, guess


if __name__ == "__main__":
    main()
