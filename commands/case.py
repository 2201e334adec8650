"""softsoil case: case studies of the loop closed with measured data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from softsoil.cases.cmu import REFINED, CmuCase, run_cmu
from softsoil.cases.dart import GROUND, HORIZONS, DartLog, candidate_model, trace_log, transferred
from softsoil.cases.ploughing_fit import rms
from softsoil.cases.stanford import CANNOT, read_stanford, run_stanford
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.figures.case import draw_cmu, draw_dart
from softsoil.symbolic.model import Model

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
    for note in drive.notes:
        console.print(note, highlight=False)
    passed = sum(check.passed for check in checks)
    console.print(f"channels against each other: {passed} of {len(checks)} checks passed")
    for check in checks:
        if not check.passed:
            console.print(f"warning: {check.sentence()}", style="yellow", highlight=False, soft_wrap=True)
    with progress("tracing") as told:
        log = run_stanford(drive, told)
    _say_log(log)
    (phi, phi_std), (tread, tread_std) = (log.ground[1][name] for name in ("phi", "k"))
    bound = next(f.upper for f in GROUND if f.name == "phi")
    if phi > bound - 1e-3:
        words = f"friction ends on its bound ({math.tan(bound):.2f}): the road's grip is not identified"
        console.print(words, style="yellow")
    grip, grip_std = math.tan(phi), phi_std / math.cos(phi) ** 2
    console.print(
        f"friction {_pm(grip, grip_std)}, tread shears by {_pm(1e3 * tread, 1e3 * tread_std)} mm before it slides"
    )
    for horizon in log.before:
        words = ", ".join(f"{s} {log.before[horizon][s]:.3g} -> {log.after[horizon][s]:.3g}" for s in ("v", "omega_z"))
        console.print(f"held-out rms at {horizon} s: {words} (m/s, rad/s)")
    for line in CANNOT:
        console.print(line, highlight=False)
    content = {"log": log.as_json(), "checks": [check.as_json() for check in checks], "cannot": list(CANNOT)}
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
    model, logs = candidate_model(), []
    for path in paths:
        with progress(f"tracing {path.name}") as told:
            logs.append(trace_log(path, model, told))
        _say_log(logs[-1])
    carried = _carried_over(paths, logs, model)
    console.print(_errors(logs))
    written = [
        write_result(folder / "dart.json", {"logs": [log.as_json() for log in logs], "carried_over": carried}),
        draw_dart(logs, folder / "dart.png"),
    ]
    say_written(written)


def _carried_over(paths: Sequence[Path], logs: Sequence[DartLog], model: Model) -> list[dict[str, Any]]:
    """The effect identified in most logs, with its mean parameter from the others, judged on each log without a fit there."""
    names = [name for log in logs for name in log.parameters]
    if not names:
        return []
    name, rows = max(set(names), key=names.count), []
    for path, log in zip(paths, logs, strict=True):
        others = [other.parameters[name][0] for other in logs if other is not log and name in other.parameters]
        if not others:
            continue
        value = sum(others) / len(others)
        gain, std, after = transferred(path, model, {name: value})
        console.print(
            f"{log.name} with {name} = {value:.3g} of the other logs: removes {100 * gain:.0f} +- {100 * std:.0f} % of the "
            f"held-out cost; psi at 0.5 s {log.before['0.5']['psi']:.3f} -> {after['0.5']['psi']:.3f} rad"
        )
        rows.append({"log": log.name, "parameter": name, "value": value, "gain": gain, "std": std, "rms": after})
    return rows


def _say_log(log: DartLog) -> None:
    first, last = log.ground
    console.print(
        f"{log.name}: {log.seconds:.0f} s of driving; phi {_pm(*first['phi'])}, refined {_pm(*last['phi'])} rad"
    )
    for candidate in log.ranking[:5]:
        console.print(
            f"  {candidate.name}: removes {100 * candidate.gain:.0f} +- {100 * candidate.std:.0f} % of the held-out cost"
        )
    found = ", ".join(f"{name} {_pm(value, std)} {unit}" for name, (value, std, unit) in log.parameters.items())
    console.print(f"  accepted: {found or 'none'}")
    for group in log.groups:
        if len(group) > 1:
            console.print(f"  cannot be separated here: {', '.join(group)}")


def _pm(value: float, std: float) -> str:
    return f"{value:.3g} +- {std:.2g}"


def _errors(logs: list[DartLog]) -> Table:
    states = ("x", "y", "psi", "v", "omega_z")
    table = Table(title="rms error on the held-out last third, declared / refined (m, rad, m/s, rad/s)")
    for name in ("log", "horizon, s", *states):
        table.add_column(name, justify="left" if name == "log" else "right")
    for log in logs:
        for horizon in (f"{h:g}" for h in HORIZONS):
            row = (f"{log.before[horizon][s]:.3f} / {log.after[horizon][s]:.3f}" for s in states)
            table.add_row(log.name, horizon, *row)
    return table
