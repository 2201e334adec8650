"""n on drives of the own bicycle with Table-5 noise, 20 seeds and two soils: `python -m benchmarks.own_bicycle`."""

from pathlib import Path

import numpy as np

from softsoil.estimator.terrain import estimate_terrain
from softsoil.estimator.tuning import EXACT_MODEL
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.noise import add_noise
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.soil import CLAY, SANDY_LOAM
from softsoil.symbolic.vehicle import load_vehicle

SEEDS = 20
GUESS_OFF = 0.2


def main() -> None:
    vehicle = load_vehicle(Path(__file__).resolve().parents[1] / "vehicles" / "reference.toml")
    for soil in (CLAY, SANDY_LOAM):
        model = nominal_bicycle(vehicle, soil)
        drive = synthetic_drive(model, vehicle.radius)
        found = [
            estimate_terrain(add_noise(drive, "table5", s), model, soil.n + GUESS_OFF, tuning=EXACT_MODEL)
            for s in range(SEEDS)
        ]
        for axle in ("n_front", "n_rear"):
            errors = np.array([100 * abs(getattr(f, axle)[-1] / soil.n - 1) for f in found])
            print(
                f"{soil.name} {axle}: error median {np.median(errors):.2f} %, worst {errors.max():.2f} % of {SEEDS} seeds"
            )
        inside = np.array([100 * f.nis_inside_95 for f in found])
        print(f"{soil.name} NIS inside its 95 % band: {inside.min():.1f} to {inside.max():.1f} % of the time")


if __name__ == "__main__":
    main()
