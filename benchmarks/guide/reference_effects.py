"""The glossary of effects, from the catalogue's own declarations."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path

from benchmarks.guide.markdown import code, number, table, unit_of
from softsoil.files.package_data import REFERENCE_VEHICLE
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.signals import Signal
from softsoil.symbolic.vehicle import load_vehicle

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures" / "effects"
"""Where `python -m benchmarks.guide.signatures` writes the pictures."""
KINDS = {
    "body": "Body", "load": "Loads and forces", "sensor": "Sensors", "slope": "Slopes", "soil": "Soil", "steering": "Steering",
    "tyre": "Wheels",
}  # fmt: skip
STAGES = {
    "inputs": "the inputs", "vehicle": "the vehicle's numbers", "loads": "axle loads", "tracks": "where the wheels stand",
    "contacts": "each wheel's contact", "forces": "each wheel's force", "balance": "the sum of forces and moments",
    "rates": "the rates of the states", "outputs": "what the sensors read",
}  # fmt: skip


def effects_reference() -> str:
    """One section per effect: what it is, equation, picture of its signature, parameters, and what separates it from others."""
    known = catalogue(load_vehicle(REFERENCE_VEHICLE))
    rows = [(f"[{_plain(e.name)}](#{e.name})", e.doc, KINDS[e.kind]) for e in known.values()]
    lines = [table(("effect", "what it is", "kind"), rows), ""]
    for effect in known.values():
        lines += [_section(effect, known), ""]
    return "\n".join(lines)


def _bounds(signal: Signal) -> str:
    return f"{number(signal.lower)} to {number(signal.upper)}"


def _plain(name: str) -> str:
    return name.replace("_", " ")


def _section(effect: Effect, known: dict[str, Effect]) -> str:
    made = import_module(f"softsoil.symbolic.effects.{effect.name}").effect
    words = inspect.cleandoc(made.__doc__ or "")
    alike = [other.name for other in known.values() if effect.looks_like(other)]
    links = ", ".join(f"[{_plain(name)}](#{name})" for name in alike)
    about = [
        ("acts on", ", ".join(STAGES.get(stage, stage) for stage in effect.corrections)),
        ("source", effect.reference),
        ("signature", ", ".join(effect.signatures)),
        ("looks like", links or "no other effect of the catalogue"),
        ("separated by", effect.separates),
        ("rests on", ", ".join(code(name) for name in effect.rests_on)),
    ]
    rows = [
        (code(s.name), unit_of(s.unit), s.doc, number(s.nominal), number(effect.typical[s.name]), _bounds(s))
        for s in effect.parameters
    ]
    parts = [
        f"## {_plain(effect.name).capitalize()} {{#{effect.name}}}\n",
        f"`{effect.name}`: {effect.doc}.\n\n{words}\n",
    ]
    if (PICTURES / f"{effect.name}.png").exists():
        alt = f"Yaw rate and lateral velocity of one drive with and without {_plain(effect.name)}"
        parts.append(f"![{alt}](../pictures/effects/{effect.name}.png)\n")
    parts.append("\n".join(f"- **{name}:** {text}" for name, text in about if text) + "\n")
    parts.append(table(("parameter", "unit", "what it is", "absent at", "typical", "bounds"), rows))
    return "\n".join(parts)
