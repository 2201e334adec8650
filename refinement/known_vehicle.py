"""What the owner of a vehicle knows of it: a vehicle file with some of its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from softsoil.files.steering_map import SteeringMap, steering_from_table
from softsoil.files.toml_file import finite, number_table, read_toml, table_inside
from softsoil.symbolic.vehicle import DRIVELINE, NUMBERS, SIMULATOR
from softsoil.symbolic.vehicle import KEYS as OF_VEHICLE

NEEDED = ("mass", "l_f", "l_r", "track", "radius", "width")
"""What a scale and a tape give: without them nothing can be said of the rest."""
LOADS = ("load_front", "load_rear", "wheelbase")
"""In the place of l_f and l_r."""
KEYS = OF_VEHICLE | set(LOADS)
UNITS: Mapping[str, float] = MappingProxyType({"kg": 1.0, "N": 9.81, "kN": 9.81e-3, "lb": 2.2046})
"""In which axles are weighed: unit -> what a kg weighs in it."""
WEIGHED = 0.03
"""Share of the mass that the axles' loads may miss, as two scales do."""
TAPED = 0.01
"""Share of the wheelbase that l_f and l_r may miss."""
SEARCH = "contact_search"
"""Key of [simulator] that only known numbers have: an identified radius is the one that rolls."""
HEIGHT_OVER_TRACK = 0.38
BOUNDS = {n.name: (n.lower, n.upper, n.unit) for n in NUMBERS}


@dataclass(frozen=True)
class Known:
    """Numbers of a vehicle that are given.

    name; numbers: of the vehicle itself; effects: of declared effects, as in a vehicle file; stated: standard deviations that the
    file states in its table [uncertainty]; file: where it comes from; simulator: as in a vehicle file, of a simulated soil;
    steering: map of the steering; search: how far below a wheel the simulated soil's contact search finds it (m): its wheels roll
    as if their radius were larger by as much; driveline: as in a vehicle file; early: group of channels -> by how much (s) it
    seems early in every log; other_ground: whether the soil is taken for one that shears anew in ruts.
    """

    name: str
    numbers: dict[str, float]
    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    stated: dict[str, float] = field(default_factory=dict)
    file: str = ""
    simulator: dict[str, float] = field(default_factory=dict)
    steering: SteeringMap | None = None
    search: float = 0.0
    driveline: dict[str, float] = field(default_factory=dict)
    early: dict[str, float] = field(default_factory=dict)
    other_ground: bool = False

    def __getitem__(self, name: str) -> float:
        """A number that every known vehicle has."""
        return self.numbers[name]

    @property
    def wheelbase(self) -> float:
        """l_f + l_r (m)."""
        return self.numbers["l_f"] + self.numbers["l_r"]

    @property
    def swing(self) -> float:
        """mass l_f l_r (kg m^2), near which yaw inertias are."""
        return self.numbers["mass"] * self.numbers["l_f"] * self.numbers["l_r"]

    @property
    def guess_h_cg(self) -> float:
        """Height of the centre of gravity (m): as given, or from the track."""
        return self.numbers.get("h_cg", HEIGHT_OVER_TRACK * self.numbers["track"])

    def value(self, name: str) -> float | None:
        """The number or the effect's parameter called `name`; None where it is not given."""
        if name in self.numbers or name in self.simulator:
            return self.numbers.get(name, self.simulator.get(name))
        return next((table[name] for table in self.effects.values() if name in table), None)

    def other_effects(self, names: set[str]) -> dict[str, dict[str, float]]:
        """Parameters of declared effects that are not among `names`."""
        left = {key: {k: v for k, v in table.items() if k not in names} for key, table in self.effects.items()}
        return {key: table for key, table in left.items() if table or not self.effects[key]}

    def rest(self, names: set[str]) -> dict[str, float]:
        """Numbers of the vehicle that are not among `names`."""
        return {key: value for key, value in self.numbers.items() if key not in names}

    def without(self, *names: str) -> Known:
        """The same without the numbers called `names`: as if nobody had given them."""
        numbers = {key: value for key, value in self.numbers.items() if key not in names}
        effects = {key: {k: v for k, v in t.items() if k not in names} for key, t in self.effects.items()}
        return replace(self, numbers=numbers, effects=effects)

    def with_numbers(self, **values: float) -> Known:
        """The same with other numbers, by name."""
        return replace(self, numbers={**self.numbers, **values})


