"""Axle loads and side forces of vehicles/plant.toml on drives of the plant: `python -m benchmarks.plant_axles`.

The bicycle gets the plant's soil, recorded states and inputs, and nothing is fitted; its axles' forces are judged by those of
the plant's wheels, which find the soil as cylinders and, in a second table, by the independent simulator's rough search
(`plant/reference/raycast.py`). Per drive: mean front load, model less plant, over the plant's; gain of its lateral force on the
plant's and rms error over rms force, front and rear, smoothed over 0.1 s; and by how much larger wheels would have to be for the
longitudinal forces to sum up to what the accelerometer reads (on the multi-sine drives).
"""

from __future__ import annotations

import numpy as np
from scipy.signal import savgol_filter

from benchmarks.axle_forces import VEHICLES
from softsoil.codegen.predictor import Predictor
from softsoil.identification.wheel_balance import WheelBalance, balances
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Sine, Speed, Steer
from softsoil.plant.simulate import drive
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.drive import Recording
from softsoil.recording.states import measured_states
from softsoil.refinement.vehicle_numbers import own_layout
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SAND, SANDY_LOAM, Soil
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.free_starts import free_windows
from softsoil.windows.free_windows import WindowModel
from softsoil.windows.inputs import measured_inputs
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive

SOILS = (CLAY.with_(n=0.5), CLAY.with_(n=0.7), SANDY_LOAM.with_(n=0.55), SANDY_LOAM.with_(n=0.8), SAND.with_(n=1.08))
STEERING: dict[str, Steer] = {"turns": MultiSine(seed=3), "sine": Sine()}
DURATION, START = 20.0, 3.0
"""s: of a drive, and what is left out at its beginning."""
SUBSTEPS, RADIUS_SCALE = 2, 1e-3
"""Steps of the model between two samples; m, of the derivatives."""


def figures(log: Recording, soil: Soil) -> tuple[float, float, float, float, float]:
    """Load error, gain and error of the front axle, gain and error of the rear one."""
    model = bicycle(load_vehicle(VEHICLES / "plant.toml"), soil)
    states, (inputs, _) = measured_states(log), measured_inputs(log, model.external)
    predictor, p = Predictor(model, log.dt), model.p.nominal
    _, full = predictor.track_memory(states, inputs, p)
    load, *forces = model.probe("load_f", "force_f", "force_r").map(len(states))(states.T, full.T, p).full()
    keep = log.t > log.t[0] + START
    true_load = (log.truth["true_fz_fl"] + log.truth["true_fz_fr"])[keep].mean()
    found = [load[keep].mean() / true_load - 1.0]
    for axle, force in zip("fr", forces, strict=True):
        truth = log.truth[f"true_fy_{axle}l"] + log.truth[f"true_fy_{axle}r"]
        told, true = (savgol_filter(a, 9, 2)[keep] for a in (force, truth))
        found += [float(told @ true / (true @ true)), float(np.sqrt(np.mean((told - true) ** 2) / np.mean(true**2)))]
    return tuple(found)


def larger(log: Recording, soil: Soil) -> float:
    """m that the wheels' radius has to grow by for the longitudinal balance to hold on average, by two Newton steps."""
    vehicle = load_vehicle(VEHICLES / "plant.toml")
    model = bicycle(vehicle, soil, "turn_slip", None, own_layout(vehicle))
    drive, p = shooting_drive(log, model, START), model.p.nominal
    windows = free_windows(WindowModel(model, drive.dt, SUBSTEPS, balances(model)), drive, log)
    balance = WheelBalance(windows, p, False)
    i = model.p.index("radius")
    free = Free("radius", ("radius",), RADIUS_SCALE, 0.0, np.inf)
    for _ in range(2):
        linear = balance.linearise(p, [free])
        slope = linear.by_free[..., 0]
        p = p.copy()
        p[i] -= float((slope * linear.residual).sum() / (slope**2).sum())
    return float(p[i] - vehicle.radius)


def main() -> None:
    """Print both tables."""
    for cast in (False, True):
        print("wheels placed by the ray cast:" if cast else "wheels as cylinders:")
        for soil in SOILS:
            for name, steering in STEERING.items():
                plant = Plant(soil, start=Start(u=5.0), cast=cast)
                log = drive(plant, Manoeuvre(name, steering, Speed(5.0, 0.5, 9.0)), DURATION)
                load, front, front_error, rear, rear_error = figures(log, soil)
                rolls = f"; rolls as if {1e3 * larger(log, soil):+.2f} mm larger" if name == "turns" else ""
                print(
                    f"{soil.name:10s} n {soil.n:.2f} {name:6s} front load {100 * load:+.2f} %; force: front gain {front:.3f}, "
                    f"error {100 * front_error:.1f} %; rear gain {rear:.3f}, error {100 * rear_error:.1f} %{rolls}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
