"""softsoil calibrate: the turn-slip law against single-wheel runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from softsoil.calibration.calibration_study import run_study, study_text
from softsoil.calibration.turn_slip_fit import FACTORS
from softsoil.calibration.wheel_report import read_wheel_runs, refuse_beside_archives
from softsoil.commands.options_model import OutOption
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.figures.single_wheel import draw_force_against_slip
from softsoil.recording.rig import WheelRun, archives
from softsoil.recording.wheel_table import hold_out

REFERENCE = Path("../shared/data/chrono_rig")
"""Runs of the reference rig, where the shared data stand beside the working folder."""


def calibrate(
    data: Annotated[
        list[Path] | None, typer.Argument(
            help="Single-wheel runs: npz archives, a folder of them, or tables (default: the shared runs, where they are).",
            show_default=False,
        )
    ] = None,
    judge: Annotated[list[Path] | None, typer.Option(help="Runs to judge on; default: some of the data.")] = None,
    columns: Annotated[Path | None, typer.Option(help="TOML that maps the table's columns and units.")] = None,
    wheel: Annotated[Path | None, typer.Option(help="TOML with radius, width (m) and contact_step (s).")] = None,
    soil: Annotated[str | None, typer.Option(help="Soil class or TOML, for tables.")] = None,
    fit: Annotated[str, typer.Option(help="What to fit, by commas: factors or soil parameters.")] = ",".join(FACTORS),
    paper: Annotated[
        bool, typer.Option("--paper", help="Repeat the paper's curve fitting too (dallas_refit).")
    ] = False,
    out: OutOption = None,
) -> None:
    """Fit the force law on single-wheel runs and judge it on others.

    Example: softsoil calibrate ../shared/data/chrono_rig --out runs/calibrate

    A folder with *_cal.npz and *_val.npz is fitted on the former and judged on the latter; other data are split, every
    third run (or row of a steady table) held out. Example with a test rig's table:
    softsoil calibrate rig.csv --columns columns.toml --wheel wheel.toml --soil soil.toml --fit path,k,phi
    """
    folder = output_folder(out, "calibrate", ("calibrate.json", "calibrated.toml", "dallas_refit.toml", "force.png"))
    fit_on, judge_on = split(data or _reference(), judge, columns, wheel, soil)
    names = [name.strip() for name in fit.split(",") if name.strip()]
    with progress(f"fitting {', '.join(names)} on {len(fit_on)} runs, judging on {len(judge_on)}"):
        study = run_study(fit_on, judge_on, names, refit_paper=paper, progress=_say)
    _say(study_text(study))
    written = [write_result(folder / "calibrate.json", study.report)]
    for name, text in study.coefficients.items():
        written.append(folder / name)
        written[-1].write_text(text, encoding="utf-8")
    figure = draw_force_against_slip(judge_on, folder / "force.png", extra=study.calibrated)
    say_written([*written, figure])


def _say(text: str) -> None:
    console.print(text, highlight=False, soft_wrap=True)


def _reference() -> list[Path]:
    """The shared runs; ValueError that says what a user gives instead where they are not there."""
    if not REFERENCE.is_dir():
        raise ValueError(
            "DATA: expected single-wheel runs (npz archives, a folder of them, or tables with --columns, --wheel and --soil), "
            "found none named on the command line"
        )
    return [REFERENCE]


def split(
    data: Sequence[Path], judge: Sequence[Path] | None, columns: Path | None, wheel: Path | None, soil: str | None
) -> tuple[list[WheelRun], list[WheelRun]]:
    """Runs to fit on and to judge on; ValueError for data that are not there or cannot be split."""
    for path in [*data, *(judge or [])]:
        if not path.exists():
            raise ValueError(
                f"expected single-wheel runs (.npz, .csv, .csv.gz, .parquet or a folder), found none at {path}"
            )
    refuse_beside_archives([*data, *(judge or [])], columns, wheel, soil)
    divided = all(path.is_dir() and archives(path, "cal") and archives(path, "val") for path in data)
    if judge or divided:
        fitted = read_wheel_runs(data, columns, wheel, soil, "cal")
        judging = read_wheel_runs(judge or data, columns, wheel, soil)
        refuse_copied_runs([*fitted, *judging])
        return fitted, judging
    runs = read_wheel_runs(data, columns, wheel, soil, None)
    refuse_copied_runs(runs)
    return hold_out(runs)


def refuse_copied_runs(runs: Sequence[WheelRun]) -> None:
    """Raise ValueError where a run is there twice: it would count twice, and judge the fit that saw it."""
    first: dict[tuple[bytes, ...], str] = {}
    for run in runs:
        rows = tuple(values.tobytes() for values in (run.v_x, run.v_y, run.omega, run.load, run.f_x, run.f_y))
        if rows in first:
            raise ValueError(f"{run.name}: expected runs that differ, found the rows of {first[rows]} again: a run counts once")
        first[rows] = run.name
