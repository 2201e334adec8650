"""Tables of reference: vehicle numbers, soils, log channels, and the names of the Python interface."""

from __future__ import annotations

import re
from pathlib import Path

import softsoil
from benchmarks.guide.markdown import code, number, table, unit_of
from softsoil.files.package_data import VEHICLE_NAMES, vehicle_file
from softsoil.recording.drive import CHANNEL_UNITS
from softsoil.refinement.known_vehicle import SEARCH
from softsoil.symbolic.soil import SOIL_SIGNALS, SOILS
from softsoil.symbolic.vehicle import NUMBERS, SIMULATOR, load_vehicle

PROJECT = Path(__file__).resolve().parents[2]


def vehicle_reference() -> str:
    """Every number of a vehicle file: unit, meaning, measurement, bounds, default, and the values of the built-in vehicles."""
    vehicles = [load_vehicle(vehicle_file(name)) for name in VEHICLE_NAMES]
    rows = []
    for n in NUMBERS:
        default = "must be given" if n.default is None else number(n.default)
        prior = " + ".join(filter(None, (number(n.spread) if n.spread else "", f"{100 * n.share:g} %" if n.share else "")))
        bounds = f"{number(n.lower)} to {number(n.upper)}"
        rows.append((code(n.name), unit_of(n.unit), n.doc, n.measured, bounds, default, prior))
    head = ("key", "unit", "what it is", "measured by", "bounds", "default", "std of a first guess")
    values = [(code(n.name), unit_of(n.unit), *(number(getattr(vehicle, n.name)) for vehicle in vehicles)) for n in NUMBERS]
    effects = [
        (name, ", ".join(f"[{e.replace('_', ' ')}](effects.md#{e})" for e in vehicle.effects) or "none")
        for name, vehicle in zip(VEHICLE_NAMES, vehicles, strict=True)
    ]
    simulator = [(code(s.name), unit_of(s.unit), s.doc, number(s.nominal)) for s in SIMULATOR]
    simulator.append((code(SEARCH), "m", "how far below a wheel its contact search finds it; in known numbers", "0"))
    return (
        table(head, rows)
        + "\n\n## The built-in vehicles\n\n"
        + table(("key", "unit", *VEHICLE_NAMES), values)
        + "\n\n## Effects that the built-in vehicles declare\n\nA table `[effects.<name>]` in the file.\n\n"
        + table(("vehicle", "declared effects"), effects)
        + "\n\n## A simulated soil\n\nThe table `[simulator]`, for logs of a simulated soil only; a real soil has none.\n\n"
        + table(("key", "unit", "what it is", "default"), simulator)
        + "\n"
    )


def soils_reference() -> str:
    """The built-in soils and the keys of a soil file."""
    rows = []
    for s in SOIL_SIGNALS:
        values = [number(float(getattr(soil, s.name))) for soil in SOILS.values()]
        rows.append((code(s.name), unit_of(s.unit), s.doc, f"{number(s.lower)} to {number(s.upper)}", *values))
    return table(("key", "unit", "what it is", "bounds", *SOILS), rows) + "\n"


def channels_reference() -> str:
    """The channels of a log: unit, meaning (the table of data/README.md).

    Raises ValueError for a channel without a meaning there.
    """
    meanings = _channel_meanings()
    absent = [name for name in CHANNEL_UNITS if name not in meanings]
    if absent:
        raise ValueError(f"data/README.md: expected a row for each channel, found none for {', '.join(absent)}")
    rows = [(code(name), unit_of(unit), meanings[name]) for name, unit in CHANNEL_UNITS.items()]
    return table(("channel", "unit", "what it is"), rows) + "\n"


def _channel_meanings() -> dict[str, str]:
    """Channel -> meaning, from the rows of data/README.md that name columns."""
    found: dict[str, str] = {}
    for row in re.findall(r"^\| (`.*?) \|.*?\| (.*?) \|$", (PROJECT / "data" / "README.md").read_text(encoding="utf-8"), re.M):
        found |= dict.fromkeys(re.findall(r"`(\w+)`", row[0]), row[1])
    return found


def python_reference() -> str:
    """The public names, each documented from its own docstring."""
    names = [name for name in softsoil.__all__ if not name.startswith("_")]
    order = sorted(names, key=lambda name: (name[0].isupper(), name))
    return "\n".join(f"::: softsoil.{name}\n" for name in order)
