"""`softsoil bench`: the speed figures, each set against something measured in the same run."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from softsoil.commands.options import open_drive
from softsoil.commands.options_model import (
    LawOption,
    OutOption,
    SoilOption,
    VehicleOption,
    about_vehicle,
    declaration,
    say_vehicle,
)
from softsoil.commands.output import console, output_folder, say_written, write_result
from softsoil.figures.labels import plain
from softsoil.files.package_data import example_logs
from softsoil.mpc_demo.bench_c_library import c_library_rows
from softsoil.mpc_demo.bench_filter import filter_rows
from softsoil.mpc_demo.bench_nmpc import nmpc_rows
from softsoil.mpc_demo.bench_rows import Row
from softsoil.mpc_demo.bench_whole import whole_rows
from softsoil.recording.log_names import named_soil


def bench(
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = None,
    only: Annotated[
        str | None, typer.Option("--only", help="One subject: filter, nmpc, c_library or whole.", show_default=False)
    ] = None,
    out: OutOption = None,
) -> None:
    """Speed of what runs often, each figure as a ratio measured in the same run; the paper's own figures stand beside.

    Example: softsoil bench --only c_library
    """
    if only is not None and only not in SUBJECTS:
        raise ValueError(f"--only: expected one of {', '.join(SUBJECTS)}; found {only}")
    folder = output_folder(out, "bench")
    log = example_logs()[0]
    say_vehicle(vehicle)
    drive, _ = open_drive(log, None, vehicle=vehicle)
    declared = declaration(vehicle, soil or named_soil(drive.name), law, None)
    found = []
    table = Table(title="Speed", title_justify="left")
    for heading in ("what", "value", "against", "value", "ratio", "paper"):
        table.add_column(heading, justify="right" if heading in ("value", "ratio") else "left")
    for row in rows(declared, drive, SUBJECTS if only is None else (only,)):
        found.append(row)
        console.print(f"{plain(row.name)}: {_value(row.value, row.unit)}", highlight=False)
        table.add_row(*_cells(row))
    console.print(table)
    content = {"machine": machine(), "rows": [row.as_json() for row in found]}
    say_written([write_result(folder / "bench.json", content, about_vehicle(vehicle))])


SUBJECTS = ("filter", "nmpc", "c_library", "whole")


def rows(declared, drive, subjects: Sequence[str] = SUBJECTS) -> Iterator[Row]:
    """The rows of the subjects named, from what each measures."""
    measured = {
        "filter": lambda: filter_rows(declared, drive),
        "nmpc": lambda: nmpc_rows(declared),
        "c_library": lambda: c_library_rows(declared),
        "whole": lambda: whole_rows(declared, drive),
    }
    for subject in subjects:
        yield from measured[subject]()


def _cells(row: Row) -> tuple[str, ...]:
    other = "" if row.against_value is None else _value(row.against_value, row.unit)
    ratio = "" if row.ratio is None else _value(row.ratio, "")
    return (plain(row.name), _value(row.value, row.unit), row.against, other, ratio, row.paper.replace(" us", " µs"))


def _value(value: float, unit: str) -> str:
    """A figure with three digits, or a whole number, and its unit: us is written as µs, that of a ratio is 1 and not written."""
    number = f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
    return f"{number} {'µs' if unit == 'us' else unit.removeprefix('1')}".rstrip()


def machine() -> str:
    """Processor, number of processors, system, Python."""
    processor = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        processor = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), processor)
    except OSError:
        pass
    return f"{processor}, {os.cpu_count()} processors, {platform.system()}, Python {platform.python_version()}"
