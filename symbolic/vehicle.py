"""The vehicle in numbers, from TOML."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from softsoil.files.package_data import vehicle_file
from softsoil.files.toml_file import finite_number, read_toml
from softsoil.symbolic.wheel import Wheel

GRAVITY = 9.81
"""m/s^2"""

BOUNDS: dict[str, tuple[float, float, str]] = {
    "mass": (0.1, 1e5, "kg"),
    "l_f": (0.01, 20.0, "m"),
    "l_r": (0.01, 20.0, "m"),
    "yaw_inertia": (1e-4, 1e7, "kg m^2"),
    "track": (0.01, 10.0, "m"),
    "track_rear": (0.0, 10.0, "m"),
    "scrub": (-1.0, 1.0, "m"),
    "h_cg": (0.0, 5.0, "m"),
    "load_offset": (-2.0, 2.0, "m"),
    "pull": (-1e5, 1e5, "N m"),
    "roll_stiffness_front": (0.0, 1.0, "1"),
    "roll_damping_front": (0.0, 1.0, "1"),
    "roll_gain": (0.0, 0.2, "rad s^2/m"),
    "pitch_gain": (0.0, 10.0, "rad/(N m)"),
    "ackermann": (-5.0, 5.0, "1/rad"),
    "toe": (-0.2, 0.2, "rad"),
    "toe_rear": (-0.2, 0.2, "rad"),
    "toe_rear_load": (-0.1, 0.1, "rad/N"),
    "steer_offset": (-0.2, 0.2, "rad"),
    "steer_gain": (0.5, 1.5, "1"),
    "max_steer": (0.01, 1.5, "rad"),
    "max_steer_rate": (0.01, 50.0, "rad/s"),
    "radius": (0.005, 5.0, "m"),
    "width": (0.005, 5.0, "m"),
}
"""Numbers of a vehicle: least and greatest value, unit."""


@dataclass(frozen=True)
class Vehicle:
    """A two-axle vehicle with rigid wheels.

    mass (kg); l_f, l_r: centre of gravity to front and rear axle, at rest on level hard ground (m); yaw_inertia (kg m^2);
    track: between the front wheels when they point ahead (m); track_rear: between the rear wheels (m, 0: as in front);
    scrub: how far each front wheel's centre stands outside the axis it is steered about (m); h_cg: height of the centre of
    gravity above the soil (m); load_offset: how far behind l_r, l_f say the static load acts (m, the e of the load balance);
    pull: yaw moment that is there on every drive (N m, left positive);
    roll_stiffness_front, roll_damping_front: the front axle's share of the springs and of the dampers that resist roll (1), and
    so of the lateral load transfer; roll_gain: how far the body rolls on its springs per lateral acceleration (rad s^2/m);
    pitch_gain: how far it leans back on them per pitching moment (rad/(N m));
    ackermann, toe: delta_left - delta_right = ackermann delta^2 + toe (1/rad, rad); toe_rear: the same of the rear wheels (rad),
    toe_rear_load: and how it goes with their axle's load beyond that at rest (rad/N);
    steer_offset (rad), steer_gain (1): the mean road-wheel angle is steer_offset + steer_gain times the recorded `steer`;
    max_steer (rad), max_steer_rate (rad/s);
    radius, width: of the wheels (m); effects: declared effects by name, each a table of parameters; uncertainty: standard
    deviations by name of numbers and of effects' parameters, in their units, as far as they are known.
    Raises ValueError for a number outside its physical bounds.
    Example: softsoil.load_vehicle("reference").with_(mass=2000.0).mass == 2000.0
    """

    name: str
    mass: float
    l_f: float
    l_r: float
    yaw_inertia: float
    track: float
    h_cg: float
    radius: float
    width: float
    track_rear: float = 0.0
    scrub: float = 0.0
    load_offset: float = 0.0
    pull: float = 0.0
    roll_stiffness_front: float = 0.5
    roll_damping_front: float = 0.5
    roll_gain: float = 0.007
    pitch_gain: float = 0.0
    ackermann: float = 0.0
    toe: float = 0.0
    toe_rear: float = 0.0
    toe_rear_load: float = 0.0
    steer_offset: float = 0.0
    steer_gain: float = 1.0
    max_steer: float = 0.5
    max_steer_rate: float = 1.0
    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    uncertainty: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for key, (lower, upper, unit) in BOUNDS.items():
            value = getattr(self, key)
            if not lower <= value <= upper:
                raise ValueError(
                    f"vehicle {self.name}: expected {key} in [{lower:g}, {upper:g}] {unit}, found {value:g}"
                )

    @property
    def wheel(self) -> Wheel:
        """The wheel that all four corners carry."""
        return Wheel(self.radius, self.width)

    @property
    def rear_track(self) -> float:
        """Distance between the rear wheels, m."""
        return self.track_rear or self.track

    @property
    def wheelbase(self) -> float:
        """l_f + l_r, m."""
        return self.l_f + self.l_r

    def with_(self, **values: Any) -> Vehicle:
        """The same vehicle with other numbers, by name."""
        return replace(self, **values)


def load_vehicle(source: str | Path) -> Vehicle:
    """A vehicle: a built-in one by name (reference, paper, plant), or a TOML file with the fields of Vehicle as keys and an
    `[effects.<name>]` table for each declared effect.

    Raises ValueError naming the file, the key, what was expected and what was found.
    Example: softsoil.load_vehicle("paper").effects == {}
    """
    path = vehicle_file(source)
    table = read_toml(path, "vehicle")
    return vehicle_from_table(table.get("vehicle", table), str(path), path.stem)


def vehicle_from_table(table: dict[str, Any], where: str, name: str) -> Vehicle:
    """Vehicle from a parsed TOML table; ValueError naming `where`, the key, what was expected and what was found."""
    known = {f.name: f for f in fields(Vehicle)}
    for key in table:
        if key not in known:
            raise ValueError(f"{where}: expected keys {', '.join(known)}; found {key!r}")
    values: dict[str, Any] = {"name": str(table.get("name", name)), "effects": _effects(table, where)}
    values["uncertainty"] = _uncertainty(table, values["effects"], where)
    for key, (_, _, unit) in BOUNDS.items():
        if key not in table:
            if known[key].default is known["mass"].default:
                raise ValueError(f"{where}: expected key {key!r} ({unit}), found none")
            continue
        values[key] = finite_number(table[key], f"{where}: key {key!r}")
    try:
        return Vehicle(**values)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _effects(table: dict[str, Any], where: str) -> dict[str, dict[str, float]]:
    effects = table.get("effects", {})
    if not isinstance(effects, dict) or not all(isinstance(value, dict) for value in effects.values()):
        raise ValueError(f"{where}: expected [effects.<name>] tables of numbers, found {effects!r}")
    return {
        name: {key: finite_number(value, f"{where}: effects.{name}.{key}") for key, value in values.items()}
        for name, values in effects.items()
    }


def _uncertainty(table: dict[str, Any], effects: dict[str, dict[str, float]], where: str) -> dict[str, float]:
    stds = table.get("uncertainty", {})
    if not isinstance(stds, dict):
        raise ValueError(f"{where}: expected a table [uncertainty] of standard deviations, found {stds!r}")
    there = {*BOUNDS, *(key for values in effects.values() for key in values)}
    numbers = {key: finite_number(value, f"{where}: uncertainty.{key}") for key, value in stds.items()}
    for key, value in numbers.items():
        if key not in there or not value > 0:
            raise ValueError(
                f"{where}: uncertainty.{key}: expected a positive standard deviation of a number of the vehicle or of a "
                f"parameter of its effects, found {value:g}"
            )
    return numbers
