"""The report on single-wheel data: every law's error and cost, by soil and slip range, as numbers and table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from softsoil.calibration.single_wheel import (
    LAWS,
    RunError,
    by_soil_and_slip,
    call_cost,
    law_for,
    quantiles,
    run_errors,
)
from softsoil.recording.rig import RIG_RADIUS, WheelRun, read_rigs
from softsoil.recording.wheel_table import read_wheel, read_wheel_table
from softsoil.symbolic.soil import load_soil


def read_wheel_runs(
    paths: Sequence[str | Path],
    columns: str | Path | None = None,
    wheel: str | Path | None = None,
    soil: str | Path | None = None,
    part: str | None = "val",
) -> list[WheelRun]:
    """Runs of `chrono_rig` archives (.npz, or folders of them), or of tables with a wheel and a soil.

    columns, wheel: TOML; soil: class name or TOML; part: of a folder, as of `read_rigs`.
    Raises ValueError for a table without wheel or soil.
    """
    tables = [Path(p) for p in paths if Path(p).suffix != ".npz" and not Path(p).is_dir()]
    archives = [p for p in paths if Path(p) not in tables]
    runs = read_rigs(archives, part) if archives or not tables else []
    for path in tables:
        if wheel is None or soil is None:
            raise ValueError(f"{path}: expected --wheel and --soil beside a single-wheel table, found none")
        given = load_soil(soil)
        runs += read_wheel_table(path, columns, read_wheel(wheel), given.parameters(), given.name)
    return runs


def refuse_beside_archives(
    paths: Sequence[Path], columns: str | Path | None, wheel: str | Path | None, soil: str | Path | None
) -> None:
    """Raise ValueError for what tables are read with where there are archives alone, which hold it themselves."""
    idle = [name for name, value in (("--columns", columns), ("--wheel", wheel), ("--soil", soil)) if value is not None]
    if idle and all(path.suffix == ".npz" or path.is_dir() for path in paths):
        raise ValueError(f"{', '.join(idle)}: expected none beside archives of runs, which hold their wheel and their soil")


def wheel_residual(
    runs: Sequence[WheelRun], laws: Sequence[str] = LAWS, progress: Callable[[str], None] = lambda text: None
) -> dict[str, Any]:
    """What residual.json holds for single-wheel data.

    `laws`: law -> median and p95 of the rms lateral force error over the peak force, per run, with the load of the moment;
    `mean_load`: the same with the mean load; `longitudinal`, `sinkage_m`; `cost_us`: of a call in generated C;
    `table`: rows by law, soil and slip range. None where a law does not apply (dallas_refit on a soil not fitted).
    progress: called with one line per law.
    """
    report: dict[str, Any] = {
        key: {} for key in ("laws", "mean_load", "longitudinal", "sinkage_m", "moment", "cost_us")
    }
    report |= {"runs": len(runs), "table": []}
    for name in laws:
        errors: list[RunError] = []
        mean: list[RunError] = []
        if applies(name, runs):
            law = law_for(name, runs)
            errors, mean = run_errors(law, runs), run_errors(law, runs, "mean")
            report["cost_us"][name] = call_cost(law, runs)
            report["table"] += [{"law": name, **row} for row in by_soil_and_slip(errors)]
        report["laws"][name] = quantiles([e.lateral for e in errors])
        report["mean_load"][name] = quantiles([e.lateral for e in mean])
        report["longitudinal"][name] = quantiles([e.longitudinal for e in errors])
        report["sinkage_m"][name] = quantiles([abs(e.sinkage) for e in errors])
        report["moment"][name] = quantiles([e.m_y for e in errors])
        progress(f"{name}: {percent(report['laws'][name])} of peak force")
    return report


def applies(name: str, runs: Sequence[WheelRun]) -> bool:
    """Whether a law can be judged on these runs: dallas_refit only knows the wheel that it was fitted on."""
    return name != "dallas_refit" or all(abs(run.radius - RIG_RADIUS) < 0.01 * RIG_RADIUS for run in runs)


def percent(values: dict[str, float | None]) -> str:
    """Median / p95 of values, as `quantiles` gives them, in per cent."""
    if values["median"] is None or values["p95"] is None:
        return "not applicable"
    return f"{100 * values['median']:.1f} / {100 * values['p95']:.1f} %"


def table_text(report: dict[str, Any]) -> str:
    """The report as a Markdown table: laws, then soil and slip range."""
    lines = [
        f"rms lateral force error over peak, median / 95th percentile, {report['runs']} runs",
        "",
        "| law | load of the moment | mean load | longitudinal | spin moment | abs. sinkage error (mm) | cost in C (µs) |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in report["laws"]:
        cost, h = report["cost_us"].get(name), report["sinkage_m"][name]
        sunk = "-" if h["median"] is None else f"{1e3 * h['median']:.1f} / {1e3 * h['p95']:.1f}"
        cells = [percent(report[key][name]) for key in ("laws", "mean_load", "longitudinal", "moment")]
        lines.append(f"| {name} | {' | '.join(cells)} | {sunk} | {'-' if cost is None else f'{cost:.2f}'} |")
    laws = [name for name in report["laws"] if any(row["law"] == name for row in report["table"])]
    lines += ["", f"| soil | slip | runs | {' | '.join(laws)} |", "|---|---|---|" + "---|" * len(laws)]
    keys = dict.fromkeys((row["soil"], tuple(row["slip"]), row["runs"]) for row in report["table"])
    for soil, slip, count in keys:
        cells = [
            percent(row)
            for name in laws
            for row in report["table"]
            if (row["law"], row["soil"], tuple(row["slip"])) == (name, soil, slip)
        ]
        lines.append(f"| {soil} | {slip[0]:g} to {slip[1]:g} | {count} | {' | '.join(cells)} |")
    return "\n".join(lines)
