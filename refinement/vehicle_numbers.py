"""Numbers that an identification fits: what each is, where it stands, what is known of it before any log, and why.

Every prior is an argument about vehicles in general, scaled by what the owner measures; none comes from a log. A prior counts as
one Gaussian observation beside thousands of samples: where logs see a number it decides nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from softsoil.files.toml_file import read_toml
from softsoil.refinement.known_vehicle import BOUNDS, Known
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import GRAVITY, SIMULATOR, Vehicle

Prior = Callable[[Known], tuple[float, float]]
"""(expected value, standard deviation) of a number nobody has measured."""
Measured = Callable[[Known, float], float]
"""Standard deviation of a number that its owner has measured to have the value given."""


SCALES: Mapping[str, Callable[[Known], float]] = MappingProxyType(
    {"": lambda k: 1.0, "h_cg": lambda k: k.guess_h_cg, "drag": lambda k: GRAVITY * k["mass"] * k["track"]}
)
"""Numbers of a vehicle by which expectations scale."""


@dataclass(frozen=True)
class Number:
    """One number of a vehicle, or one parameter of an effect that every vehicle on soft soil has.

    name; effect: the effect that it belongs to, "" for a number of the vehicle itself; unit; doc; lower, upper: bounds;
    prior: expected value and standard deviation where it is not given; why: the argument for the prior; measured: standard
    deviation where it is given; how: how one measures it; free: whether logs may move it;
    pinned_by: the manoeuvre that shows a parameter of an effect; shown_by: the group of channels (`checking.offsets`) that seems
    early where a vehicle has much of the effect, "" for none; takes_up: a fit moves it also by what the model lacks, which its
    standard deviation does not hold.
    """

    name: str
    effect: str
    unit: str
    doc: str
    lower: float
    upper: float
    prior: Prior
    why: str
    measured: Measured
    how: str
    free: bool = True
    pinned_by: str = ""
    shown_by: str = ""
    takes_up: bool = False


def _number(name, doc, prior, why, measured, how, free=True, takes_up=False) -> Number:
    lower, upper, unit = BOUNDS[name]
    unit = "" if unit == "1" else unit
    return Number(name, "", unit, doc, lower, upper, prior, why, measured, how, free, takes_up=takes_up)


def _of(effect: str, name: str, entry: Mapping[str, Any]) -> Number:
    """A parameter of an effect from its entry of effect_priors.toml."""
    scale = SCALES[entry["scale"]]
    shown_by = entry.get("shown_by", "")

    def prior(known: Known) -> tuple[float, float]:
        if shown_by in known.early:
            return known.early[shown_by], entry["spread_shown"]
        return scale(known) * entry["value"], scale(known) * entry["spread"]

    lower, upper = entry["bounds"]
    measured = _plain(float(entry["measured"]))
    words = entry["why"], measured, entry["how"]
    seen = {"pinned_by": entry["pinned_by"], "shown_by": shown_by, "takes_up": entry.get("takes_up", False)}
    return Number(name, effect, entry["unit"], entry["doc"], lower, upper, prior, *words, **seen)


def _share(of: float) -> Measured:
    return lambda k, value: of * abs(value)


def _plain(std: float) -> Measured:
    return lambda k, value: std


OWN: tuple[Number, ...] = (
    _number("mass", "mass", lambda k: (k["mass"], 0.0), "", _share(0.005),
            "scale; in lateral motion it acts as yaw inertia and n do, so that no log shows it", free=False),
    _number("l_f", "centre of gravity to front axle", lambda k: (k["l_f"], 0.0), "", lambda k, v: 0.001 * k.wheelbase,
            "wheelbase by tape (3 mm), axle loads by scale (0.1 %)", free=False),
    _number("l_r", "centre of gravity to rear axle", lambda k: (k["l_r"], 0.0), "", lambda k, v: 0.001 * k.wheelbase,
            "wheelbase by tape (3 mm), axle loads by scale (0.1 %)", free=False),
    _number("yaw_inertia", "yaw inertia", lambda k: (0.85 * k.swing, 0.4 * k.swing),
            "radius of gyration squared over l_f l_r is 0.7 to 1.1 on cars, less with a load in the middle, more at the ends",
            _share(0.05), "drawings, or a pendulum"),
    _number("track", "between the front wheels", lambda k: (k["track"], 0.0), "", _share(0.03),
            "tape between the contacts; a suspension moves them by some centimetres", takes_up=True),
    _number("track_rear", "between the rear wheels", lambda k: (k["track"], 0.04 * k["track"]),
            "within some centimetres of the front track", _share(0.03),
            "tape between the contacts; a suspension moves them by some centimetres", takes_up=True),
    _number("radius", "radius of the wheels", lambda k: (k["radius"], 0.0), "", _plain(0.0005),
            "tape around the wheel: 3 mm of the circumference"),
    _number("width", "width of the wheels", lambda k: (k["width"], 0.0), "", _share(0.01), "tape", free=False),
    _number("h_cg", "height of the centre of gravity", lambda k: (0.38 * k["track"], 0.08 * k["track"]),
            "track over twice the height is 1.1 to 1.6 on road and off-road vehicles", _share(0.15),
            "estimate; by scale with one axle lifted", free=False),
    _number("scrub", "front wheels' centres outside the axes that they are steered about",
            lambda k: (0.15 * k["radius"], 0.2 * k["radius"]),
            "the axis meets the wheel between its middle plane and a third of a radius inside it", _plain(0.01), "tape",
            takes_up=True),
    _number("toe", "front toe, left minus right", lambda k: (0.0, 0.015),
            "workshops set it within 0.5 deg; suspensions move it by as much", _plain(0.003), "alignment bench"),
    _number("toe_rear", "rear toe, left minus right", lambda k: (0.0, 0.02),
            "as in front, and suspensions of the rear axle toe in under load", _plain(0.003), "alignment bench"),
    _number("ackermann", "delta_left - delta_right over delta^2",
            lambda k: (0.8 * k["track"] / k.wheelbase, 0.8 * k["track"] / k.wheelbase),
            "track over wheelbase is Ackermann's geometry; steerings have a part of it, some have more", _plain(0.1),
            "turn plates"),
    _number("roll_gain", "roll of the body per lateral acceleration", lambda k: (0.007, 0.005),
            "1 to 8 degrees per g", _share(0.2), "inclinometer in a steady turn"),
    _number("roll_time", "damping of the body's roll over its stiffness", lambda k: (0.1, 0.06),
            "0.03 s on stiff springs to 0.2 s on soft, well damped ones", _share(0.2), "inclinometer while turning in"),
    _number("roll_stiffness_front", "front share of the springs that resist roll", lambda k: (0.5, 0.12),
            "0.35 to 0.65 on cars", _plain(0.05), "drawings"),
    _number("roll_damping_front", "front share of the dampers that resist roll", lambda k: (0.5, 0.12),
            "as the springs'", _plain(0.05), "drawings"),
    _number("swing_rear", "way that the rear rims roll on per travel, unseen by a speed sensor that turns along",
            lambda k: (0.0, 0.25), "0 on wishbones, rigid axles and for a sensor of the whole spin, 0.3 to 0.6 on trailing arms",
            _plain(0.05), "tape, radius over the length of a trailing arm", free=False),
    Number("contact_step", "", "s", SIMULATOR["contact_step"].doc, 0.0, SIMULATOR["contact_step"].upper, lambda k: (0.0, 0.001),
           "0 for a real soil; simulators of soil contact step by 0.5 to 2 ms", _plain(1e-6), "settings of the simulator"),
)  # fmt: skip
"""Numbers of the vehicle itself, in the order of its file, and of the simulated soil that its logs may come from."""
SEARCH_STD = 0.0003
"""m: how well it is known by how much a simulator's contact search enlarges its wheels (`python -m benchmarks.plant_axles`)."""
WIDE = 0.1
"""Share of its value within which a given number lies whose error of measuring is not believed."""
REAL_SOIL = 2e-4
"""s: a contact step below this is that of a real soil."""
_TABLE = read_toml(Path(__file__).parent / "effect_priors.toml", "priors of effects")
FIXED: Mapping[str, Mapping[str, float]] = MappingProxyType(_TABLE.pop("fixed"))
"""What every model of an identification has beside its numbers: the soil's aligning moments act on the vehicle in full."""
OTHER_GROUND: Mapping[str, Mapping[str, float]] = MappingProxyType(_TABLE.pop("other_ground"))
"""What takes their place on soil that shears anew in ruts."""
KINDS_OF_GROUND = frozenset(name for table in OTHER_GROUND.values() for name in table)
"""Parameters that say which of two kinds of ground it is, at either bound of theirs."""
NUMBERS: tuple[Number, ...] = (
    *OWN,
    *(_of(effect, name, entry) for effect, parameters in _TABLE.items() for name, entry in parameters.items()),
)
"""Every number that an identification fits of any vehicle, in the order of a vehicle file."""


