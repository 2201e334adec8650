"""softsoil case: the loop closed with measured data, told as case studies."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from mpc_demo.figures_case import draw_cmu
from mpc_demo.output import console, output_folder, progress, say_written, write_json
from refinement.case_cmu import REFINED, CmuCase, run_cmu
from refinement.ploughing_fit import rms

REAL = Path(__file__).resolve().parents[2] / "shared" / "data" / "real"
"""Measured data, where they are."""
case_app = typer.Typer(help="Case studies on measured data.", no_args_is_help=True)


@case_app.command()
def cmu(
    data: Annotated[Path, typer.Option(help="Folder with the sinkage tests and wheel_smooth.csv.")] = REAL
    / "cmu_single_wheel_sand",
    judge: Annotated[
        Path | None, typer.Option(help="Table of a second wheel, judged with nothing fitted on it.")
    ] = None,
    grouser: Annotated[float, typer.Option(help="Height of the second wheel's grousers, m.")] = 0.0,
    out: Annotated[Path | None, typer.Option(help="Folder to write to.")] = None,
) -> None:
    """A wheel in sand: n and modulus from plate tests, side force predicted, what is missing found and added.

    Example: softsoil case cmu --data ../shared/data/real/cmu_single_wheel_sand

    A second wheel: softsoil case cmu --judge wheel_grousered.csv --grouser 0.005
    """
    folder = output_folder(out, "case_cmu")
    if not 0.0 <= grouser < 0.05:
        raise ValueError(f"--grouser: expected a height in [0, 0.05) m, found {grouser:g}")
    with progress("fitting candidates, one slip angle left out at a time") as told:
        found = run_cmu(data, judge, grouser, progress=told)
    _say_bearing(found)
    for base in found.judged:
        console.print(_candidates(found, base))
    console.print(_per_angle(found))
    for other in found.others:
        for base, force in other.refined.items():
            before, after = rms(other.baseline[base] - other.wheel.run.f_y), rms(force - other.wheel.run.f_y)
            console.print(f"{other.name}, {base}: as declared {before:.2f} N rms, refined {after:.2f} N rms")
    base = min(found.judged, key=lambda b: found.error(b, "as_declared"))
    before = found.error(base, "as_declared")
    for law in found.judged:
        share = 100 * found.error(law, REFINED) / before
        console.print(
            f"{law} refined: {share:.0f} % of the best baseline's error ({base}, {before:.2f} N) on angles left out"
        )
    written = [write_json(folder / "cmu.json", found.as_json()), draw_cmu(found, "turn_slip", folder / "cmu.png")]
    say_written(written)


def _say_bearing(found: CmuCase) -> None:
    b = found.bearing
    console.print(
        f"n = {b.n:.3f} +- {b.n_std:.3f} ({b.tests[0]} plate tests, scatter {b.scatter_n:.2f}); "
        f"modulus {b.k_wheel:.3g} +- {b.k_wheel_std:.2g} N/m^(n+2) ({b.tests[1]} tests of the wheel standing still); "
        f"plates of its footprint's area give {b.k_plates:.3g}; "
        f"modulus ~ width^({b.width_exponent:.2f} +- {b.width_exponent_std:.2f})"
    )


def _candidates(found: CmuCase, base: str) -> Table:
    table = Table(title=f"{base}: rms error of the side force, N (scatter of repeats {found.repeat:.2f} N)")
    for name in ("candidate", "fitted", "angle left out", "repeat left out", "sinkage, mm"):
        table.add_column(name, justify="left" if name in ("candidate", "fitted") else "right")
    told = found.as_json()["laws"][base]
    for name, entry in told.items():
        fitted = ", ".join(_fitted(key, value) for key, value in entry["parameters"].items()) or "nothing"
        table.add_row(
            name, fitted, f"{entry['held_out_angle_rms']:.2f}", f"{entry['held_out_trial_rms']:.2f}",
            f"{1e3 * entry['sinkage_rms']:.1f}",
        )  # fmt: skip
    return table


def _fitted(name: str, entry: Mapping[str, Any]) -> str:
    if entry["at_bound"]:
        return f"{name} {entry['value']:.3g} (bound)"
    return f"{name} {entry['value']:.3g}+-{entry['std']:.2g}"


def _per_angle(found: CmuCase) -> Table:
    table = Table(title="rms error of the side force by slip angle, N; each angle predicted from the others")
    table.add_column("law")
    for angle in found.angles:
        table.add_column(f"{angle}°", justify="right")
    for base in found.judged:
        for name in ("as_declared", REFINED):
            table.add_row(f"{base} {name}", *(f"{found.error(base, name, 'angle', a):.1f}" for a in found.angles))
    return table
