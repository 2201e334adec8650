"""The vehicle in numbers, from TOML: each declared once, in the class, with unit, bounds and how one measures it."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from softsoil.files.identify_verdict import verdict_from_table
from softsoil.files.joint_error import JointError, joint_error_from_table
from softsoil.files.package_data import vehicle_file
from softsoil.files.steering_map import SteeringMap, steering_from_table
from softsoil.files.toml_file import finite, number_table, read_toml, table_inside
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.wheel import Wheel

GRAVITY = 9.81
"""m/s^2"""


@dataclass(frozen=True)
class VehicleNumber:
    """One number of a vehicle: name, unit, bounds, default (None: it must be given), what it is and how one measures it.

    spread, share: standard deviation of a plausible first guess, `spread` in its unit plus `share` of the value;
    modelled: whether the model's equations may contain it.
    """

    name: str
    unit: str
    lower: float
    upper: float
    default: float | None
    doc: str
    measured: str
    spread: float = 0.0
    share: float = 0.0
    modelled: bool = True

    def prior(self, value: float) -> float:
        """Standard deviation of a first guess `value`."""
        return self.spread + self.share * abs(value)


def _number(unit: str, lower: float, upper: float, doc: str, measured: str, default: Any = MISSING, **more: Any) -> Any:
    given = None if default is MISSING else default
    return field(default=default, metadata={"number": (unit, lower, upper, given, doc, measured), "more": more})


@dataclass(frozen=True)
class Vehicle:
    """A two-axle vehicle with rigid wheels: NUMBERS says what each number is.

    effects: declared effects by name, each a table of parameters; simulator: where its logs come from a simulated soil, how that
    meets a wheel (SIMULATOR), empty for a real one; driveline: which wheels are driven (DRIVELINE), empty: logs decide;
    uncertainty: standard deviations of numbers and effects' parameters, by name and in their units, as far as they are known;
    joint_error: of numbers identified together; unexplained: root mean square share of the motion of its own logs, per channel of
    JUDGED, that they leave beyond sensor noise; steering: command to mean road-wheel angle; verdict: of `softsoil identify` on
    the file; source: its file.
    Raises ValueError for a number outside its physical bounds.
    Example: softsoil.load_vehicle("reference").with_(mass=2000.0).mass == 2000.0
    """

    name: str
    mass: float = _number("kg", 0.1, 1e5, "mass", "a scale", share=0.03)
    l_f: float = _number("m", 0.01, 20.0, "centre of gravity to front axle, at rest on hard ground", "axle loads", share=0.03)
    l_r: float = _number("m", 0.01, 20.0, "centre of gravity to rear axle, at rest on hard ground", "axle loads", share=0.03)
    yaw_inertia: float = _number("kg m^2", 1e-4, 1e7, "yaw inertia", "turns; mass l_f l_r as a first guess", share=0.3)
    track: float = _number("m", 0.01, 10.0, "between the front wheels when they point ahead", "a tape", share=0.01)
    h_cg: float = _number("m", 0.0, 5.0, "height of the centre of gravity above the soil", "axle loads, tilted", share=0.2)
    radius: float = _number("m", 0.005, 5.0, "of the wheels, or the front ones", "way of ten turns at a crawl", share=0.01)
    width: float = _number("m", 0.005, 5.0, "of the wheels, or the front ones", "a tape", share=0.02)
    track_rear: float = _number("m", 0.0, 10.0, "between the rear wheels, 0: as in front", "a tape", 0.0, spread=0.01)
    radius_rear: float = _number("m", 0.0, 5.0, "of rear wheels, 0: as in front", "as radius", 0.0, share=0.01, modelled=False)
    width_rear: float = _number("m", 0.0, 5.0, "of rear wheels, 0: as in front", "a tape", 0.0, share=0.02, modelled=False)
    scrub: float = _number("m", -1.0, 1.0, "front wheels' centres outside their steering axes", "a tape", 0.0, spread=0.03)
    load_offset: float = _number("m", -2.0, 2.0, "static load behind what l_f, l_r say", "drives", 0.0, spread=0.05)
    roll_stiffness_front: float = _number("1", 0.0, 1.0, "front share of the springs in roll", "data sheet", 0.5, spread=0.1)
    roll_damping_front: float = _number("1", 0.0, 1.0, "front share of the dampers in roll", "data sheet", 0.5, spread=0.15)
    roll_gain: float = _number("rad s^2/m", 0.0, 0.2, "roll on the springs per a_y", "inclinometer in turns", 0.007, share=0.5)
    roll_time: float = _number("s", 0.01, 1.0, "damping over stiffness in roll", "step steer, inclinometer", 0.165, spread=0.05)
    pitch_gain: float = _number("rad/(N m)", 0.0, 10.0, "pitch on the springs per moment", "loads added", 0.0, spread=1e-5)
    ackermann: float = _number("1/rad", -5.0, 5.0, "front: delta_l - delta_r = a delta^2 + toe", "turn plates", 0.0, spread=0.4)
    toe: float = _number("rad", -0.2, 0.2, "front: delta_l - delta_r when pointing ahead", "wheel alignment", 0.0, spread=0.01)
    toe_rear: float = _number("rad", -0.2, 0.2, "rear: delta_l - delta_r at rest", "wheel alignment", 0.0, spread=0.005)
    toe_rear_load: float = _number("rad/N", -0.1, 0.1, "rear toe per axle load beyond rest", "loads added", 0.0, spread=4e-6)
    swing_rear: float = _number("1", -2.0, 2.0, "rear rims roll on per travel, radius over arm", "a tape", 0.0, spread=0.05)
    max_steer: float = _number("rad", 0.01, 1.5, "greatest steering angle", "turn plates", 0.5, share=0.05, modelled=False)
    max_steer_rate: float = _number("rad/s", 0.01, 50.0, "greatest steering rate", "steering log", 1.0, share=0.2, modelled=False)
    n_error: float = _number("1", 0.0, 1.0, "error of n that they make, as a share", "identify", 0.0, spread=0.01, modelled=False)
    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    simulator: dict[str, float] = field(default_factory=dict)
    driveline: dict[str, float] = field(default_factory=dict)
    uncertainty: dict[str, float] = field(default_factory=dict)
    joint_error: JointError | None = None
    unexplained: dict[str, float] = field(default_factory=dict)
    steering: SteeringMap | None = None
    verdict: str = ""
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        for n in NUMBERS:
            value = getattr(self, n.name)
            if not n.lower <= value <= n.upper:
                bounds = f"[{n.lower:g}, {n.upper:g}] {n.unit}"
                raise ValueError(f"vehicle {self.name}: expected {n.name} in {bounds}, found {value:g}")

    @property
    def wheel(self) -> Wheel:
        """A front wheel."""
        return Wheel(self.radius, self.width)

    @property
    def rear_radius(self) -> float:
        """Radius of the rear wheels, m."""
        return self.radius_rear or self.radius

    @property
    def rear_width(self) -> float:
        """Width of the rear wheels, m."""
        return self.width_rear or self.width

    @property
    def rear_track(self) -> float:
        """Distance between the rear wheels, m."""
        return self.track_rear or self.track

    @property
    def wheelbase(self) -> float:
        """l_f + l_r, m."""
        return self.l_f + self.l_r

    @property
    def states_errors(self) -> bool:
        """Whether its file states the error that its numbers make of n, their joint error, or those of TURNING one by one, each
        at most half of what a person measures it to: errors of other numbers say nothing of n's."""
        if self.n_error > 0.0 or self.joint_error is not None:
            return True
        guesses = {number.name: number.prior(getattr(self, number.name)) for number in NUMBERS}
        return all(0.0 < self.uncertainty.get(name, 0.0) <= 0.5 * guesses[name] for name in TURNING)

    def with_(self, **values: Any) -> Vehicle:
        """The same vehicle with other numbers, by name."""
        return replace(self, **values)

    def moved(self, **values: Any) -> Vehicle:
        """The same vehicle with its own numbers as logs have moved them, by name: a rear wheel of another radius keeps to the
        front one's."""
        share = values.get("radius", self.radius) / self.radius
        return self.with_(**{"radius_rear": share * self.radius_rear, **values})


