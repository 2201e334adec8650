"""softsoil case: case studies of the loop closed with measured data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from softsoil.cases.cmu import REFINED, CmuCase, run_cmu
from softsoil.cases.dart import WINDOWING, log_name, trace_log, transferred
from softsoil.cases.ploughing_fit import rms
from softsoil.cases.stanford import CANNOT, read_stanford, run_stanford
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.commands.refine_summary import say
from softsoil.figures.case import draw_cmu, draw_dart
from softsoil.figures.labels import law_words, plain
from softsoil.refinement.result import Refinement
from softsoil.refinement.words import in_degrees, with_unit

REAL = Path("../shared/data/real")
"""Measured data, where the shared data stand beside the working folder."""
case_app = typer.Typer(help="Case studies on measured data.", no_args_is_help=True, add_completion=False)


@case_app.command()
def cmu(
    data: Annotated[
        Path | None,
        typer.Option(
            help="Folder with the sinkage tests and wheel_smooth.csv (default: the shared data, where they are).",
            show_default=False,
        ),
    ] = None,
    judge: Annotated[
        Path | None, typer.Option(help="Table of a second wheel, judged with nothing fitted on it.")
    ] = None,
    grouser: Annotated[float, typer.Option(help="Height of the second wheel's grousers, m.")] = 0.0,
    out: Annotated[Path | None, typer.Option(help="Folder to write to.")] = None,
) -> None:
    """A wheel in sand: n and modulus from plate tests, side force predicted, what is missing identified and added.

    Example: softsoil case cmu --data ../shared/data/real/cmu_single_wheel_sand

    A second wheel: softsoil case cmu --judge wheel_grousered.csv --grouser 0.005
    """
    folder = output_folder(out, "case_cmu")
    data = _measured(data, "cmu_single_wheel_sand")
    if not 0.0 <= grouser < 0.05:
        raise ValueError(f"--grouser: expected a height in [0, 0.05) m, found {grouser:g}")
    if grouser and judge is None:
        raise ValueError("--grouser: expected --judge beside it, a table of the second wheel, which has them; found none")
    with progress("fitting candidates, one slip angle left out at a time") as told:
        found = run_cmu(data, judge, grouser, progress=told)
    _say_bearing(found)
    for base in found.judged:
        console.print(_candidates(found, base))
    console.print(_per_angle(found))
    for other in found.others:
        for base, force in other.refined.items():
            before, after = rms(other.baseline[base] - other.wheel.run.f_y), rms(force - other.wheel.run.f_y)
            console.print(f"{other.name}, {law_words(base)}: as declared {before:.2f} N rms, refined {after:.2f} N rms")
    base = min(found.judged, key=lambda b: found.error(b, "as_declared"))
    before = found.error(base, "as_declared")
    for law in found.judged:
        share = 100 * found.error(law, REFINED) / before
        console.print(
            f"{law_words(law)} refined: {share:.0f} % of the best baseline's error ({law_words(base)}, {before:.2f} N) on angles "
            "left out"
        )
    written = [write_result(folder / "cmu.json", found.as_json()), draw_cmu(found, "turn_slip", folder / "cmu.png")]
    say_written(written)


def _measured(data: Path | None, name: str) -> Path:
    """The folder of measurements: as given, or of the shared data; ValueError where there is none."""
    folder = data or REAL / name
    if not folder.is_dir():
        found = f"none at {folder}" if data else "none given, and no shared data beside the working folder"
        raise ValueError(f"--data: expected the folder of the measurements {name}, found {found}")
    return folder


def _say_bearing(found: CmuCase) -> None:
    b = found.bearing
    console.print(
        f"n = {b.n:.3f} ± {b.n_std:.3f} ({b.tests[0]} plate tests, scatter {b.scatter_n:.2f}); "
        f"modulus {b.k_wheel:.3g} ± {b.k_wheel_std:.2g} N/m^(n+2) ({b.tests[1]} tests of the wheel standing still); "
        f"plates of its footprint's area give {b.k_plates:.3g}; "
        f"modulus ~ width^({b.width_exponent:.2f} ± {b.width_exponent_std:.2f})"
    )


def _candidates(found: CmuCase, base: str) -> Table:
    title = f"{law_words(base)}: rms error of the side force, N (scatter of repeats {found.repeat:.2f} N)"
    table = Table(title=title, title_justify="left")
    for name in ("candidate", "fitted", "angle left out", "repeat left out", "sinkage, mm"):
        table.add_column(name, justify="left" if name in ("candidate", "fitted") else "right")
    told = found.as_json()["laws"][base]
    for name, entry in told.items():
        fitted = ", ".join(_fitted(key, value) for key, value in entry["parameters"].items()) or "nothing"
        table.add_row(
            plain(name), fitted, f"{entry['held_out_angle_rms']:.2f}", f"{entry['held_out_trial_rms']:.2f}",
            f"{1e3 * entry['sinkage_rms']:.1f}",
        )  # fmt: skip
    return table


def _fitted(name: str, entry: Mapping[str, Any]) -> str:
    if not entry["at_bound"]:
        return f"{plain(name)} {with_unit(entry['value'], entry['std'], entry['unit'])}"
    value, _, unit = in_degrees(entry["value"], 0.0, entry["unit"])
    return f"{plain(name)} {value:.3g} {unit}".rstrip() + " (bound)"


def _per_angle(found: CmuCase) -> Table:
    table = Table(title="Rms error of the side force by slip angle, N, each from the others", title_justify="left")
    table.add_column("law")
    for angle in found.angles:
        table.add_column(f"{angle}°", justify="right")
    for base in found.judged:
        for name in ("as_declared", REFINED):
            errors = (f"{found.error(base, name, 'angle', a):.1f}" for a in found.angles)
            table.add_row(f"{law_words(base)} {plain(name)}", *errors)
    return table


@case_app.command()
def stanford(
    data: Annotated[
        Path | None,
        typer.Option(
            help="Folder with the car's log (csv.gz) (default: the shared data, where they are).", show_default=False
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder to write to.")] = None,
) -> None:
    """A race car on a hard road, without pose or wheel speeds: friction, tread, and what can and cannot be said.

    Example: softsoil case stanford --data ../shared/data/real/stanford_250lm
    """
    folder = output_folder(out, "case_stanford")
    data = _measured(data, "stanford_250lm")
    drive, checks = read_stanford(data)
    passed = sum(check.passed for check in checks)
    console.print(f"channels against each other: {passed} of {len(checks)} checks passed", highlight=False)
    for check in checks:
        if not check.passed:
            console.print(f"warning: {check.sentence()}", style="yellow", highlight=False, soft_wrap=True)
    with progress("tracing") as told:
        found = run_stanford(drive, told)
    say(found)
    for line in CANNOT:
        console.print(line, highlight=False)
    content: dict[str, Any] = {"log": drive.name, "refinement": found.as_json(), "cannot": list(CANNOT)}
    content["checks"] = [check.as_json() for check in checks]
    say_written([write_result(folder / "stanford.json", content)])


@case_app.command()
def dart(
    data: Annotated[
        Path | None,
        typer.Option(
            help="Folder with the car's logs (csv.gz) (default: the shared data, where they are).", show_default=False
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder to write to.")] = None,
) -> None:
    """A 1:10 car on hard floor: what the model lacks between the steering command and the motion, log by log.

    Example: softsoil case dart --data ../shared/data/real/tudelft_dart_1to10
    """
    folder = output_folder(out, "case_dart")
    data = _measured(data, "tudelft_dart_1to10")
    paths = sorted(data.glob("*.csv.gz"))
    if not paths:
        raise ValueError(f"--data: expected the car's logs (*.csv.gz), found none in {data}")
    logs: dict[str, Refinement] = {}
    for path in paths:
        name = log_name(path) if log_name(path) not in logs else path.name.removesuffix(".csv.gz")
        with progress(f"tracing {path.name}") as told:
            logs[name] = trace_log(path, told)
        console.print(f"{name}: {sum(len(d) * d.dt for d in logs[name].recordings):.0f} s of driving", style="bold")
        say(logs[name])
    carried = _carried_over(logs)
    content = {"logs": [{"log": name, "refinement": found.as_json()} for name, found in logs.items()], "carried_over": carried}
    say_written([write_result(folder / "dart.json", content), draw_dart(logs, folder / "dart.png")])


def _carried_over(logs: Mapping[str, Refinement]) -> list[dict[str, Any]]:
    """Each effect that was named on some logs, with its mean parameters of the others, judged on each log."""
    rows = []
    for effect in {effect.name: effect for found in logs.values() for effect in found.effects}.values():
        for name, found in logs.items():
            others = [e.parameters for log, other in logs.items() if log != name for e in other.effects if e.name == effect.name]
            if not others:
                continue
            values = {key: sum(values[key][0] for values in others) / len(others) for key in effect.parameters}
            gain, std, falls = transferred(found, effect, values)
            shown = {key: in_degrees(value, 0.0, effect.parameters[key][2]) for key, value in values.items()}
            words = ", ".join(f"{key} = {value:.3g} {unit}".rstrip() for key, (value, _, unit) in shown.items())
            console.print(
                f"{name} with {words} of the other logs: removes {100 * gain:.0f} ± {100 * std:.0f} % of the held-out cost; "
                f"rms error of the heading at {WINDOWING.horizons[0]:g} s {math.sqrt(falls):.2f} times smaller", highlight=False,
            )  # fmt: skip
            rows.append({"log": name, "effect": effect.name, "values": values, "gain": gain, "std": std, "heading_falls": falls})
    return rows
