"""`softsoil blind-test`: the tracing judged blindly on drives of the plant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table
from rich.text import Text

from softsoil.commands.invocation import current
from softsoil.commands.options_model import about_vehicle
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.figures.labels import plain
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.mpc_demo.blind_cases import DURATION, Case, draw_cases
from softsoil.mpc_demo.blind_test import run_blind, totals
from softsoil.mpc_demo.sweep import RESULTS


def blind_test(
    drives: Annotated[int, typer.Option("--drives", min=1, help="How many drives.")] = 40,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the drives.")] = 0,
    duration: Annotated[float, typer.Option("--duration", min=15.0, help="Seconds of each drive.")] = DURATION,
    workers: Annotated[int, typer.Option("--workers", min=1, help="Drives at a time.")] = 1,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder (default: runs/blind-test).", show_default=False)
    ] = None,
) -> None:
    """Drives of the plant with an effect drawn by seed, without one, or with one that the catalogue lacks, traced blindly.

    Resumes where it stopped: results are kept per drive in --out.

    Example: softsoil blind-test --drives 40 --seed 0
    """
    folder = output_folder(out, "blind-test")
    current().resumes = folder.path / RESULTS
    cases = draw_cases(drives, seed, duration)
    with progress(f"{drives} drives of the plant") as told:
        results, failures = run_blind(cases, folder.path, workers, lambda i, result: _tell(cases[i], result, drives, told))
    console.print(result_table(cases, results))
    for index, reason in failures.items():
        console.print(f"drive {index} failed: {reason}", highlight=False)
    counts = totals(cases, results)
    for kind, entry in counts.items():
        console.print(f"{kind}: {entry['right']} of {entry['drives']} right", highlight=False)
    rows = [{"case": case, "result": result} for case, result in zip(cases, results, strict=True)]
    content = {"totals": counts, "drives": rows, "failures": {str(i): reason for i, reason in failures.items()}}
    say_written([write_result(folder / "blind.json", content, about_vehicle(PLANT_VEHICLE)), folder / RESULTS])


def _tell(case: Case, result: dict[str, Any] | None, drives: int, told: Callable[[float], None]) -> None:
    told((case["index"] + 1) / drives)
    if not console.is_terminal:
        found = "failed" if result is None else ("right" if result["right"] else "wrong") + f": {result['why']}"
        console.print(f"{case['index']} {case['name'] or 'nothing'}: {found}", highlight=False)


def result_table(cases: Sequence[Case], results: Sequence[dict[str, Any] | None]) -> Table:
    """One row per drive: what was in it, what was identified, whether that is right."""
    table = Table(title="Blind test", title_justify="left")
    for heading in ("", "soil", "n", "in it", "named", "n estimated", "", "why"):
        table.add_column(heading)
    for case, result in zip(cases, results, strict=True):
        held = plain(case["name"] or "nothing")
        held += " (not in the catalogue)" if case["kind"] == "outside" else ""
        start = [str(case["index"]), plain(case["soil"]), f"{case['n']:.2f}", held]
        if result is None:
            table.add_row(*start, "failed", "", "", "")
            continue
        found = plain(" + ".join(effect["name"] for effect in result["effects"]) or result["verdict"])
        mark = Text("right", "green") if result["right"] else Text("wrong", "red")
        table.add_row(*start, found, f"{result['n_after']:.2f}", mark, result["why"])
    return table