TURNING = ("yaw_inertia", "ackermann", "toe")
"""Numbers that turning rests on and that no scale and no tape gives."""
NUMBERS = tuple(
    VehicleNumber(f.name, *f.metadata["number"], **f.metadata["more"]) for f in fields(Vehicle) if "number" in f.metadata
)
"""Every number of a vehicle, in the order of its file."""
SIMULATOR = Layout.of(
    Signal("contact_step", "s", "time step of the simulated soil: its first contact counts a whole one", 0.0, 0.0, 0.1),
    Signal("contact_entry", "", "share of the contact over which soil keeps the height of its entry", 0.1, 1e-3, 1.0),
    Signal("patch_length", "", "length over radius of the patch that its contact search finds", 0.0, 0.0, 10.0),
)
"""What a simulated soil may declare of itself, in the table [simulator]: options of the force law."""
DRIVELINE = Layout.of(
    Signal("centre_lock", "", "1: both axles turn alike; 0: each has its share of the torque", 1.0, 0.0, 1.0),
    Signal("front_drive", "", "share of the torque at the front axle: 1 front, 0 rear, 0.5 open centre", 0.5, 0.0, 1.0),
)
"""The table [driveline], for logs without wheel speeds (softsoil.declaration.driveline)."""
JUDGED = ("v", "omega_z")
"""Channels that n moves and by which a model is judged."""


