"""`softsoil identify`: the numbers of a vehicle from its own logs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from softsoil.commands.identify_summary import say
from softsoil.commands.invocation import software
from softsoil.commands.options import ColumnsOption, NoiseOption, SeedOption, SkipOption, open_drive
from softsoil.commands.options_model import OutOption, SoilsOption, soils_of
from softsoil.commands.output import output_folder, progress, say_written, write_result
from softsoil.estimator.horizons import START_UP
from softsoil.figures.identify_report import write_report
from softsoil.identification.identify import identify
from softsoil.identification.vehicle_toml import vehicle_toml
from softsoil.refinement.known_vehicle import load_known
from softsoil.refinement.vehicle_numbers import declared_vehicle


def identify_command(
    logs: Annotated[
        list[Path],
        typer.Argument(help="Two drives or more: CSV, CSV.gz or Parquet; the last judges.", show_default=False),
    ],
    vehicle: Annotated[
        Path, typer.Option("--vehicle", help="TOML with the numbers that have been measured.", show_default=False)
    ],
    soil: SoilsOption = None,
    judge: Annotated[
        Path | None, typer.Option("--judge", help="The log that is left out and judges (default: the last).", show_default=False)
    ] = None,
    columns: ColumnsOption = None,
    noise: NoiseOption = "none",
    seed: SeedOption = 0,
    skip: SkipOption = START_UP,
    out: OutOption = None,
) -> None:
    """The numbers of a new vehicle from its own logs: a scale and a tape give the few that are known, logs the rest.

    Each drive keeps its own n, which is unknown. One log is left out of every fit and judges. Only sensor channels are read.

    Example: softsoil identify lock.csv multi.csv other.csv --vehicle known.toml --soil clay --soil sandy_loam --soil clay
    """
    paths, judged = _judged(logs, judge)
    folder = output_folder(out, "identify", ("identify.json", "vehicle.toml", "report.html"))
    known = load_known(vehicle)
    geometry = declared_vehicle(known)
    drives = [open_drive(path, columns, noise, seed + 10 * i, geometry=geometry)[1] for i, path in enumerate(paths)]
    soils = soils_of(soil, [drive.name for drive in drives], ", --judge last")
    with progress(", ".join(drive.name for drive in drives)) as told:
        found = identify(drives, soils, known, judged, start=skip, progress=told)
    say(found)
    toml = folder / "vehicle.toml"
    toml.write_text(vehicle_toml(found), encoding="utf-8")
    about = {"name": known.name, "file": str(vehicle)}
    result = write_result(folder / "identify.json", found.as_json(), about)
    report = write_report(found, folder / "report.html", {"software": software(), "vehicle": about})
    say_written([result, toml, report])


def _judged(logs: list[Path], judge: Path | None) -> tuple[list[Path], int]:
    """All logs, and which of them judges: the last, or `judge`, which may stand among the logs or beside them."""
    where = [path.resolve() for path in logs]
    if judge is None:
        paths, judged = logs, len(logs) - 1
    elif judge.resolve() in where:
        paths, judged = logs, where.index(judge.resolve())
    else:
        paths, judged = [*logs, judge], len(logs)
    if len(paths) < 2:
        raise ValueError(f"identify: expected two logs or more, one of which judges; found {len(paths)}")
    if len({*where}) < len(where):  # with --noise their rows would differ
        raise ValueError("identify: expected different logs, found one twice: a log that is fitted cannot judge")
    return paths, judged
