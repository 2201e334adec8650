"""Where the pressure acts, by the true wheel loads: `python -m benchmarks.pressure_share DRIVE_FOLDER [--vehicle reference]`.

The share of the force law's centre of pressure with which the model's mean rear axle load on a nominal drive is that of the
simulator (`true_fz_*`, which nothing that estimates reads), at the true n of the drive's name and along recorded states. It says
how far `pressure_share` may lie from 1, whatever the logs would rather have it at. Beside it by how much (%) the rear axle bears
more in the model, with the share that the vehicle's file has.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.judges.true_soil import drive_name, true_soil
from softsoil.codegen.predictor import Predictor
from softsoil.estimator.horizons import START_UP
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_n
from softsoil.recording.read import read_drive
from softsoil.recording.states import measured_states
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

EFFECT = "pressure_offset"
SHARES = (0.5, 1.5)
"""At which the model's load is evaluated; it is nearly linear in the share."""


def main() -> None:
    """Print the share of every nominal drive, their mean and scatter."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="drives of the reference simulator")
    parser.add_argument("--vehicle", default="reference", help="vehicle, built in or a file, with the effect pressure_offset")
    asked = parser.parse_args()
    vehicle = load_vehicle(asked.vehicle)
    if EFFECT not in vehicle.effects:
        parser.error(f"--vehicle: expected one that declares {EFFECT}, found {asked.vehicle} without it")
    found = []
    for log in sorted(asked.folder.glob("*.csv.gz")):
        name = drive_name(log)
        if named_n(name) is None:  # of a drive with an effect, or a change of soil
            continue
        share, heavier = by_loads(bicycle(vehicle, true_soil(name)), read_drive(log))
        found.append((share, heavier))
        print(f"{name:30s} {share:.2f}, rear axle {100 * heavier:+.1f} %", flush=True)
    if not found:
        parser.error(f"{asked.folder}: expected drives whose names hold soil and n; found none")
    shares, heavier = np.array(found).T
    print(
        f"{len(shares)} drives: {shares.mean():.2f} ± {shares.std():.2f}, {shares.min():.2f} to {shares.max():.2f}; "
        f"rear axle {100 * heavier.mean():+.1f} %"
    )


def by_loads(model: Model, drive: Recording) -> tuple[float, float]:
    """Share at which the model's mean load of the rear axle, as a share of both axles', is the true one; and by how much, as a
    share, that load is larger in the model with its own parameter."""
    keep = drive.t > drive.t[0] + START_UP
    true = {corner: float(drive.truth[f"true_fz_{corner}"][keep].mean()) for corner in ("fl", "fr", "rl", "rr")}
    states, (inputs, _) = measured_states(drive), measured_inputs(drive, model.external)
    predictor, loads = Predictor(model, drive.dt), model.probe("load_f", "load_r").map(len(states))
    rear = []
    for share in SHARES:
        p = model.p.nominal.copy()
        p[model.p.index("pressure_share")] = share
        _, full = predictor.track_memory(states, inputs, p)
        front_load, rear_load = loads(states.T, full.T, p).full()[:, keep].mean(axis=1)
        rear.append(rear_load / (front_load + rear_load))
    wanted = (true["rl"] + true["rr"]) / sum(true.values())
    slope = (rear[1] - rear[0]) / (SHARES[1] - SHARES[0])
    right = SHARES[0] + (wanted - rear[0]) / slope
    own = float(model.p.nominal[model.p.index("pressure_share")])
    return float(right), float(slope * (own - right) / wanted)


if __name__ == "__main__":
    main()
