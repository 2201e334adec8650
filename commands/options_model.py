"""Options that say what is modelled: read without the libraries that model it, so that a command starts at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from softsoil.commands.output import console
from softsoil.files.identify_verdict import IDENTIFIED
from softsoil.files.package_data import REFERENCE_VEHICLE, VEHICLE_NAMES, source_name, vehicle_file
from softsoil.files.toml_file import read_toml, table_inside
from softsoil.recording.log_names import named_soil
from softsoil.symbolic.soil import SOILS, Soil, load_soil
from softsoil.symbolic.vehicle import KEYS, NUMBERS, Vehicle, load_vehicle, vehicle_from_table
from softsoil.symbolic.wheel import law_names

if TYPE_CHECKING:
    from softsoil.declaration.model_file import Declaration



def _not_none(workers: int) -> int:
    if workers == 0:
        raise typer.BadParameter("expected a number of processes, or -1 for one per core; found 0")
    return workers


WorkersOption = Annotated[
    int, typer.Option("--workers", callback=_not_none, help="Processes on this machine (-1: one per core).")
]
VehicleOption = Annotated[
    Path | None,
    typer.Option(
        "--vehicle", help=f"{', '.join(VEHICLE_NAMES)} (default: reference), or a vehicle TOML.", show_default=False
    ),
]
SoilOption = Annotated[
    str | None,
    typer.Option("--soil", help=f"{', '.join(SOILS)}, or a soil TOML.", show_default=False),
]
SoilsOption = Annotated[
    list[str] | None,
    typer.Option("--soil", help=f"{', '.join(SOILS)}, or a soil TOML: one for all, or one per log.", show_default=False),
]
DEFAULT_LAW = "turn_slip"
LawOption = Annotated[
    str | None, typer.Option("--law", help=f"Force law: {', '.join(law_names())}.", show_default=DEFAULT_LAW)
]
ModelOption = Annotated[
    Path | None,
    typer.Option(
        "--model", help="refined.toml: vehicle, soil, law and effects in one, in their place.", show_default=False
    ),
]
OutOption = Annotated[
    Path | None, typer.Option("--out", help="Folder to write in (default: runs/<command>).", show_default=False)
]


def declared_vehicle(vehicle: Path | None, model: Path | None) -> Vehicle:
    """The vehicle that the options declare, by itself: of `model`, of `vehicle`, or the reference vehicle."""
    if model is not None and vehicle is None:
        table = read_toml(model, "model")
        if "vehicle" not in table:
            raise ValueError(f"{model}: expected a table [vehicle], found none")
        return vehicle_from_table(table_inside(table, "vehicle", KEYS, str(model)), str(model), model.stem)
    return load_vehicle(vehicle or REFERENCE_VEHICLE)


def measured_vehicle(vehicle: Path | None) -> Vehicle:
    """The vehicle whose axles, wheels and steering a log is brought in with: a vehicle file's, or, before there is one, that of
    the known numbers that `softsoil identify` starts from."""
    path = vehicle_file(vehicle or REFERENCE_VEHICLE)
    table = table_inside(read_toml(path, "vehicle"), "vehicle", KEYS, str(path))
    if all(n.default is not None or n.name in table for n in NUMBERS):
        return load_vehicle(path)
    from softsoil.refinement.known_vehicle import load_known
    from softsoil.refinement.vehicle_numbers import declared_vehicle as of_known

    return of_known(load_known(path))


def say_vehicle(vehicle: Path | None, model: Path | None = None, default: Path | None = None) -> str:
    """Say, as a command's first line, which vehicle is taken where neither --vehicle nor --model names one: `default`, or the
    reference vehicle; and of one that is named that `softsoil identify` said not to use it yet; returns the line."""
    if vehicle is not None or model is not None:
        try:
            verdict = declared_vehicle(vehicle, model).verdict
        except ValueError:  # whatever is wrong, the command says it where it takes the file
            return ""
        if verdict in ("", IDENTIFIED):
            return ""
        words = f"warning: {vehicle or model}: identify said {verdict!r} of this vehicle: not to be used yet"
        console.print(words, style="yellow", highlight=False, soft_wrap=True)
        return words
    words = f"vehicle: {declared_vehicle(default, None).name}, since --vehicle names none"
    console.print(words, highlight=False)
    return words


def declaration(vehicle: Path | None, soil: str | None, law: str | None, model: Path | None) -> Declaration:
    """What the options declare: `model` alone, or vehicle, soil and law.

    Raises ValueError for a soil, vehicle or law beside a model, or for neither soil nor model; hard ground needs no soil.
    """
    from softsoil.declaration.ground import HARD_GROUND
    from softsoil.declaration.model_file import Declaration, load_declaration

    if model is not None:
        refuse_beside_model(("--soil", soil), ("--vehicle", vehicle), ("--law", law))
        declared = load_declaration(model)
        _trusted(declared.soil)
        return noted(declared)
    law = law or DEFAULT_LAW
    hard = Declaration(load_vehicle(vehicle or REFERENCE_VEHICLE), HARD_GROUND, law)
    if soil is None and hard.sinks:
        raise ValueError(f"--soil: expected one of {', '.join(SOILS)} or a TOML file (or --model), found none")
    return noted(hard if soil is None else Declaration(hard.vehicle, ground_of(soil, not hard.sinks), law))


def refuse_beside_model(*options: tuple[str, object]) -> None:
    """Raise ValueError for one of the options (name, value) that is given beside --model, which declares it."""
    for option, value in options:
        if value is not None:
            raise ValueError(f"{option}: expected none beside --model, which declares it; found {str(value)!r}")


def soils_of(given: list[str] | None, names: Sequence[str], more: str = "", hard: bool = False) -> list[Soil]:
    """One soil per log: the one given, one each in order, or those that the logs' names say.

    more: words on the order for the message; hard: whether nothing sinks with the force law.
    Raises ValueError for another number of soils than of logs, or a log whose name tells none.
    """
    if given is None:
        for name in names:
            if named_soil(name) is None:
                raise ValueError(f"--soil: expected one of {', '.join(SOILS)} or a TOML file (or --model); {name} names none")
        return [load_soil(str(named_soil(name))) for name in names]
    if len(given) == 1:
        return [ground_of(given[0], hard)] * len(names)
    if len(given) == len(names):
        return [ground_of(soil, hard) for soil in given]
    raise ValueError(f"--soil: expected one for all or one per log ({len(names)}{more}), found {len(given)}")


def ground_of(source: str, hard: bool) -> Soil:
    """A soil by name or from a file, warned of where `softsoil soil` said not to use it; hard: whether nothing sinks."""
    from softsoil.declaration.ground import load_ground

    return _trusted(load_ground(source, hard))


def _trusted(soil: Soil) -> Soil:
    for words in _of_soil(soil):
        _say_once(words)
    return soil


def _of_soil(soil: Soil) -> list[str]:
    if soil.verdict in ("", IDENTIFIED):
        return []
    return [f"warning: soil {soil.name}: softsoil soil said {soil.verdict!r} of its file: not to be used yet"]


def about_vehicle(vehicle: Path | None, model: Path | None = None) -> dict[str, str]:
    """Name and file of the vehicle that a result rests on, from the options that name it."""
    if model is not None:
        from softsoil.declaration.model_file import load_declaration

        return {"name": load_declaration(model).vehicle.name, "file": str(model)}
    path = vehicle_file(vehicle or REFERENCE_VEHICLE)
    return {"name": load_vehicle(path).name, "file": source_name(path)}


def noted(declared: Declaration) -> Declaration:
    """The declaration, after a line on the vehicle's numbers that do nothing in its model, where there are any."""
    for words in _of_vehicle(declared):
        _say_once(words)
    return declared


def _of_vehicle(declared: Declaration) -> list[str]:
    from softsoil.codegen.idle import idle_numbers

    idle = idle_numbers(declared)
    return [f"note: vehicle {declared.vehicle.name}: no declared effect uses {', '.join(idle)}"] if idle else []


def said_of(declared: Declaration) -> list[str]:
    """What `declaration` said on stderr of what it declares."""
    return _of_soil(declared.soil) + _of_vehicle(declared)


@lru_cache(maxsize=32)
def _say_once(words: str) -> None:
    """A line on stderr, once however many logs a command goes through."""
    typer.echo(words, err=True)
