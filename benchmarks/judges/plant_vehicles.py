"""Vehicles of the plant for blind tests: what their owner measures, with its errors, and the logs that they drive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.judges.true_inertia import balanced_inertia
from softsoil.mpc_demo.blind_cases import N_RANGES
from softsoil.plant.drawn_vehicle import DRAW, Draw, DrawnVehicle, draw_vehicle
from softsoil.plant.effects import Effects
from softsoil.plant.machine import PlantVehicle
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Sine, Speed, Steer, Steps
from softsoil.plant.simulate import simulate
from softsoil.plant.start import Start
from softsoil.plant.suspension import COUNT, TURN, carrier
from softsoil.plant.world import STEP, Plant
from softsoil.recording.drive import Recording
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import by_name
from softsoil.symbolic.soil import SOILS, Soil

SEARCH = 0.1
"""m above the soil, up to which the simulated contact takes a wheel's underside into the width of its footprint."""
SINKAGE = 0.03
"""m: of a wheel, about, on the soils that are drawn."""
REACH_ERROR = 2.0
"""Errors of measuring stay within so many standard deviations."""
SWING_ERROR = 0.05
"""Standard deviation of swing_rear by a tape on arm and wheel."""
SMALL = 1.8
"""m: wheelbase below which a vehicle drives slower, as its times of turning do."""
ROBOTS = Draw(mass=(180.0, 350.0), radius=(0.18, 0.3), wheelbase=(1.1, 1.8), pressure=(15e3, 30e3))
"""Light robots."""
FIT = ("lock", "multi", "held")
"""Manoeuvres of the logs that an identification gets, the last of which it leaves out."""
SECONDS = {"lock": 30.0, "multi": 45.0, "held": 40.0, "steps": 30.0}
"""Length of the logs by manoeuvre."""
JUDGE = ("multi", "lock", "steps")
"""Manoeuvres of the logs that judge."""


@dataclass(frozen=True)
class Case:
    """A vehicle of the plant by its seed: the vehicle and what its owner says of it."""

    seed: int
    drawn: DrawnVehicle
    known: Known


@dataclass(frozen=True)
class Log:
    """A clean drive of the plant with its soil class and the n that it was driven on; whole: the same with its true columns,
    to judge by."""

    drive: Recording
    soil: Soil
    n: float
    whole: Recording


def case_of(seed: int, draw: Draw = DRAW) -> Case:
    """The vehicle of a seed, measured with the errors that the table of numbers states for scale and tape; the arms of a trailing
    rear suspension, too."""
    drawn = draw_vehicle(seed, draw)
    rng = np.random.default_rng([seed, 4])
    numbers = by_name()
    exact = Known(drawn.vehicle.name, dict(drawn.measured))
    told = {}
    for name, value in drawn.measured.items():
        std = numbers[name if name in numbers else name.removesuffix("_rear")].measured(exact, value)
        told[name] = value + std * float(np.clip(rng.standard_normal(), -REACH_ERROR, REACH_ERROR))
    if drawn.layouts[1] == "trailing":
        error = float(np.clip(rng.standard_normal(), -REACH_ERROR, REACH_ERROR))
        told["swing_rear"] = swing_of(drawn.vehicle, 2) + SWING_ERROR * error
    return Case(seed, drawn, Known(drawn.vehicle.name, told, file=f"seed {seed}", simulator=simulator(drawn.measured["radius"])))


def inertia_of(case: Case, logs: Sequence[Log]) -> float:
    """Yaw inertia (kg m^2) that the true wheel forces of a case's logs balance with."""
    paths = case.drawn.vehicle.machine.paths
    tracks = (float(2 * paths[0, 1, 0, 0]), float(2 * paths[2, 1, 0, 0]))
    arms = (case.drawn.vehicle.l_f, case.drawn.vehicle.l_r)
    return balanced_inertia([log.whole for log in logs if not log.drive.name.startswith("steps")], arms, tracks)


