"""`softsoil map`: the soil along the way, fused over drives."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from typing import Annotated

import typer
from joblib import Parallel, delayed, effective_n_jobs

from softsoil.commands.options import ColumnsOption, SkipOption, open_drive
from softsoil.commands.options_model import (
    LawOption,
    ModelOption,
    OutOption,
    SoilOption,
    VehicleOption,
    WorkersOption,
    about_vehicle,
    declaration,
    say_vehicle,
)
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.commands.vehicle_check import refuse_another
from softsoil.declaration.ground import refuse_hard_ground
from softsoil.estimator.horizons import START_UP
from softsoil.estimator.moving_horizon import HorizonRules
from softsoil.figures.labels import plain
from softsoil.figures.soil_map import draw_soil_map
from softsoil.mapping.cells import Cell
from softsoil.mapping.drive_soil import DriveSoil, unusable
from softsoil.mapping.frame import frame_of, placed
from softsoil.mapping.map_file import as_json
from softsoil.mapping.soil_map import laid, surveyed
from softsoil.recording.log_names import distinct, log_name
from softsoil.symbolic.model import Model

SPOKEN_OF = 0.01
"""Share of a drive from which what keeps windows from it is said."""


def map_soil(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG ...", help="Drives over one piece of ground.", show_default=False)],
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = None,
    model: ModelOption = None,
    cell: Annotated[float, typer.Option("--cell", min=0.1, help="Size of a cell, m.")] = 10.0,
    everything: Annotated[
        bool, typer.Option("--all", help="Also drives whose verdict is not identified or not_excited.")
    ] = False,
    columns: ColumnsOption = None,
    skip: SkipOption = START_UP,
    origin: Annotated[
        tuple[float, float] | None,
        typer.Option("--origin", metavar="LAT LON", help="Latitude and longitude (deg) of the map's x = y = 0, as of a map that "
                     "this one is to share its cells with; default: of the log with most others near it.", show_default=False),
    ] = None,
    workers: WorkersOption = 1,
    out: OutOption = None,
) -> None:
    """Map n and its standard deviation along the way, per cell of the ground, fused over drives.

    A drive that says too little (not_excited) adds what little it says; one that contradicts the model, or whose place is not
    known, is left out. Every cell has a verdict: use n where it is identified. map.json is GeoJSON in longitude and latitude
    where an import made the positions of fixes, otherwise in metres of the logs' own frame.

    Example: softsoil map data/multi_clay_n0.50.parquet data/paper_clay_n0.50.csv.gz --soil clay
    """
    folder = output_folder(out, "map", ("map.json", "map.png"))
    say_vehicle(vehicle, model)
    declared = declaration(vehicle, soil, law, model)
    built, n0 = declared.build(), float(declared.soil.n)
    refuse_hard_ground(built)
    drives, refused = [], []
    for log in logs:
        name = log_name(log)
        try:
            drive = open_drive(log, columns, vehicle=vehicle, model=model)[1]
            name = drive.name
            refuse_another(drive, declared.vehicle)
            drives.append(drive)
        except ValueError as error:
            if not (log.is_file() and logs[1:]):
                raise
            alike = name == log_name(log) and sum(log_name(other) == name for other in logs) > 1
            where = f" ({log.resolve().parent.name})" if alike else ""
            refused.append(unusable(f"{name}{where}", str(error)))
    drives = distinct(drives)
    if not drives:
        raise ValueError("; ".join(f"{one.log}: {one.left_out}" for one in refused))
    frame = frame_of(drives, origin)
    whys = placed(drives, frame, cell)
    with progress(f"{len(drives)} drive{'s' if drives[1:] else ''}"):
        each = list(zip(drives, whys, strict=True))
        if (share := min(effective_n_jobs(workers), len(each))) == 1:
            found = _surveyed(each, built, n0, skip)
        else:
            parts = [range(k, len(each), share) for k in range(share)]
            tasks = (delayed(_surveyed)([each[i] for i in part], declared, n0, skip) for part in parts)
            done = Parallel(n_jobs=share)(tasks)
            by_drive = {i: one for part, some in zip(parts, done, strict=True) for i, one in zip(part, some, strict=True)}
            found = [by_drive[i] for i in range(len(each))]
    ground = laid([*found, *refused], frame, cell, everything)
    for one in ground.drives:
        said = [f"left out: {one.left_out}"] if one.left_out else []
        said += [] if one.verdict is None else [f"{plain(one.verdict.word)}: {one.verdict.reason}", _covered(one)]
        console.print(f"{one.log}: {'; '.join(said)}", highlight=False)
    console.print(
        f"{len(ground.cells)} of {ground.driven} driven cells of {cell:g} m from {len(ground.used)} of {len(logs)} "
        f"drives{_range(ground.cells)}", highlight=False,
    )  # fmt: skip
    if ground.origin is not None:
        place = "latitude {:.7f}, longitude {:.7f} deg".format(*ground.origin)
        console.print(f"x east and y north of {place}", highlight=False)
    content = as_json(ground, declared.soil, declared.law)
    paths = [write_result(folder / "map.json", content, about_vehicle(vehicle, model)), draw_soil_map(ground, folder / "map.png")]
    say_written(paths)


def _covered(drive: DriveSoil) -> str:
    """In how much of a drive windows run, and why in no more of it."""
    rules = HorizonRules()
    words = {
        "steering": f"the steering is faster than {rules.fastest:g} rad/s", "speed": f"it is slower than {rules.slowest:g} m/s",
        "inputs": "inputs are missing or it runs in its own ruts",
        "position": "its position is missing for too long",
    }  # fmt: skip
    why = [words[name] for name, share in drive.blocked.items() if share > SPOKEN_OF]
    return f"windows in {100 * drive.covered:.0f} % of it" + (f", none where {', or where '.join(why)}" if why else "")


def _range(cells: tuple[Cell, ...]) -> str:
    """What the cells are, smallest and largest n of the identified ones, and how well the median of these knows it."""
    words = [c.verdict for c in cells]
    said = ", ".join(f"{words.count(word)} {plain(word)}" for word in dict.fromkeys(sorted(words)))
    good = [c for c in cells if c.verdict == "identified"]
    if not good:
        return f": {said}"
    n, share = [c.n for c in good], 100 * median(c.std / c.n for c in good)
    return f": {said}; n {min(n):.2f} to {max(n):.2f}, ± {share:.0f} % in the median identified cell"


def _surveyed(each, declared, n0: float, skip: float) -> list[DriveSoil]:
    """Several drives with one model, which a process of its own builds once of its declaration."""
    built = declared if isinstance(declared, Model) else declared.build()
    return [surveyed(drive, why, built, n0, skip) for drive, why in each]
