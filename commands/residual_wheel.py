"""What `softsoil residual` does with single-wheel data: every law against the measured force."""

from __future__ import annotations

from pathlib import Path

from softsoil.calibration.wheel_report import read_wheel_runs, table_text, wheel_residual
from softsoil.commands.output import OutputFolder, console, say_written, write_result
from softsoil.figures.single_wheel import draw_errors, draw_force_against_slip


def is_wheel_data(data: Path, wheel: Path | None) -> bool:
    """Whether DATA are single-wheel runs: an archive, a folder of archives, or a table that comes with a wheel."""
    return data.suffix == ".npz" or wheel is not None or (data.is_dir() and any(data.glob("*.npz")))


def report_on_wheel_data(data: Path, columns: Path | None, wheel: Path | None, soil: str | None, folder: OutputFolder) -> None:
    """Judge all laws on single-wheel data; prints the table and writes residual.json, force.png and errors.png.

    data: npz archive, folder of them, or table; columns, wheel: TOML; soil: class or TOML, for tables; folder: to write
    in. Raises ValueError naming file, expected and found.
    """
    runs = read_wheel_runs([data], columns, wheel, soil)
    console.print(f"{len(runs)} single-wheel runs", highlight=False)
    report = wheel_residual(runs, progress=lambda line: console.print(line, highlight=False))
    console.print(table_text(report), highlight=False, soft_wrap=True)
    say_written(
        [
            write_result(folder / "residual.json", report),
            draw_force_against_slip(runs, folder / "force.png"),
            draw_errors(report, folder / "errors.png"),
        ]
    )
