"""What `estimate` says of vehicles that nobody identified: files of what a scale and a tape give, without a word of errors.

    python -m benchmarks.hand_written [--data ../shared/data] [--again]

The reference vehicle and the second one, as `declared_vehicle` has their known numbers: yaw inertia as expected of any vehicle,
no effects; with --again also with the yaw inertia that the reference file has. On their drives without undeclared effects, with
Table-5 noise: n by windows from the soil class's own, its verdict, how far it is off and in how many of its stated standard
deviations. Nothing is fitted; the true n judges. `estimator.tuning.UNSTATED_ERROR` rests on this.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.identify_reference import KNOWN as REFERENCE
from benchmarks.identify_suv import KNOWN as SUV
from benchmarks.judges.true_soil import drive_name, nominal_logs
from softsoil.estimator.estimate import estimate
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.vehicle_numbers import declared_vehicle
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import load_soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

RIGHT = 0.1
"""Share of n beyond which an estimate must not be called identified."""


def main() -> None:
    """Print a line per drive and the sums."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the shared data")
    parser.add_argument("--again", action="store_true", help="once more with the reference vehicle's true yaw inertia")
    asked = parser.parse_args()
    suv = [path for path in sorted((asked.data / "chrono_suv").glob("suv_*.csv.gz")) if named_n(drive_name(path)) is not None]
    reference = nominal_logs(asked.data / "chrono_vehicle")
    cases = [(declared_vehicle(REFERENCE), reference), (declared_vehicle(SUV), suv)]
    if asked.again:
        known = declared_vehicle(REFERENCE)
        cases.append((known.with_(yaw_inertia=load_vehicle("reference").yaw_inertia), reference))
    found = [judged(vehicle, path, i) for vehicle, paths in cases for i, path in enumerate(paths)]
    trusted = np.array([one for one in found if np.isfinite(one[0])])
    print(f"{len(trusted)} of {len(found)} identified", end="")
    if len(trusted):
        off, sigmas = np.abs(trusted).T
        wrong, rms, stated = int((off > RIGHT).sum()), np.sqrt(np.mean(off**2)), np.sqrt(np.mean(sigmas**2))
        print(f": {wrong} more than {100 * RIGHT:.0f} % off; rms {100 * rms:.1f} %, {stated:.1f} standard deviations", end="")
    print()


def judged(vehicle: Vehicle, path: Path, seed: int) -> tuple[float, float]:
    """Error of n on a drive, as a share and in standard deviations, of the axle where it is larger; NaN where it is not called
    identified."""
    name = drive_name(path)
    n, soil = named_n(name), named_soil(name)
    assert n is not None and soil is not None
    drive = add_noise(read_drive(path), "table5", seed)
    try:
        result = estimate(drive, bicycle(vehicle, load_soil(soil)), method="horizon")
    except ValueError as error:
        print(f"{vehicle.name} {name}: refused: {str(error)[:90]}", flush=True)
        return np.nan, np.nan
    assert result.verdict is not None
    axles = ((result.n_front, result.n_front_std), (result.n_rear, result.n_rear_std))
    off, std = max(((end[-1] / n - 1.0, std[-1] / n) for end, std in axles), key=lambda end: abs(end[0]))
    print(f"{vehicle.name} {name}: {100 * off:+.1f} ± {100 * std:.1f} % {result.verdict.word}", flush=True)
    return (off, off / std) if result.verdict.usable else (np.nan, np.nan)


if __name__ == "__main__":
    main()
