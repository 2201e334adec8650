"""The declared effects against two constants in their place: `python -m benchmarks.constant_gain ../shared/data/chrono_vehicle`.

The shortcut that a rear axle in ruts invites: the paper's bicycle with its rear force times a constant, and a yaw moment
-c M a_y. Gain, c and n are fitted to the first two thirds of each nominal drive, as n alone is for the declared vehicle; both are
judged by the mean squared error 2.5 s ahead over the last third, which no fit has seen. Sensor channels only.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.judges.true_soil import drive_name, nominal_logs, true_soil
from softsoil.recording.read import read_drive
from softsoil.refinement.fit import Fit, Free, Weights, fit
from softsoil.refinement.rules import RULES
from softsoil.refinement.unknown_ground import N_NAMES
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.effect import Correction, Effect, add_effect
from softsoil.symbolic.model import Model, Quantities
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.soil import SOILS
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.shooting import Shooting, shooting_drive

VEHICLE = Path(__file__).resolve().parents[1] / "vehicles" / "reference.toml"
AHEAD = 2.5
JUDGED = {"v": 4, "omega_z": 5}


def constants() -> Effect:
    """Rear lateral force times a constant, and a yaw moment -c M a_y with a_y of the forces."""

    def balance(q: Quantities) -> Quantities:
        more = q["force_r"] * (q["rear_gain"] - 1.0)
        moment = -more * q["l_r"] - q["moment_arm"] * (q["force_f"] + q["force_r"] + more)
        return {"force_y": q["force_y"] + more, "moment_z": q["moment_z"] + moment}

    return Effect(
        name="constants",
        doc="a constant rear gain and a yaw moment proportional to the lateral acceleration",
        kind="load",
        reference="none: two numbers in the place of causes",
        parameters=Layout.of(
            Signal("rear_gain", "", "factor of the rear lateral force", 1.0, 0.3, 4.0),
            Signal("moment_arm", "m", "c of the moment -c M a_y", 0.0, -0.5, 1.0),
        ),
        typical={"rear_gain": 1.5, "moment_arm": 0.2},
        corrections={"balance": Correction(balance, reads=("force_f", "force_r", "l_r"), adds=("force_y", "moment_z"))},
    )


def judged(log: Path, model: Model, free: list[Free], starts: np.ndarray) -> tuple[np.ndarray, Fit]:
    """Mean squared error of v and omega_z (2,) AHEAD s ahead over the last third, and the fit to the first two thirds."""
    drive = shooting_drive(read_drive(log), model, 2.0)
    shooting = Shooting(model, drive, RULES.horizon)
    fitted = np.arange(round(len(shooting.rows) * RULES.fit_share))
    p = model.p.nominal[None]
    sigma = np.sqrt(np.nanmean(shooting.residual(p[0])[fitted].reshape(-1, 6) ** 2, axis=0))
    for _ in range(2):  # each model weights its channels by what it leaves of them
        found = fit([shooting], [fitted], Weights(sigma), free, starts, p)
        sigma = np.sqrt(np.nanmean(shooting.residual(found.p[0])[fitted].reshape(-1, 6) ** 2, axis=0))
    ahead = Shooting(model, drive, AHEAD)
    held = ahead.rows >= shooting.rows[len(fitted)]
    end = ahead.residual(found.p[0])[held][:, -1]
    return np.nanmean(end[:, list(JUDGED.values())] ** 2, axis=0), found


def main() -> None:
    """One line per drive, and the geometric mean."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    vehicle = load_vehicle(VEHICLE)
    n = Free("n", N_NAMES, 0.1, 0.2, 1.6)
    both = [Free("rear_gain", ("rear_gain",), 0.3, 0.3, 4.0), Free("moment_arm", ("moment_arm",), 0.1, -0.5, 1.0), n]
    ratios = []
    for log in nominal_logs(parser.parse_args().folder):
        soil = SOILS[true_soil(drive_name(log)).name]  # n is fitted from several guesses: the class's own is no truth
        guesses = soil.n + np.array([-0.25, -0.1, 0.05, 0.2])
        plain = add_effect(bicycle(vehicle, soil, effects={}), constants())
        shortcut, at = judged(log, plain, both, np.array([[g, 0.2, m] for g in (1.3, 2.0) for m in guesses]))
        declared, _ = judged(log, bicycle(vehicle, soil), [n], guesses[:, None])
        ratios.append(declared / shortcut)
        words = ", ".join(f"{k} {v:.2f}" for k, (v, _) in at.named().items())
        print(f"{log.name:30s} {words}; mse, declared over constants: "
              + ", ".join(f"{k} {r:.2f}" for k, r in zip(JUDGED, ratios[-1], strict=True)), flush=True)  # fmt: skip
    mean = np.exp(np.mean(np.log(ratios), axis=0))
    print("geometric mean: " + ", ".join(f"{k} {r:.2f}" for k, r in zip(JUDGED, mean, strict=True)))


if __name__ == "__main__":
    main()
