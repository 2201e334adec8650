"""One declaration of a model: vehicle, soil, force law and effects, to and from TOML."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

from softsoil.files.toml_file import read_toml
from softsoil.symbolic.catalogue import declared_model
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Signal
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil, soil_from_table
from softsoil.symbolic.vehicle import Vehicle, vehicle_from_table
from softsoil.symbolic.wheel import law_names


@dataclass(frozen=True)
class Declaration:
    """vehicle (with its declared effects), soil and name of the force law: what a model is made of.
    Example: softsoil.load_declaration("refined.toml").with_n(0.9).build().p["n_f"].nominal == 0.9
    """

    vehicle: Vehicle
    soil: Soil
    law: str = "turn_slip"

    def build(self) -> Model:
        """The model with its declared effects."""
        return declared_model(self.vehicle, self.soil, self.law)

    def plain(self) -> Model:
        """The model without effects: the paper's structure."""
        return declared_model(self.vehicle, self.soil, self.law, {})

    def with_effects(self, effects: Mapping[str, Mapping[str, float]]) -> Declaration:
        """The declaration with more effects, or with other parameters of those it has."""
        merged = {**self.vehicle.effects, **{name: dict(values) for name, values in effects.items()}}
        return Declaration(self.vehicle.with_(effects=merged), self.soil, self.law)

    def with_n(self, n: float) -> Declaration:
        """The declaration on a soil with another sinkage exponent n."""
        return Declaration(self.vehicle, self.soil.with_(n=n), self.law)


def load_declaration(path: str | Path) -> Declaration:
    """A declaration from a TOML file with tables [vehicle] (and [vehicle.effects.<name>]), [soil] and `law`.

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
    vehicle = vehicle_from_table(table["vehicle"], str(path), path.stem)
    return Declaration(vehicle, soil_from_table(table["soil"], str(path), "soil"), law)


def declaration_toml(declaration: Declaration, notes: tuple[str, ...] = ()) -> str:
    """The declaration as TOML text, `notes` as comments on top; `load_declaration` reads it back.
    Example: "[soil]" in softsoil.declaration_toml(softsoil.load_declaration("refined.toml"))
    """
    lines = [f"# {note}" for note in notes] + [f'law = "{declaration.law}"', "", "[vehicle]"]
    lines.append(f"name = {_text(declaration.vehicle.name)}")
    for f in fields(Vehicle):
        value = getattr(declaration.vehicle, f.name)
        if isinstance(value, int | float):
            lines.append(f"{f.name} = {_number(value)}")
    for name, values in declaration.vehicle.effects.items():
        lines += ["", f"[vehicle.effects.{name}]", *(f"{key} = {_number(value)}" for key, value in values.items())]
    if declaration.vehicle.uncertainty:
        lines += ["", "[vehicle.uncertainty]"]
        lines += [f"{key} = {_number(value)}" for key, value in declaration.vehicle.uncertainty.items()]
    lines += ["", "[soil]", f"name = {_text(declaration.soil.name)}"]
    for signal in SOIL_SIGNALS:
        lines.append(f"{signal.name} = {_number(getattr(declaration.soil, signal.name))}{_comment(signal)}")
    return "\n".join(lines) + "\n"


def _comment(signal: Signal) -> str:
    return f"  # {signal.unit}" if signal.unit else ""


def _number(value: float) -> str:
    return repr(float(value))


def _text(value: str) -> str:
    escaped = "".join(c if c.isprintable() and c not in '"\\' else f"\\u{ord(c):04x}" for c in value)
    return f'"{escaped}"'
