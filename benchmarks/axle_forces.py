"""Axle forces of the declared vehicle on the reference drives: `python -m benchmarks.axle_forces ../shared/data/chrono_vehicle`.

The model gets the true n of the drive's name and the recorded states and inputs; its forces are judged by the wheel forces
of the simulator (`true_*`, which nothing that estimates reads): rms of the error over rms of the force, smoothed over 0.1 s, and
by how long a way (m, at the mean speed) the true force comes later than the model's: with F the model's, a F - b dF/dt + c is
fitted to it, b/a is the time.
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
    rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in vehicles}
    for log in nominal_logs(options.folder):
        told = []
        for name, vehicle in vehicles.items():
            errors = axle_errors(log, vehicle, true_soil(drive_name(log)))
            rows[name].append(errors)
            front, rear, late, late_rear = errors
            told.append(f"{name}: front {100 * front:5.1f} %, {late:+.3f} m late, rear {100 * rear:5.1f} %, {late_rear:+.3f} m")
        print(f"{log.name:30s} " + " | ".join(told), flush=True)
    for name, table in rows.items():
        front, rear, late, late_rear = np.median(table, axis=0)
        print(f"{name}: median front {100 * front:.1f} %, {late:+.3f} m late, rear {100 * rear:.1f} %, {late_rear:+.3f} m")


def axle_errors(log: Path, vehicle, soil) -> tuple[float, ...]:
    """Relative rms error of the front and the rear axle's lateral force, and the way (m) by which each comes late."""
    recording = read_drive(log)
    model = bicycle(vehicle, soil)
    states, (inputs, _) = measured_states(recording), measured_inputs(recording, model.external)
    predictor = Predictor(model, recording.dt)
    _, full = predictor.track_memory(states, inputs, model.p.nominal)
    forces = model.probe("force_f", "force_r").map(len(states))(states.T, full.T, model.p.nominal).full()
    keep = recording.t > recording.t[0] + START_UP
    errors, late = [], []
    for axle, force in zip("fr", forces, strict=True):
        truth = recording.truth[f"true_fy_{axle}l"] + recording.truth[f"true_fy_{axle}r"]
        apart, true = (savgol_filter(a, 9, 2)[keep] for a in (force - truth, truth))
        errors.append(float(np.sqrt(np.mean(apart**2) / np.mean(true**2))))
        whole = savgol_filter(force, 9, 2)
        columns = np.column_stack([whole, -np.gradient(whole, recording.dt), np.ones(len(whole))])[keep]
        gain, delay, _ = np.linalg.lstsq(columns, true, rcond=None)[0]
        late.append(float(delay / gain * recording["u"][keep].mean()))
    return (*errors, *late)


if __name__ == "__main__":
    main()
