"""Axle forces of the declared vehicle on the reference drives: `python -m benchmarks.axle_forces ../shared/data/chrono_vehicle`.

The model gets the true n of the drive's name and the recorded states and inputs; its forces are judged by the wheel forces
of the simulator (`true_*`, which nothing that estimates reads): rms of the error over rms of the force, smoothed over 0.1 s.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from benchmarks.judges.true_soil import drive_name, nominal_logs, true_soil
from softsoil.codegen.predictor import Predictor
from softsoil.estimator.horizons import START_UP
from softsoil.recording.read import read_drive
from softsoil.recording.states import measured_states
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

VEHICLES = Path(__file__).resolve().parents[1] / "vehicles"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    vehicles = {name: load_vehicle(VEHICLES / f"{name}.toml") for name in ("paper", "reference")}
    rows: dict[str, list[tuple[float, float]]] = {name: [] for name in vehicles}
    for log in nominal_logs(options.folder):
        told = []
        for name, vehicle in vehicles.items():
            errors = axle_errors(log, vehicle, true_soil(drive_name(log)))
            rows[name].append(errors)
            told.append(f"{name}: front {100 * errors[0]:5.1f} %, rear {100 * errors[1]:5.1f} %")
        print(f"{log.name:30s} " + " | ".join(told), flush=True)
    for name, table in rows.items():
        print(
            f"{name}: median front {100 * np.median(table, axis=0)[0]:.1f} %, rear {100 * np.median(table, axis=0)[1]:.1f} %"
        )


def axle_errors(log: Path, vehicle, soil) -> tuple[float, float]:
    """Relative rms error of the front and the rear axle's lateral force."""
    recording = read_drive(log)
    model = bicycle(vehicle, soil)
    states, (inputs, _) = measured_states(recording), measured_inputs(recording, model.external)
    predictor = Predictor(model, recording.dt)
    _, full = predictor.track_memory(states, inputs, model.p.nominal)
    forces = model.probe("force_f", "force_r").map(len(states))(states.T, full.T, model.p.nominal).full()
    keep = recording.t > recording.t[0] + START_UP
    errors = []
    for axle, force in zip("fr", forces, strict=True):
        truth = recording.truth[f"true_fy_{axle}l"] + recording.truth[f"true_fy_{axle}r"]
        apart, true = (savgol_filter(a, 9, 2)[keep] for a in (force - truth, truth))
        errors.append(float(np.sqrt(np.mean(apart**2) / np.mean(true**2))))
    return errors[0], errors[1]


if __name__ == "__main__":
    main()
