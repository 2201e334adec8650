"""`softsoil refine`: residual, missing effect, refined model, and the error before and after."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from softsoil.commands.invocation import software
from softsoil.commands.options import ColumnsOption, NoiseOption, SeedOption, SkipOption, open_drive
from softsoil.commands.options_model import (
    DEFAULT_LAW,
    LawOption,
    ModelOption,
    OutOption,
    SoilsOption,
    VehicleOption,
    about_vehicle,
    declaration,
    noted,
    say_vehicle,
    soils_of,
)
from softsoil.commands.output import OutputFolder, output_folder, progress, say_written, write_result
from softsoil.commands.refine_summary import say
from softsoil.commands.vehicle_check import doubt_another
from softsoil.declaration.ground import HARD_GROUND
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.estimator.horizons import START_UP
from softsoil.figures.refine_report import write_report
from softsoil.files.package_data import REFERENCE_VEHICLE
from softsoil.recording.drive import Recording
from softsoil.refinement.refine import refine
from softsoil.refinement.result import Refinement
from softsoil.refinement.words import falls_sentence, ground_sentences, soil_sentences, split_sentence, verdict_sentence
from softsoil.symbolic.vehicle import load_vehicle


def refine_command(
    data: Annotated[
        list[Path], typer.Argument(help="Drives of one vehicle: CSV, CSV.gz or Parquet.", show_default=False)
    ],
    vehicle: VehicleOption = None,
    soil: SoilsOption = None,
    law: LawOption = None,
    model: ModelOption = None,
    plain: Annotated[
        bool, typer.Option("--plain", help="Leave out the declared effects: start from the paper's structure.")
    ] = False,
    columns: ColumnsOption = None,
    noise: NoiseOption = "none",
    seed: SeedOption = 0,
    skip: SkipOption = START_UP,
    workers: Annotated[int, typer.Option("--workers", min=1, help="Candidates tried at a time.")] = 2,
    out: OutOption = None,
) -> None:
    """What the model leaves unexplained in drives, traced to an effect or to a number of the vehicle that they contradict.

    The first two thirds of each drive are fitted, the rest judges. Only sensor channels are read.

    Example: softsoil refine data/multi_clay_n0.50.parquet data/paper_sandyloam_n0.70.parquet --soil clay --soil sandy_loam
    """
    folder = output_folder(out, "refine", ("refine.json", "refined.toml", "report.html"))
    say_vehicle(vehicle, model)
    drives = [
        open_drive(path, columns, noise, seed + i, vehicle=vehicle, model=model)[1] for i, path in enumerate(data)
    ]
    if model is not None:
        declared = declaration(vehicle, soil[0] if soil else None, law, model)
        soils = [declared.soil] * len(drives)
    else:
        law = law or DEFAULT_LAW
        hard = Declaration(load_vehicle(vehicle or REFERENCE_VEHICLE), HARD_GROUND, law)
        if soil is None and not hard.sinks:
            soils = [HARD_GROUND] * len(drives)
        else:
            soils = soils_of(soil, [drive.name for drive in drives], hard=not hard.sinks)
        declared = noted(Declaration(hard.vehicle, soils[0], law))
    for drive in drives:
        doubt_another(drive, declared.vehicle, named=bool(vehicle or model))
    if plain:
        declared = Declaration(declared.vehicle.with_(effects={}), declared.soil, declared.law)
    with progress(", ".join(drive.name for drive in drives)) as told:
        found = refine(drives, declared, soils=soils, start=skip, workers=workers, progress=told)
    say(found)
    about = about_vehicle(vehicle, model)
    written = write_all(drives, found, folder, about)
    report = write_report(declared, found, skip, folder / "report.html", {"software": software(), "vehicle": about})
    say_written([*written, report])


def write_all(drives: list[Recording], found: Refinement, folder: OutputFolder, vehicle: Mapping[str, str]) -> list[Path]:
    """refine.json and refined.toml in `folder`, with name and file of the vehicle; returns their paths."""
    made = software()
    notes = (
        f"softsoil {made['version']}: {' '.join(made['command'].split())}",  # one line, whatever was typed
        f"Refined on {', '.join(drive.name for drive in drives)}.",
        verdict_sentence(found),
        *ground_sentences(found),
        *soil_sentences(found),
        split_sentence(found),
        falls_sentence(found),
    )
    toml = folder / "refined.toml"
    toml.write_text(declaration_toml(found.declaration, tuple(note for note in notes if note)), encoding="utf-8")
    return [write_result(folder / "refine.json", found.as_json(), vehicle), toml]
