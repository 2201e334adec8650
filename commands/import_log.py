"""`softsoil import`: bags and tables of any rate become one drive, with checks of every channel against the others."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from softsoil.checking.cross_check import refuse_contradictions
from softsoil.checking.words import Check
from softsoil.commands.import_steering import fitted_map, say_map, steered, without_command
from softsoil.commands.invocation import software
from softsoil.commands.options_model import OutOption, measured_vehicle, say_vehicle
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.declaration.late_steering import late_steering
from softsoil.figures.import_report import write_import_report
from softsoil.files.package_data import REFERENCE_VEHICLE, VEHICLE_NAMES, source_name, vehicle_file
from softsoil.importing.bring_in import Import, bring_in, inspect_sources, read_sources, shifted_with
from softsoil.importing.draft_map import draft
from softsoil.importing.hanging import hangs
from softsoil.importing.import_map import STEER_COMMAND, ImportMap, load_map, map_from_table
from softsoil.importing.merge import LEAST
from softsoil.recording.read import IMPORTED, write_drive

MOST_NAMED = 12
"""Fields that the message names where a needed channel is not recognised."""


def import_log(
    sources: Annotated[
        list[Path], typer.Argument(metavar="SOURCE...", help="Bags (file or folder) and tables.", show_default=False)
    ],
    map_file: Annotated[
        Path | None,
        typer.Option(
            "--map", help="Map TOML (default: standard messages and names, as inspect drafts it).", show_default=False
        ),
    ] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option(
            "--vehicle",
            help=f"{', '.join(VEHICLE_NAMES)} (default: reference), a vehicle TOML, or the known numbers that identify takes.",
            show_default=False,
        ),
    ] = None,
    align: Annotated[bool, typer.Option("--align", help="Shift each source's clock by its estimated offset.")] = False,
    out: OutOption = None,
) -> None:
    """Bags and tables become one drive on one clock; absent channels are derived and marked, all are checked.

    A channel that contradicts the others beyond doubt ends the import: nothing is written. `steer_command` in the map, a command
    or the steering wheel's angle, becomes `steer` by the vehicle's steering map, or is fitted to `steer` where a log has both.

    Example: softsoil import my_bag/ gps.csv --map runs/my_log/map.toml --align
    """
    folder = output_folder(out, "import", ("import.json", IMPORTED, "report.html", "steering.toml"))
    say_vehicle(vehicle)
    geometry = measured_vehicle(vehicle)
    with progress(", ".join(path.name for path in sources)) as told:
        plan = load_map(map_file) if map_file is not None else drafted(sources)
        plan = steered(plan, geometry)
        series = read_sources(sources, plan, told)
        steering = fitted_map(plan, series)
        found = bring_in(_name(sources), without_command(plan), series, geometry, align, late_steering(geometry))
    _say(found, plan)
    refuse_contradictions(str(_source_of(found.checks, plan, sources)), found.checks)
    drive = write_drive(found.drive, folder / IMPORTED, named=True)
    content = found.as_json()
    written = [drive]
    if steering is not None:
        content["steering"] = say_map(steering)
        written.append(folder / "steering.toml")
        written[-1].write_text("\n".join(steering.map.toml()) + "\n", encoding="utf-8")
    about = {"name": geometry.name, "file": source_name(vehicle_file(vehicle or REFERENCE_VEHICLE))}
    written.append(write_result(folder / "import.json", content, about))
    report = write_import_report(found, folder / "report.html", {"software": software(), "vehicle": about})
    say_written([*written, report])


def drafted(sources: list[Path]) -> ImportMap:
    """The map that inspect would draft for the sources."""
    import tomllib

    holdings = inspect_sources(sources)
    entries = tomllib.loads(draft(holdings))
    named = entries["channels"]
    lacking = [c for c in LEAST if c not in named and not (c == "steer" and STEER_COMMAND in named)]
    if lacking:
        fields = [f"{h.name}:{field}" for h in holdings for field in h.fields]
        more = f" and {len(fields) - MOST_NAMED} more" if len(fields) > MOST_NAMED else ""
        raise ValueError(
            f"{sources[0]}: expected fields recognised as {', '.join(LEAST)}; found none for {', '.join(lacking)} among "
            f"{', '.join(fields[:MOST_NAMED])}{more}: `softsoil inspect` drafts a map to name them in, for --map"
        )
    for holding in holdings:
        if hangs(holding):
            told = f"{holding.name}: taken as a sensor with z down (x ahead, y right), by the gravity that it reads"
            console.print(told, highlight=False, soft_wrap=True)
    return map_from_table(entries, "map drafted from the sources")


def _name(sources: Sequence[Path]) -> str:
    """Of the drive: that of a folder, of a file without its endings, or of the folder that holds the files of several devices."""
    first, folders = sources[0], {source.resolve().parent for source in sources}
    if first.is_dir():
        return first.resolve().name
    folder = folders.pop().name if len(sources) > 1 and len(folders) == 1 and folders != {Path.cwd()} else ""
    if folder:
        return folder
    return Path(first.name.removesuffix(".gz")).stem


def _source_of(checks: Sequence[Check], plan: ImportMap, sources: Sequence[Path]) -> Path:
    """The file that holds the first channel that is contradicted; the first file where none is, or a bag holds it."""
    names = (check.channel.split(",")[0] for check in checks if not check.passed and check.beyond_doubt)
    origin = plan.channels.get(next(names, ""))
    return next((path for path in sources if origin is not None and path.name == origin.source), sources[0])


def _say(found: Import, plan: ImportMap) -> None:
    console.print(channel_table(found))
    for note in found.merged.recording.notes:
        console.print(f"note: {note}", highlight=False, soft_wrap=True)
    for offset in found.offsets:
        words = f"{abs(offset.late_s):.3f} ± {offset.std:.3f} s {'late' if offset.late_s > 0 else 'early'}"
        console.print(f"clock of {offset.group}: {words} against the {offset.against}, correlation {offset.before:.3f} -> "
                      f"{offset.after:.3f}", highlight=False)  # fmt: skip
    for source, shift in found.shifts.items():
        console.print(f"{source}: clock shifted by {shift:+.3f} s", highlight=False)
        if shift and (others := shifted_with(plan, source, found.offsets)):
            console.print(f"{source}: shifted with it, not compared: {', '.join(others)}; where these are in time, put late = "
                          f"{-shift:.3f} at the channel that is late, in the map, in the place of --align",
                          highlight=False, soft_wrap=True)  # fmt: skip
    for check in found.checks:
        if not check.passed:
            style = "red" if check.beyond_doubt else "yellow"
            console.print(f"{'contradiction' if check.beyond_doubt else 'warning'}: {check.sentence()}", style=style,
                          highlight=False, soft_wrap=True)  # fmt: skip
    passed = sum(check.passed for check in found.checks)
    console.print(f"{passed} of {len(found.checks)} checks passed", highlight=False)


def channel_table(found: Import) -> Table:
    """One row per channel: state, origin, rate, gaps."""
    table = Table(title=f"{len(found.drive)} rows at {1 / found.drive.dt:.4g} Hz", title_justify="left")
    for heading in ("channel", "state", "source", "Hz", "gaps"):
        table.add_column(heading, justify="right" if heading in ("Hz", "gaps") else "left", overflow="fold")
    for name, entry in found.as_json()["channels"].items():
        rate = "" if entry["rate_hz"] is None else f"{entry['rate_hz']:.4g}"
        table.add_row(name, entry["state"], entry["source"], rate, "" if entry["gaps"] is None else str(entry["gaps"]))
    return table
