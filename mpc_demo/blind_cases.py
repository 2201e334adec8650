"""Drives of the blind test: drawn from a seed on the plant's own physics, unknown to the tracing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from softsoil.plant.effects import Effects
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Speed
from softsoil.plant.sensors import ODOMETRY, Sensors
from softsoil.plant.simulate import simulate
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start
from softsoil.recording.drive import Recording
from softsoil.symbolic.soil import SOILS, Soil

KINDS = ("effect", "effect", "clean", "effect", "effect", "outside", "effect", "clean")
"""Kinds of drives in turns: of 40, 25 with an effect of the catalogue, 10 clean, 5 with one outside the catalogue."""
DURATION = 45.0
N_RANGES = {"clay": (0.45, 0.75), "sandy_loam": (0.5, 0.9)}
"""Sinkage exponents of the shared drives' soils, about."""

Generator = np.random.Generator
Case = dict[str, Any]
Drawn = tuple[dict[str, Any], dict[str, Any], float | None]
"""Effects and sensors of the plant, and the size of what was switched on."""


def _sign(rng: Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _sized(rng: Generator, low: float, high: float) -> float:
    return _sign(rng) * float(rng.uniform(low, high))


def _world(made: Effects | Sensors) -> dict[str, Any]:
    """What is switched on in the world or at its sensors, as JSON has it."""
    bare = type(made)()
    on = {f.name: getattr(made, f.name) for f in fields(made) if getattr(made, f.name) != getattr(bare, f.name)}
    return {name: list(value) if isinstance(value, tuple) else value for name, value in on.items()}


def _one(made: Callable[[float], Effects], low: float, high: float, signed: bool = False, about: float = 0.0):
    """A switch of the world with one number, drawn between low and high off `about`, of either sign if `signed`."""

    def draw(rng: Generator) -> Drawn:
        value = about + (_sized(rng, low, high) if signed else float(rng.uniform(low, high)))
        return _world(made(value)), {}, value

    return draw


def _sensor(made: Callable[[float], Sensors], low: float, high: float, signed: bool = False, about: float = 0.0):
    """The same for a fault of the sensors."""

    def draw(rng: Generator) -> Drawn:
        value = about + (_sized(rng, low, high) if signed else float(rng.uniform(low, high)))
        return {}, _world(made(value)), value

    return draw


def _load(rng: Generator) -> Drawn:
    mass, behind = float(rng.uniform(200.0, 400.0)), float(rng.uniform(2.0, 2.6))
    return _world(Effects(payload=mass, payload_at=(-behind, 0.0, 0.9))), {}, mass


def _wind(rng: Generator) -> Drawn:
    size, heading = float(rng.uniform(600.0, 1500.0)), float(rng.uniform(-math.pi, math.pi))
    return _world(Effects(wind=(size * math.cos(heading), size * math.sin(heading)))), {}, size


def _locked(rng: Generator) -> Drawn:
    return _world(Effects(locked_front=True, locked_rear=True)), {}, None


def _ground(rng: Generator) -> Drawn:
    # A border that the drive crosses inside the part that is fitted, some ten seconds from its ends.
    change = _sized(rng, 0.15, 0.25)
    return {BORDER: [change, float(rng.uniform(70.0, 100.0))]}, {}, change


BORDER = "ground_change"
"""Change of n beyond a line across world x, and where that is (m): the ground's own, not one of the plant's effects."""
INSIDE: Mapping[str, Callable[[Generator], Drawn]] = {
    "slope_aside": _one(lambda v: Effects(bank=v), 0.04, 0.12, signed=True),
    "slope_ahead": _one(lambda v: Effects(grade=v), 0.04, 0.12, signed=True),
    "steer_lag": _one(lambda v: Effects(steer_lag=v), 0.1, 0.3),
    "steer_delay": _one(lambda v: Effects(steer_delay=v), 0.1, 0.3),
    "steer_offset": _one(lambda v: Effects(steer_offset=v), 0.02, 0.05, signed=True),
    "steer_backlash": _one(lambda v: Effects(steer_backlash=v), 0.03, 0.07),
    "pull": _one(lambda v: Effects(yaw_moment=v), 500.0, 1200.0, signed=True),
    "steer_gain": _one(lambda v: Effects(steer_gain=v), 0.1, 0.2, signed=True, about=1.0),
    "load_carried": _load,
    "wind": _wind,
    "locked_axles": _locked,
    BORDER: _ground,
    "gyro_drift": _sensor(lambda v: Sensors(bias={"omega_z": v}), 0.01, 0.04, signed=True),
    "speed_error": _sensor(lambda v: Sensors(scale={"u": v}), 0.05, 0.1, signed=True, about=1.0),
    "mount_offset": _sensor(lambda v: Sensors(lever_arm=(v, 0.0)), 0.4, 1.2, signed=True),
    "late_sensors": _sensor(lambda v: Sensors(delay=dict.fromkeys(ODOMETRY, v)), 0.1, 0.25),
}
"""Switches of the world to which an effect of the catalogue answers; sizes inside physics' plausible ranges."""


def _undulation(rng: Generator) -> dict[str, Any]:
    return {"undulation": float(rng.uniform(0.06, 0.12)), "undulation_length": float(rng.uniform(15.0, 35.0))}


def _rear_toe(rng: Generator) -> dict[str, Any]:
    toe = _sized(rng, 0.02, 0.04)
    return {"rear_toe": [toe, toe]}


def _odd_tyres(rng: Generator) -> dict[str, Any]:
    return {"width_factor": [1.0, 1.0, *[float(rng.uniform(0.6, 0.75))] * 2]}


def _roll_bars(rng: Generator) -> dict[str, Any]:
    return {"bar_factor": [0.0, float(rng.uniform(2.0, 4.0))], "damper_factor": [0.1, 0.1, 0.1, 0.1]}


OUTSIDE: Mapping[str, Callable[[Generator], dict[str, Any]]] = {
    "undulation": _undulation,
    "rear_toe": _rear_toe,
    "odd_tyres": _odd_tyres,
    "roll_bars": _roll_bars,
}
"""Effects of the plant that the catalogue lacks."""


def draw_cases(
    drives: int, seed: int, duration: float = DURATION, candidates: Sequence[str] | None = None
) -> list[Case]:
    """Cases as JSON values: drives of `duration` (s), the kinds in turns, each effect drawn before one comes again.

    seed: of all that is drawn; candidates: a coarse test draws from these switches of INSIDE and tries no other effects.
    Raises ValueError for a candidate that no drive can have.
    """
    for name in candidates or ():
        if name not in INSIDE:
            raise ValueError(f"candidates: expected names of {', '.join(INSIDE)}; found {name!r}")
    rng = np.random.default_rng([seed, 2])
    inside, outside = _in_turns(rng, list(candidates or INSIDE)), _in_turns(rng, list(OUTSIDE))
    more = {} if candidates is None else {"candidates": list(candidates)}
    cases = []
    for index in range(drives):
        kind = KINDS[index % len(KINDS)]
        soil = str(rng.choice(list(N_RANGES)))
        case: Case = {"seed": seed, "index": index, "kind": kind, "soil": soil, "duration": duration, **more}
        case["n"] = float(rng.uniform(*N_RANGES[soil]))
        names = ("speed", "wave", "period")
        spans = ((4.5, 6.5), (1.0, 1.8), (9.0, 13.0))
        case["drive"] = {name: float(rng.uniform(*span)) for name, span in zip(names, spans, strict=True)}
        heading = float(rng.uniform(-math.pi, math.pi))
        drawn: Drawn = ({}, {}, None)
        name = ""
        if kind == "effect":
            name = next(inside)
            drawn = INSIDE[name](rng)
            if name == BORDER:  # it lies across world x: the drive has to come there
                heading *= 0.1
                drawn[0][BORDER][1] *= duration / DURATION
        elif kind == "outside":
            name = next(outside)
            drawn = (OUTSIDE[name](rng), {}, None)
        case["drive"]["heading"] = heading
        cases.append({**case, "name": name, **dict(zip(("effects", "sensors", "truth"), drawn, strict=True))})
    return cases


def _in_turns(rng: Generator, names: list[str]):
    while True:
        yield from (str(name) for name in rng.permutation(names))


def drive_case(case: Mapping[str, Any]) -> Recording:
    """The drive of a case as its sensors record it: multi-sine steering at a varied speed, the `good` noise."""
    seed = 1000 * int(case["seed"]) + int(case["index"])
    told = case["drive"]
    manoeuvre = Manoeuvre("blind", MultiSine(seed=seed), Speed(told["speed"], told["wave"], told["period"]))
    soil = SOILS[case["soil"]].with_(n=case["n"])
    effects = dict(case["effects"])
    ground: Soil | SoilField = soil
    if BORDER in effects:
        change, place = effects.pop(BORDER)
        ground = SoilField.change_at(soil, soil.with_(n=case["n"] + change), place)
    sensors: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in case["sensors"].items()
    }
    recording = simulate(
        manoeuvre,
        ground,
        float(case["duration"]),
        effects=Effects.from_table(effects),
        sensors=Sensors("good", **sensors),
        seed=seed,
        start=Start(u=5.0, psi=told["heading"]),
    )
    return Recording(f"blind_{case['index']:02d}", recording.channels, {}, recording.notes)
