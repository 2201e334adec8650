"""Where the pressure acts, by the true wheel loads: `python -m benchmarks.pressure_share DRIVE_FOLDER [--vehicle reference]`.

The share of the force law's centre of pressure with which the model's mean rear axle load on a nominal drive is that of the
simulator (`true_fz_*`, which nothing that estimates reads), at the true n of the drive's name and along recorded states. It says
how far `pressure_share` may lie from 1, whatever the logs would rather have it at.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.judges.true_soil import drive_name
from softsoil.codegen.predictor import Predictor
from softsoil.estimator.horizons import START_UP
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.read import read_drive
from softsoil.recording.states import measured_states
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import load_soil
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

SHARES = (0.5, 1.5)
"""At which the model's load is evaluated; it is nearly linear in the share."""


def main() -> None:
    """Print the share of every nominal drive, their mean and scatter."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="drives of the reference simulator")
    parser.add_argument("--vehicle", default="reference", help="vehicle, built in or a file, with the effect pressure_offset")
    asked = parser.parse_args()
    vehicle, shares = load_vehicle(asked.vehicle), []
    for log in sorted(asked.folder.glob("*.csv.gz")):
        name = drive_name(log)
        n, soil = named_n(name), named_soil(name)
        if n is None or soil is None or "change" in name:
            continue
        shares.append(share_by_loads(bicycle(vehicle, load_soil(soil).with_(n=n)), read_drive(log)))
        print(f"{name:30s} {shares[-1]:.2f}", flush=True)
    if not shares:
        parser.error(f"{asked.folder}: expected drives whose names hold soil and n; found none")
    print(f"{len(shares)} drives: {np.mean(shares):.2f} ± {np.std(shares):.2f}, {min(shares):.2f} to {max(shares):.2f}")


def share_by_loads(model: Model, drive: Recording) -> float:
    """Share at which the model's mean load of the rear axle, as a share of both, is the true one."""
    keep = drive.t > drive.t[0] + START_UP
    true = {corner: float(drive.truth[f"true_fz_{corner}"][keep].mean()) for corner in ("fl", "fr", "rl", "rr")}
    rear = [_rear_load(model, drive, share, keep) for share in SHARES]
    wanted = (true["rl"] + true["rr"]) / sum(true.values())
    return float(np.polyval(np.polyfit(rear, SHARES, 1), wanted))


def _rear_load(model: Model, drive: Recording, share: float, keep: np.ndarray) -> float:
    states, (inputs, _) = measured_states(drive), measured_inputs(drive, model.external)
    p = model.p.nominal.copy()
    p[model.p.index("pressure_share")] = share
    _, full = Predictor(model, drive.dt).track_memory(states, inputs, p)
    front, rear = model.probe("load_f", "load_r").map(len(states))(states.T, full.T, p).full()[:, keep].mean(axis=1)
    return float(rear / (front + rear))


if __name__ == "__main__":
    main()
