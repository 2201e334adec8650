"""`softsoil map`: the soil along the way, fused over drives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import numpy as np
import typer
from joblib import Parallel, delayed

from softsoil.commands.estimate import verdict_line
from softsoil.commands.options import ColumnsOption, SkipOption, open_drive
from softsoil.commands.options_model import (
    LawOption,
    ModelOption,
    OutOption,
    SoilOption,
    VehicleOption,
    about_vehicle,
    declaration,
    say_vehicle,
)
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.commands.vehicle_check import refuse_another
from softsoil.estimator.horizons import START_UP
from softsoil.figures.soil_map import draw_soil_map
from softsoil.importing.local_frame import latitude_longitude, other_frame
from softsoil.mapping.soil_map import Cell, DriveSoil, drive_soil, fuse
from softsoil.recording.log_names import distinct

DECIMALS = 8
"""Of degrees: a millimetre."""


def map_soil(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG ...", help="Drives over one piece of ground.", show_default=False)],
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = "turn_slip",
    model: ModelOption = None,
    cell: Annotated[float, typer.Option("--cell", min=0.1, help="Size of a cell, m.")] = 10.0,
    everything: Annotated[
        bool, typer.Option("--all", help="Also drives whose verdict is not identified or not_excited.")
    ] = False,
    columns: ColumnsOption = None,
    skip: SkipOption = START_UP,
    workers: Annotated[int, typer.Option("--workers", help="Processes (-1: one per core).")] = 1,
    out: OutOption = None,
) -> None:
    """Map n and its standard deviation along the way, per cell of the ground, fused over drives.

    A drive that says too little (not_excited) adds what little it says; one that contradicts the model is left out. map.json is
    GeoJSON in longitude and latitude where an import made the positions of fixes, otherwise in metres of the logs' own frame.

    Example: softsoil map data/multi_clay_n0.50.parquet data/paper_clay_n0.50.csv.gz --soil clay
    """
    folder = output_folder(out, "map")
    say_vehicle(vehicle, model)
    declared = declaration(vehicle, soil, law, model)
    drives = distinct([open_drive(log, columns, vehicle=vehicle, model=model)[1] for log in logs])
    for drive in drives:
        refuse_another(drive, declared.vehicle)
    built, n0 = declared.build(), float(declared.soil.n)
    with progress(f"{len(drives)} drives"):
        if workers == 1:
            found = [drive_soil(drive, built, n0, skip) for drive in drives]
        else:
            tasks = (delayed(_one)(drive, declared, n0, skip) for drive in drives)
            found = list(Parallel(n_jobs=workers)(tasks))
    for one in found:
        console.print(f"{one.log}: {verdict_line(one.verdict)}", highlight=False)
    used = [one for one in found if everything or one.verdict.word in ("identified", "not_excited")]
    if not used:
        raise ValueError("map: expected a drive whose verdict is identified or not_excited (or --all), found none")
    used = in_one_frame(used)
    cells = fuse(used, cell)
    console.print(f"{len(cells)} cells of {cell:g} m from {len(used)} of {len(found)} drives{_range(cells)}", highlight=False)
    if used[0].origin is not None:
        place = "latitude {:.7f}, longitude {:.7f} deg".format(*used[0].origin)
        console.print(f"x east and y north of {place}", highlight=False)
    content = as_json(cells, found, used, cell)
    paths = [write_result(folder / "map.json", content, about_vehicle(vehicle, model))]
    if cells:
        paths.append(draw_soil_map(cells, used, cell, folder / "map.png"))
    say_written(paths)


def _range(cells: tuple[Cell, ...]) -> str:
    """Smallest and largest n of the cells, and how well the median cell knows it; empty without a cell."""
    if not cells:
        return ""
    n, share = [c.n for c in cells], 100 * median(c.std / c.n for c in cells)
    return f": n {min(n):.2f} to {max(n):.2f}, ± {share:.0f} % in the median cell"


def _one(drive, declared, n0: float, skip: float) -> DriveSoil:
    return drive_soil(drive, declared.build(), n0, skip)


def in_one_frame(drives: list[DriveSoil]) -> list[DriveSoil]:
    """The drives with x and y (m) in the frame of the first; logs without an origin are taken to share one frame.

    Raises ValueError where some have an origin on the globe and others none.
    """
    first = drives[0].origin
    if {one.origin is None for one in drives} == {True, False}:
        without = next(one.log for one in drives if one.origin is None)
        raise ValueError(f"map: expected a latitude and longitude of the frame of every log or of none; {without} has none")
    if first is None or all(one.origin == first for one in drives):
        return drives
    moved = []
    for one in drives:
        assert one.origin is not None
        east, north = other_frame("map", one.x, one.y, one.origin, first)
        moved.append(replace(one, x=east, y=north, origin=first))
    return moved


def as_json(cells: tuple[Cell, ...], found: list[DriveSoil], used: list[DriveSoil], size: float) -> dict[str, Any]:
    """The content of map.json: GeoJSON in longitude and latitude, or in metres of the logs' own frame where that is not known."""
    origin, features = used[0].origin, []
    for c in cells:
        x, y = c.column * size, c.row * size
        ring = np.array([[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]], dtype=float)
        if origin is not None:
            latitude, longitude = latitude_longitude("map", ring[:, 0], ring[:, 1], origin)
            ring = np.column_stack([longitude, latitude]).round(DECIMALS)
        geometry = {"type": "Polygon", "coordinates": [ring.tolist()]}
        properties = {"n": c.n, "std": c.std, "windows": c.windows, "drives": c.drives}
        features.append({"type": "Feature", "geometry": geometry, "properties": properties})
    names = {one.log for one in used}
    logs = [
        {"log": one.log, "verdict": one.verdict.word, "reason": one.verdict.reason, "used": one.log in names} for one in found
    ]
    frame = "local, m" if origin is None else "WGS 84 longitude and latitude, deg"
    place = {"frame": frame, "origin": origin and list(origin), "cell_m": size}
    return {"type": "FeatureCollection", **place, "logs": logs, "features": features}
