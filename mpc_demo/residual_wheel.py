"""`softsoil residual` on single-wheel runs: the force laws side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer

from mpc_demo.output import write_json
from recording.rig import WheelRun
from refinement.wheel_report import draw_errors, draw_force_against_slip, read_wheel_runs, table_text, wheel_residual


def is_wheel_data(data: Path, wheel: Path | None) -> bool:
    """Whether `data` holds single-wheel runs: an archive, a folder of archives, or a table given with a wheel."""
    return data.suffix == ".npz" or (data.is_dir() and any(data.glob("*.npz"))) or wheel is not None


def report_wheel(
    data: Path, columns: Path | None, wheel: Path | None, soil: str | None, folder: Path
) -> Sequence[Path]:
    """Judge every law on the runs in `data`, print the table and write residual.json with two figures into `folder`.

    columns, wheel: TOML files for tables; soil: class or TOML for tables.
    """
    runs: list[WheelRun] = read_wheel_runs([data], columns, wheel, soil)
    typer.echo(f"{len(runs)} single-wheel runs ...")
    report = wheel_residual(runs, progress=typer.echo)
    typer.echo(table_text(report))
    return (
        write_json(folder / "residual.json", report),
        draw_force_against_slip(runs, folder / "force_against_slip.png"),
        draw_errors(report, folder / "errors.png"),
    )