KEYS = frozenset(f.name for f in fields(Vehicle)) - {"source"}
"""Of a vehicle's file."""


def load_vehicle(source: str | Path) -> Vehicle:
    """A vehicle: a built-in one by name (reference, paper, plant, heavy), or a TOML file (keys and tables: the class).

    Raises ValueError naming the file, the key, what was expected and what was found.
    Example: softsoil.load_vehicle("paper").effects == {}
    """
    path = vehicle_file(source)
    table = read_toml(path, "vehicle")
    return vehicle_from_table(table_inside(table, "vehicle", KEYS, str(path)), str(path), path.stem)


def vehicle_from_table(table: dict[str, Any], where: str, name: str) -> Vehicle:
    """Vehicle from a parsed TOML table; ValueError naming `where`, the key, what was expected and what was found."""
    missing = [f"{n.name} ({n.unit}: {n.doc})" for n in NUMBERS if n.default is None and n.name not in table]
    if missing:
        found = f"none of {'these' if missing[1:] else 'that name'}; softsoil identify makes a vehicle of what tape and scale say"
        raise ValueError(f"{where}: expected keys {'; '.join(missing)}; found {found}")
    for key in table:
        if key not in KEYS:
            raise ValueError(f"{where}: expected keys {', '.join(sorted(KEYS))}; found {key!r}")
    values: dict[str, Any] = {n.name: finite(table[n.name], f"{where}: key {n.name!r}") for n in NUMBERS if n.name in table}
    for part, options in (("simulator", SIMULATOR), ("driveline", DRIVELINE)):
        values[part] = number_table(table, part, where, {s.name: (s.lower, s.upper) for s in options})
    effects = table.get("effects", {})
    if not isinstance(effects, dict) or not all(isinstance(value, dict) for value in effects.values()):
        raise ValueError(f"{where}: expected [effects.<name>] tables of numbers, found {effects!r}")
    effects = {name: number_table(effects, name, f"{where}: effects") for name in effects}
    there = {*(n.name for n in NUMBERS), *(key for values in effects.values() for key in values)}
    uncertainty = number_table(table, "uncertainty", where, dict.fromkeys(sorted(there), (1e-12, 1e12)))
    values["unexplained"] = number_table(table, "unexplained", where, dict.fromkeys(JUDGED, (0.0, 1.0)))
    values["joint_error"] = joint_error_from_table(table.get("joint_error", {}), there, where)
    values["steering"] = steering_from_table(table.get("steering", {}), where)
    values["verdict"] = verdict_from_table(table, where)
    try:
        return Vehicle(str(table.get("name", name)), effects=effects, uncertainty=uncertainty, source=where, **values)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