def swing_of(vehicle: PlantVehicle, wheel: int) -> float:
    """How far a wheel's rim rolls on at the ground per travel (m/m) beyond what a speed sensor on its carrier says: the
    carrier turns by so much, less what its centre moves forward. vehicle: of the plant; wheel: fl, fr, rl, rr by number."""
    value, by_travel, by_angle = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
    carrier(vehicle.machine.paths[wheel], 0.0, 0.0, value, by_travel, by_angle)
    return float(vehicle.machine.radius[wheel] * value[TURN + 1] - by_travel[0])


def simulator(radius: float) -> dict[str, float]:
    """Settings of the simulated soil for wheels of a radius (m), as vehicles/plant.toml has them for its own."""
    patch = 2.0 * math.sqrt(1.0 - max(1.0 - (SEARCH + SINKAGE) / radius, 0.0) ** 2)
    return {"contact_step": STEP, "contact_entry": 0.1, "patch_length": round(patch, 2)}


def log_of(case: Case, kind: str, number: int, effects: Mapping[str, Any] | None = None, on: Soil | None = None) -> Log:
    """A log of a case's vehicle.

    kind: "lock", "multi", "held" or "steps"; number: of the log, by which soil, n, speed and heading are drawn; effects: of the
    plant, switched on; on: a soil, with its n, in the place of a drawn one.
    """
    rng = np.random.default_rng([case.seed, 5, number])
    name = str(rng.choice(list(N_RANGES)))
    n = float(rng.uniform(*N_RANGES[name]))
    soil = SOILS[name].with_(n=n) if on is None else on
    limit, measured = case.drawn.vehicle.max_steer, case.drawn.measured
    slower = math.sqrt(min((measured["l_f"] + measured["l_r"]) / SMALL, 1.0))  # as a smaller vehicle turns alike
    speed, period = slower * float(rng.uniform(4.5, 6.0)), slower * float(rng.uniform(9.0, 13.0))
    multi = MultiSine(amplitude=0.85 * limit, seed=1000 * case.seed + number)
    steers: dict[str, tuple[Steer, Speed]] = {
        "lock": (Sine(0.98 * limit, 3.0 * slower), Speed(speed - 0.5 * slower, 0.4 * slower, period)),
        "multi": (multi, Speed(speed, 1.5 * slower, period)),
        "held": (multi, Speed(speed, 1.2 * slower, period)),
        "steps": (Steps(tuple(share * limit for share in (0.3, 0.5, 0.7, 0.9))), Speed(speed, 0.5 * slower, period)),
    }
    steer, throttle = steers[kind]
    start = Start(u=speed, psi=float(rng.uniform(-math.pi, math.pi)))
    made = Effects.from_table({"locked_centre": not case.drawn.open_centre, **(effects or {})})
    plant = Plant(soil, vehicle=case.drawn.vehicle, effects=made, start=start, spacing=case.drawn.spacing)
    drive = simulate(Manoeuvre(f"{kind}_{number}", steer, throttle), soil, SECONDS[kind], plant=plant)
    declared, n = (SOILS[name], n) if on is None else (on, float(on.n))
    return Log(Recording(f"{kind}_{number}", drive.channels, {}, drive.notes), declared, n, drive)


def effects_of(case: Case) -> dict[str, tuple[dict[str, Any], dict[str, Any]]]:
    """What is built into the plant to be named, scaled to the vehicle: switch of the world -> settings, true size."""
    rng = np.random.default_rng([case.seed, 6])
    m = case.drawn.measured
    load = 0.25 * m["mass"]
    sign = [float(rng.choice([-1.0, 1.0])) for _ in range(2)]
    offset, bank = sign[0] * float(rng.uniform(0.02, 0.05)), sign[1] * float(rng.uniform(0.05, 0.1))
    lag = float(rng.uniform(0.1, 0.25))
    behind = -0.85 * (m["l_f"] + m["l_r"])
    return {
        "load_carried": ({"payload": load, "payload_at": (behind, 0.0, m["h_cg"] + 0.3)}, {"size": load}),
        "steer_offset": ({"steer_offset": offset}, {"size": offset}),
        "slope_aside": ({"bank": bank}, {"size": bank}),
        "steer_lag": ({"steer_lag": lag}, {"size": lag}),
    }
