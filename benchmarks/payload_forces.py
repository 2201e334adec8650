"""Why a payload comes out too heavy: the model's axle forces on drives of the plant with a load and without, in ruts and without.

`python -m benchmarks.payload_forces`: nothing is fitted. The declared model of vehicles/plant.toml with the true n and the true
payload runs along the recorded states; its forces and loads over the true ones are printed for each axle, what the rear wheels
bear against each other (left minus right, N), and what the rear suspension does meanwhile, which the bicycle does not have: the
wheels' toe (left minus right, mrad) and their common steering per lateral acceleration (mrad per m/s^2).
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from softsoil.codegen.predictor import Predictor
from softsoil.mpc_demo.blind_test import PLANT_VEHICLE
from softsoil.plant.effects import Effects
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Driver, Manoeuvre, MultiSine, Speed
from softsoil.plant.simulate import simulate
from softsoil.plant.start import Start
from softsoil.plant.state import TRAVEL
from softsoil.plant.suspension import AXLE_X, COUNT, carrier
from softsoil.plant.world import Plant, Sample
from softsoil.recording.drive import Recording
from softsoil.recording.states import measured_states
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import add_effect
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, Soil
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

Array = NDArray[np.float64]

SOILS = (CLAY.with_(n=0.62), SANDY_LOAM.with_(n=0.75))
PLACE = 2.3
"""m behind the front axle."""
SECONDS, START_UP = 30.0, 200
SMOOTH = 21
"""Rows of the quadratic that takes the wheels' bounce off the forces."""


class Watched:
    """A driver beside whom the rear suspension is watched; steer: angles of the rear wheels, left and right, a row each (rad)."""

    def __init__(self, driver: Driver, plant: Plant) -> None:
        self.steer: list[list[float]] = []
        self._driver, self._plant, self._paths = driver, plant, load_plant_vehicle().machine.paths

    @property
    def name(self) -> str:
        """Name of the recording."""
        return "payload"

    def __call__(self, t: Array, sample: Sample) -> Array:
        """What the driver commands at the times t (s)."""
        value, by_q, by_angle = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
        angles = []
        for wheel in (2, 3):
            carrier(self._paths[wheel], self._plant.state[TRAVEL + wheel], 0.0, value, by_q, by_angle)
            angles.append(-float(value[AXLE_X]))
        self.steer.append(angles)
        return self._driver(t, sample)


def run(soil: Soil, payload: float, ruts: bool, seed: int) -> tuple[Recording, Array]:
    """A multi-sine drive of the plant, and the steering angles (N, 2) of its rear wheels (rad)."""
    effects = {"multipass": ruts, **({"payload": payload, "payload_at": [-PLACE, 0.0, 0.9]} if payload else {})}
    plant = Plant(soil, effects=Effects.from_table(effects), start=Start(u=5.0))
    watched = Watched(Manoeuvre("payload", MultiSine(seed=seed), Speed(5.5, 1.2, 10.0)), plant)
    return simulate(watched, soil, SECONDS, plant=plant), np.array(watched.steer)


def modelled(drive: Recording, soil: Soil, payload: float, ruts: bool) -> Array:
    """(6, N): force_f, force_r, load_f, load_r and the rear wheels' lateral forces, left and right, of the declared model."""
    vehicle = load_vehicle(PLANT_VEHICLE)
    model = bicycle(vehicle, soil)
    if payload:
        told = {"payload_mass": payload, "payload_x": PLACE}
        model = add_effect(model, catalogue(vehicle)["payload"], told)
    p = model.p.nominal
    if not ruts:
        p[model.p.index("kappa")] = 0.0
    states, (inputs, _) = measured_states(drive), measured_inputs(drive, model.external)
    _, full = Predictor(model, drive.dt).track_memory(states, inputs, p)
    model = model.correct("balance", lambda q: {f"side_{w.name}": w.force.f_y for w in q["wheels"]})
    probe = model.probe("force_f", "force_r", "load_f", "load_r", "side_rl", "side_rr")
    return probe.map(len(states))(states.T, full.T, p).full()


def told_of(soil: Soil, payload: float, ruts: bool, seed: int) -> str:
    """One line of the table."""
    drive, steer = run(soil, payload, ruts, seed)
    truth, found = drive.truth, modelled(drive, soil, payload, ruts)

    def smooth(values: Array) -> Array:
        return savgol_filter(values, SMOOTH, 2)[START_UP:-SMOOTH]

    def true(kind: str, axle: str, sign: float = 1.0) -> Array:
        return smooth(truth[f"true_{kind}_{axle}l"] + sign * truth[f"true_{kind}_{axle}r"])

    sides = [true("fy", axle) for axle in "fr"]
    force = [float(smooth(values) @ side / (side @ side)) for values, side in zip(found[:2], sides, strict=True)]
    load = [float(smooth(found[2 + i]).mean() / true("fz", axle).mean()) for i, axle in enumerate("fr")]
    apart, theirs = float(smooth(found[4] - found[5]).mean()), float(true("fy", "r", -1.0).mean())
    left, right = (1e3 * smooth(column) for column in steer.T)
    per = np.polyfit(smooth(drive["u"] * drive["omega_z"]), (left + right) / 2, 1)[0]
    return (
        f"{soil.name:11s}{soil.n:5.2f}{payload:7.0f} kg  {'ruts' if ruts else 'none':5s}"
        f"{force[0]:7.3f}{force[1]:7.3f}   {load[0]:6.3f}{load[1]:7.3f}   {theirs:6.0f}{apart:6.0f}"
        f"   {np.mean(left - right):6.1f}{per:6.2f}"
    )


def main() -> None:
    """Read the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--payload", type=float, default=350.0, help="kg")
    parser.add_argument("--seed", type=int, default=5, help="of the steering")
    arguments = parser.parse_args()
    print("                                force f/true r   load f/true r   l-r true model   toe, per a_y")
    for soil in SOILS:
        for ruts in (False, True):
            for payload in (0.0, arguments.payload):
                print(told_of(soil, payload, ruts, arguments.seed), flush=True)


if __name__ == "__main__":
    main()