def load_known(path: str | Path) -> Known:
    """The known numbers of a vehicle from a TOML file: keys of a vehicle file, or wheelbase, load_front and load_rear (of the
    axles, in one unit) in the place of l_f and l_r.

    Raises ValueError naming the file, the key, what was expected and what was found.
    """
    path = Path(path)
    table = read_toml(path, "vehicle")
    return known_from_table(table_inside(table, "vehicle", KEYS, str(path)), str(path), path.stem)


def as_known(known: Known | Mapping[str, Any] | str | Path) -> Known:
    """Known numbers from themselves, from a table as a vehicle file has it, or from a file; ValueError as `load_known`."""
    if isinstance(known, Known):
        return known
    return load_known(known) if isinstance(known, str | Path) else known_from_table(dict(known), "known", "vehicle")


def known_from_table(table: dict[str, Any], where: str, name: str) -> Known:
    """Known numbers from a parsed TOML table; ValueError naming `where`, the key, what was expected and what was found."""
    for key in table:
        if key not in KEYS:
            raise ValueError(f"{where}: expected keys {', '.join(sorted(KEYS))}; found {key!r}")
    numbers = {
        key: finite(value, f"{where}: key {key!r}") for key, value in table.items() if key in BOUNDS or key in LOADS
    }
    if "load_front" in numbers and "load_rear" in numbers:
        front, rear = numbers["load_front"], numbers["load_rear"]
        if not (front > 0 and rear > 0):
            raise ValueError(f"{where}: expected positive axle loads, found {front:g} and {rear:g}")
        mass = numbers.get("mass", 0.0)
        if mass > 0 and all(abs((front + rear) / (mass * unit) - 1.0) > WEIGHED for unit in UNITS.values()):
            raise ValueError(
                f"{where}: expected load_front and load_rear that make up the mass of {mass:g} kg, in "
                f"{', '.join(UNITS)}; found {front:g} and {rear:g}, {front + rear:g} together"
            )
        share = rear / (front + rear)
        if {"l_f", "l_r"} <= numbers.keys() and abs(numbers["l_f"] / (numbers["l_f"] + numbers["l_r"]) - share) > WEIGHED:
            raise ValueError(
                f"{where}: expected l_f and l_r as the axle loads have them, l_f {100 * share:.1f} % of the wheelbase; found "
                f"{numbers['l_f']:g} and {numbers['l_r']:g} m"
            )
        if "wheelbase" in numbers:
            numbers.setdefault("l_f", numbers["wheelbase"] * rear / (front + rear))
            numbers.setdefault("l_r", numbers["wheelbase"] * front / (front + rear))
    for key in NEEDED:
        if key not in numbers:
            beside = " (or wheelbase, load_front and load_rear)" if key in ("l_f", "l_r") else ""
            raise ValueError(f"{where}: expected key {key!r}{beside}, found {', '.join(table) or 'none'}")
    together = numbers["l_f"] + numbers["l_r"]
    if "wheelbase" in numbers and not abs(numbers["wheelbase"] - together) <= TAPED * abs(together):
        raise ValueError(f"{where}: expected l_f + l_r to be the wheelbase of {numbers['wheelbase']:g} m, found {together:g} m")
    for key in LOADS:
        numbers.pop(key, None)
    for key, value in numbers.items():
        lower, upper, unit = BOUNDS[key]
        if not lower <= value <= upper:
            raise ValueError(f"{where}: expected {key} in [{lower:g}, {upper:g}] {unit}, found {value:g}")
    declared = table.get("effects", {})
    if not isinstance(declared, dict):
        raise ValueError(f"{where}: expected a table [effects], found {declared!r}")
    effects = {effect: number_table(declared, effect, f"{where}: effects") for effect in declared}
    there = {*numbers, *(key for values in effects.values() for key in values)}
    stated = number_table(table, "uncertainty", where, dict.fromkeys(sorted(there), (1e-12, 1e12)))
    simulator = number_table(table, "simulator", where)
    search = simulator.pop(SEARCH, 0.0)
    if not 0.0 <= search <= numbers["radius"] / 10:
        raise ValueError(f"{where}: simulator.{SEARCH}: expected 0 to a tenth of the radius (m), found {search:g}")
    for key in simulator:
        if key not in SIMULATOR:
            raise ValueError(f"{where}: simulator: expected keys {', '.join((*SIMULATOR.names, SEARCH))}; found {key!r}")
    steering = steering_from_table(table.get("steering", {}), where)
    driveline = number_table(table, "driveline", where, {s.name: (s.lower, s.upper) for s in DRIVELINE})
    return Known(str(table.get("name", name)), numbers, effects, stated, where, simulator, steering, search, driveline)
