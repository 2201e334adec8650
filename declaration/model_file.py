"""One declaration of a model: vehicle, soil, force law and effects, to and from TOML."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from softsoil.declaration.ground import HARD_GROUND, idle, sinks
from softsoil.files.toml_file import read_toml, table_inside, toml_number, toml_text
from softsoil.symbolic.bicycle import vehicle_law
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import CLASS_NUMBERS, SOIL_SIGNALS, Soil, soil_from_table
from softsoil.symbolic.vehicle import KEYS, NUMBERS, Vehicle, vehicle_from_table
from softsoil.symbolic.wheel import ForceLaw, law_names


@dataclass(frozen=True)
class Declaration:
    """vehicle (with its declared effects), soil and name of the force law: what a model is made of. A law of your own goes to
    `softsoil.bicycle`, which takes the law itself; here, where C and TOML are made, ValueError names those that have a file.
    Example: softsoil.load_declaration("refined.toml").with_n(0.9).build().p["n_f"].nominal == 0.9
    """

    vehicle: Vehicle
    soil: Soil
    law: str = "turn_slip"

    def __post_init__(self) -> None:
        if self.law not in law_names():
            raise ValueError(f"law: expected one of {', '.join(law_names())} by its name; found {self.law!r}")

    def build(self) -> Model:
        """The model with its declared effects."""
        return bicycle(self.vehicle, self.soil, self.law)

    def plain(self) -> Model:
        """The model without effects: the paper's structure."""
        return bicycle(self.vehicle, self.soil, self.law, {})

    @property
    def sinks(self) -> bool:
        """Whether wheels sink with its force law; on hard ground n has no meaning, friction and tread are unknown instead."""
        return sinks(self.plain())

    def force_law(self) -> ForceLaw:
        """The force law with the options of the vehicle's simulated soil, where it declares one."""
        return vehicle_law(self.vehicle, self.law)

    def with_effects(self, effects: Mapping[str, Mapping[str, float]]) -> Declaration:
        """The declaration with more effects, or with other parameters of those it has."""
        merged = {**self.vehicle.effects, **{name: dict(values) for name, values in effects.items()}}
        return Declaration(self.vehicle.with_(effects=merged), self.soil, self.law)

    def with_n(self, n: float) -> Declaration:
        """The declaration on a soil with another sinkage exponent n."""
        return Declaration(self.vehicle, self.soil.with_(n=n), self.law)


def load_declaration(path: str | Path) -> Declaration:
    """A declaration from a TOML file with tables [vehicle] (and [vehicle.effects.<name>]), [soil] and `law`.

    With a law of hard ground, [soil] needs what that law uses alone: phi and k.
    Raises ValueError naming the file, the key, what was expected and what was found.
    Example: softsoil.load_declaration("refined.toml").law in ("bekker", "turn_slip")
    """
    path = Path(path)
    table = read_toml(path, "model")
    for key in ("vehicle", "soil"):
        if not isinstance(table.get(key), dict):
            raise ValueError(f"{path}: expected a table [{key}], found {', '.join(table) or 'nothing'}")
    law = table.get("law", "turn_slip")
    if law not in law_names():
        raise ValueError(f"{path}: law: expected one of {', '.join(law_names())}; found {law!r}")
    vehicle = vehicle_from_table(table_inside(table, "vehicle", KEYS, str(path)), str(path), path.stem)
    unused = {} if "n" in table["soil"] else {s: getattr(HARD_GROUND, s) for s in _unused(Declaration(vehicle, HARD_GROUND, law))}
    return Declaration(vehicle, soil_from_table({**unused, **table["soil"]}, str(path), "soil"), law)


def _unused(declaration: Declaration) -> tuple[str, ...]:
    """Parameters of the soil that a law of hard ground does not use; none of a soil's law."""
    if declaration.sinks:
        return ()
    return ("n", *idle(declaration.plain(), SOIL_SIGNALS.without("n").names))


def declaration_toml(declaration: Declaration, notes: tuple[str, ...] = ()) -> str:
    """The declaration as TOML text, `notes` as comments on top; `load_declaration` reads it back.
    Example: "[soil]" in softsoil.declaration_toml(softsoil.load_declaration("refined.toml"))
    """
    vehicle, soil = declaration.vehicle, declaration.soil
    lines = [f"# {note}" for note in notes] + [f'law = "{declaration.law}"', "", "[vehicle]", f"name = {toml_text(vehicle.name)}"]
    lines += [f"verdict = {toml_text(vehicle.verdict)}"] if vehicle.verdict else []
    lines += [_line(n.name, getattr(vehicle, n.name), f"{n.unit}: {n.doc}") for n in NUMBERS]
    tables = {"simulator": vehicle.simulator, "driveline": vehicle.driveline}
    tables |= {f"effects.{name}": values for name, values in vehicle.effects.items()}
    known = {n.name for n in NUMBERS} | {key for values in vehicle.effects.values() for key in values}
    tables |= {"uncertainty": {key: std for key, std in vehicle.uncertainty.items() if key in known}}
    tables |= {"unexplained": vehicle.unexplained}
    for name, values in tables.items():
        if values or name.startswith("effects."):
            lines += ["", f"[vehicle.{name}]", *(_line(key, value) for key, value in values.items())]
    joint = None if vehicle.joint_error is None else vehicle.joint_error.only(known)
    lines += [] if joint is None else ["", *joint.toml("vehicle.joint_error")]
    lines += [] if vehicle.steering is None else ["", *vehicle.steering.toml("vehicle.steering")]
    lines += ["", "[soil]", *_soil_lines(soil, _unused(declaration), "soil.")]
    return "\n".join(lines) + "\n"


def soil_toml(soil: Soil, notes: tuple[str, ...] = ()) -> str:
    """A soil (with the errors that it states) as TOML text, `notes` as comments on top; `load_soil` reads it back."""
    return "\n".join([*(f"# {note}" for note in notes), *_soil_lines(soil, (), "")]) + "\n"


def _soil_lines(soil: Soil, unused: tuple[str, ...], within: str) -> list[str]:
    """The soil's keys, and its errors in tables whose names begin with `within`, without what its law does not use."""
    lines = [f"name = {toml_text(soil.name)}"] + ([f"verdict = {toml_text(soil.verdict)}"] if soil.verdict else [])
    lines += [_line(s.name, getattr(soil, s.name), s.unit) for s in SOIL_SIGNALS if s.name not in unused]
    stated = [(name, std) for name, std in soil.uncertainty if name not in unused]
    lines += ["", f"[{within}uncertainty]", *(_line(name, std) for name, std in stated)] if stated else []
    joint = None if soil.joint_error is None else soil.joint_error.only({*CLASS_NUMBERS} - {*unused})
    return lines + ([] if joint is None else ["", *joint.toml(f"{within}joint_error")])


def _line(key: str, value: float, comment: str = "") -> str:
    return f"{key} = {toml_number(value)}" + (f"  # {comment}" if comment else "")
