"""`softsoil study`: the paper's study on logs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table
from rich.text import Text

from softsoil.commands.estimate import verdict_line
from softsoil.commands.options import ColumnsOption, MethodOption, NoiseOption, SeedOption, SkipOption, open_drive
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
from softsoil.commands.output import RUNS, console, output_folder, progress, say_written, write_result
from softsoil.commands.vehicle_check import refuse_another
from softsoil.estimator.horizons import HORIZONS, START_UP
from softsoil.figures.labels import plain, quantity, rms
from softsoil.figures.terrain import draw_study
from softsoil.files.package_data import example_logs
from softsoil.mpc_demo.study import LATERAL, LogStudy, gains, study_log
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.log_names import distinct, named_n, named_soil

LogsArgument = Annotated[
    list[Path] | None,
    typer.Argument(metavar="[LOG ...]", help="Logs (default: the project's own).", show_default=False),
]
FirstGuessOption = Annotated[
    float | None,
    typer.Option(
        "--n0", help="First guess (default: true n of the log's name + 0.2, else the soil's).", show_default=False
    ),
]


def study(
    logs: LogsArgument = None,
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = None,
    model: ModelOption = None,
    method: MethodOption = "ukf",
    n0: FirstGuessOption = None,
    columns: ColumnsOption = None,
    noise: NoiseOption = "table5",
    seed: SeedOption = 0,
    skip: SkipOption = START_UP,
    out: OutOption = None,
) -> None:
    """The paper's study: n estimated on each log from a wrong first guess, then states predicted 0.5, 2.5 and 5 s ahead.

    Without a log, the project's own are studied; the soil is the one that a log's name tells, unless --soil says it.

    Example: softsoil study data/paper_clay_n0.50.csv.gz --seed 3
    """
    folder = output_folder(out, "study", _earlier(out))
    studies: list[LogStudy] = []
    say_vehicle(vehicle, model)
    chosen = logs or example_logs()
    opened = [open_drive(log, columns, noise, seed, vehicle=vehicle, model=model) for log in chosen]
    names = [drive.name for drive in distinct([clean for clean, _ in opened])]
    declared = []
    for log, (clean, _) in zip(chosen, opened, strict=True):
        declared.append(declaration(vehicle, soil or (None if model else _soil_of(log, clean.name)), law, model))
        refuse_another(clean, declared[-1].vehicle)
    for name, own, (clean, noisy) in zip(names, declared, opened, strict=True):
        with progress(name) as told:
            found = study_log(clean, noisy, own, named_n(clean.name), n0, skip, told, method)
        studies.append(replace(found, log=name))
    paths = [draw_study(one, folder / f"{one.log}.png") for one in studies]
    console.print(table_7(studies))
    for entry in studies:
        console.print(table_8(entry))
    for entry in studies:
        if entry.estimate.verdict is not None and not entry.estimate.verdict.usable:
            console.print(f"{entry.log}: {verdict_line(entry.estimate.verdict)}", style="red", highlight=False)
    _say_gain(studies)
    _say_conditions(studies, noise, seed, skip)
    content = {"logs": [entry.as_json() for entry in studies]}
    say_written([write_result(folder / "study.json", content, about_vehicle(vehicle, model)), *paths])


def _earlier(out: Path | None) -> list[str]:
    """study.json, and the pictures of the study that the one of an earlier run tells of."""
    try:
        earlier = json.loads(((out or RUNS / "study") / "study.json").read_text(encoding="utf-8"))
        return ["study.json", *(Path(f"{entry['log']}.png").name for entry in earlier["logs"])]
    except (OSError, ValueError, KeyError, TypeError):
        return ["study.json"]


def _soil_of(log: Path, name: str) -> str:
    soil = named_soil(name)
    if soil is None:
        raise ValueError(f"{log}: expected --soil (or --model), as the name tells no soil class; found none")
    return soil


def table_7(studies: list[LogStudy]) -> Table:
    """First guess, truth, estimate, error and convergence of each log (paper, Table 7)."""
    table = Table(title="Sinkage exponent (as the paper's Table 7)", title_justify="left")
    for heading in ("log", "soil", "verdict"):
        table.add_column(heading, no_wrap=True)
    for heading in ("first guess", "true", "estimate", "error", "settled after"):
        table.add_column(heading, justify="right")
    for entry in studies:
        table.add_row(
            entry.log,
            plain(entry.soil),
            "-" if entry.estimate.verdict is None else plain(entry.estimate.verdict.word),
            f"{entry.n_initial:.3f}",
            "-" if entry.n_true is None else f"{entry.n_true:.3f}",
            f"{entry.n_estimated:.3f} ± {entry.estimate.n_front_std[-1]:.3f}",
            "-" if entry.error_percent is None else f"{entry.error_percent:.1f} %",
            f"{entry.estimate.converged_s:.1f} s",
        )
    return table


def table_8(entry: LogStudy) -> Table:
    """Rms prediction errors of one log, with first guess and estimate (the paper's Table 8 has their squares)."""
    table = Table(title=f"Rms prediction error, {entry.log} (the paper's Table 8 has its square)", title_justify="left")
    table.add_column("state")
    for horizon in HORIZONS:
        table.add_column(f"{horizon:g} s\nfirst guess", justify="right")
        table.add_column("\nestimate", justify="right")
    initial = {horizon: entry.initial[horizon].mse for horizon in HORIZONS}
    estimated = {horizon: entry.estimated[horizon].mse for horizon in HORIZONS}
    for name in STATE_CHANNELS:
        cells: list[str | Text] = []
        for horizon in HORIZONS:
            guess, found = rms(name, initial[horizon][name]), rms(name, estimated[horizon][name])
            mark = "green" if found < guess else ("red" if found > guess else "none")
            cells += [f"{guess:.3g}", Text(f"{found:.3g}", mark)] if np.isfinite(found) else ["-", "-"]
        table.add_row(quantity(name).label, *cells)
    return table


def _say_gain(studies: list[LogStudy]) -> None:
    """What the estimate is worth over all logs, in one line per horizon."""
    names = ", ".join(quantity(name).words for name in LATERAL)
    console.print(f"Rms errors with the first guess over those with the estimate (geometric mean of {names}):", highlight=False)
    for horizon in HORIZONS:
        found = np.sqrt(gains(studies, horizon))
        known = found[np.isfinite(found)]
        if len(known):
            mean = np.exp(np.mean(np.log(known)))
            better = f"smaller with the estimate in {(known > 1).sum()} of {len(known)}"
            console.print(f"{horizon:g} s ahead: {mean:.2f}; {better}", highlight=False)


def _say_conditions(studies: list[LogStudy], noise: str, seed: int, skip: float) -> None:
    """What the figures rest on: noise, start-up, and the last window."""
    console.print(
        f"Noise {noise}, seed {seed}; the first {skip:g} s of each log are start-up and left out; predictions start from "
        "the states of the log without added noise.",
        highlight=False,
    )
    for entry in studies:
        rests = ", ".join(f"{w.left_out * entry.clean.dt:.2f} s at {h:g} s" for h, w in entry.initial.items())
        console.print(f"{entry.log}: left out at the end, where the last window is not full: {rests}.", highlight=False)