def by_name() -> dict[str, Number]:
    """All numbers by name."""
    return {number.name: number for number in NUMBERS}


def expected(known: Known) -> dict[str, tuple[float, float]]:
    """Name -> (value, standard deviation) before any log: as given with the error of measuring it, or the prior; the radius as it
    rolls."""
    table = {}
    for number in NUMBERS:
        given = known.value(number.name)
        if given is None:
            table[number.name] = number.prior(known)
        else:
            std = known.stated.get(number.name) or number.measured(known, given)
            table[number.name] = (given, max(std, 1e-9))
    if known.search:
        tape, std = table["radius"]
        table["radius"] = (tape + known.search, float(np.hypot(std, SEARCH_STD)))
    return table


def vehicle_of(known: Known, values: dict[str, float], stds: dict[str, float] | None = None) -> Vehicle:
    """The vehicle with the given numbers and, where they are stated, their standard deviations.

    values: number -> value; what is missing is as expected; stds: number -> standard deviation.
    """
    merged = {**{name: value for name, (value, _) in expected(known).items()}, **values}
    effects = {name: dict(table) for name, table in FIXED.items()}
    for name, table in OTHER_GROUND.items() if known.other_ground else ():
        effects.setdefault(name, {}).update(table)
    for name, table in known.other_effects(set(by_name())).items():
        effects.setdefault(name, {}).update(table)
    for number in NUMBERS:
        if number.effect:
            effects.setdefault(number.effect, {})[number.name] = merged[number.name]
    own = {number.name: merged[number.name] for number in NUMBERS if not number.effect}
    simulator = {**known.simulator, **{name: own.pop(name) for name in tuple(own) if name in SIMULATOR}}
    if simulator["contact_step"] < REAL_SOIL:
        simulator = known.simulator
    rest: dict[str, Any] = {**known.rest(set(own)), **own, "radius": known["radius"]}
    stated = {name: std for name, std in (stds or {}).items() if name not in SIMULATOR}
    made = Vehicle(name=known.name, effects=effects, simulator=simulator, uncertainty=stated, **rest)
    return replace(made.moved(radius=own["radius"]), steering=known.steering, driveline=known.driveline)


def says_ground(known: Known) -> bool:
    """Whether its owner has said which ground it is."""
    return any(name in known.effects.get(effect, {}) for effect, table in OTHER_GROUND.items() for name in table)


def declared_vehicle(known: Known) -> Vehicle:
    """The vehicle that the known numbers declare by themselves: defaults of a vehicle file for the rest, no effects but those
    declared; yaw inertia and height of the centre of gravity, which have no default, as expected."""
    numbers: dict[str, Any] = {name: expected(known)[name][0] for name in ("yaw_inertia", "h_cg")} | known.numbers
    made = Vehicle(name=known.name, effects=known.effects, simulator=known.simulator, **numbers)
    return replace(made, steering=known.steering, driveline=known.driveline)


def free_layout(known: Known) -> Layout:
    """The vehicle's own numbers as parameters of a model, those that logs may not move among them: their cost is computed."""
    expectation = expected(known)
    return Layout(
        tuple(
            Signal(n.name, n.unit, n.doc, expectation[n.name][0], n.lower, n.upper) for n in NUMBERS if not n.effect
        )
    )


def own_layout(vehicle: Vehicle) -> Layout:
    """The vehicle's own numbers that logs may move, as parameters of a model at their declared values."""
    values = {n.name: float(getattr(vehicle, n.name)) for n in OWN if n.name not in SIMULATOR}
    values["track_rear"] = vehicle.rear_track
    free = (n for n in OWN if n.free and n.name in values)
    return Layout(tuple(Signal(n.name, n.unit, n.doc, values[n.name], n.lower, n.upper) for n in free))
