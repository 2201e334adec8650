"""A calibration as a study: fit, judge on other runs, leave soils out; coefficients as TOML, table as text."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

from softsoil.calibration.refit_dallas import refit, tables_to_toml
from softsoil.calibration.single_wheel import law_for, quantiles, run_errors
from softsoil.calibration.turn_slip_fit import FACTORS, Calibrated, calibrate, with_soil
from softsoil.calibration.wheel_report import percent
from softsoil.recording.rig import WheelRun
from softsoil.symbolic.laws.dallas_refit import DallasRefit
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.laws.turn_slip_calibrated import TurnSlipCalibrated
from softsoil.symbolic.wheel import ForceLaw

UNITS = {"entry_time": "s"}


@dataclass(frozen=True)
class Study:
    """Result of a calibration: `found`, the report (what calibrate.json holds), the coefficients as TOML by file name, and
    the calibrated law with the judging runs as it sees them.
    """

    found: Calibrated
    report: dict[str, Any]
    coefficients: dict[str, str]
    calibrated: tuple[ForceLaw, Sequence[WheelRun]]


def run_study(
    fit_on: Sequence[WheelRun],
    judge_on: Sequence[WheelRun],
    names: Sequence[str] = FACTORS,
    refit_paper: bool = False,
    progress: Callable[[str], None] = lambda text: None,
) -> Study:
    """Fit on some runs, judge on others; coefficients: calibrated.toml (and dallas_refit.toml).

    names: what to fit, of turn_slip_fit.FACTORS or soil parameters; refit_paper: repeat the paper's curve fitting
    as well. Raises ValueError where the runs fit no parameter.
    """
    found = calibrate(fit_on, names, progress=progress)
    if not parameters(found):
        raise ValueError(f"calibrate: expected runs that show one of {', '.join(names)}; found {len(fit_on)} that show none")
    laws: dict[str, tuple[ForceLaw, Sequence[WheelRun]]] = {
        "turn_slip": (law_for("turn_slip", judge_on), judge_on),
        "turn_slip_calibrated": (calibrated_law(judge_on, found), with_soil(judge_on, found)),
    }
    coefficients = {}
    if refit_paper:
        tables = refit(fit_on, progress)
        laws = {"dallas_refit": (DallasRefit(tables), judge_on), **laws}
        coefficients["dallas_refit.toml"] = tables_to_toml(tables, _heading(fit_on))
    report: dict[str, Any] = {
        "parameters": parameters(found),
        "not_identified": list(found.not_identified),
        "fitted_on": len(fit_on),
        "judged_on": len(judge_on),
        "rms_fit": found.rms,
        "laws": {name: judged(law, runs) for name, (law, runs) in laws.items()},
        "mean_load": {name: judged(law, runs, "mean") for name, (law, runs) in laws.items()},
        "left_out": leave_out(fit_on, judge_on, found, names, progress),
    }
    coefficients["calibrated.toml"] = to_toml(found, fit_on)
    return Study(found, report, coefficients, laws["turn_slip_calibrated"])


def calibrated_law(runs: Sequence[WheelRun], found: Calibrated) -> TurnSlipCalibrated:
    """The calibrated law with the factors just fitted, and the options that the runs ask for."""
    base = law_for("turn_slip", runs)
    if not isinstance(base, TurnSlip):
        raise TypeError(f"expected a TurnSlip, found {base!r}")
    return TurnSlipCalibrated(base, factors=found.factors)


def judged(law: ForceLaw, runs: Sequence[WheelRun], load: str = "moment") -> dict[str, float | None]:
    """Median and 95th percentile of the lateral error over the runs."""
    return quantiles([error.lateral for error in run_errors(law, runs, load)])


def leave_out(
    fit_on: Sequence[WheelRun],
    judge_on: Sequence[WheelRun],
    found: Calibrated,
    names: Sequence[str],
    progress: Callable[[str], None],
) -> dict[str, Any]:
    """Per soil class: error on it of a fit that never saw it, beside the error of the fit that did; {} for one class."""
    groups = list(dict.fromkeys(run.group for run in fit_on))
    result: dict[str, Any] = {}
    if len(groups) < 2:
        return result
    for group in groups:
        unseen = [run for run in judge_on if run.group == group]
        if not unseen:
            continue
        other = calibrate([run for run in fit_on if run.group != group], names)
        result[group] = {
            "without": judged(calibrated_law(unseen, other), with_soil(unseen, other)),
            "with": judged(calibrated_law(unseen, found), with_soil(unseen, found)),
        }
        progress(f"without {group}: {percent(result[group]['without'])}, with it {percent(result[group]['with'])}")
    return result


def parameters(found: Calibrated) -> dict[str, dict[str, Any]]:
    """Parameter -> value, standard error, unit."""
    return {
        name: {"value": value, "std": found.std[name] if isfinite(found.std[name]) else None, "unit": UNITS.get(name, "")}
        for name, value in found.values.items()
    }


def to_toml(found: Calibrated, runs: Sequence[WheelRun]) -> str:
    """Coefficients with standard errors: [rig] for the reference rig's own numerics, else [soil]; multiples of given
    soil parameters in [soil_multiples].
    """
    section = "rig" if all(run.reference_rig for run in runs) else "soil"
    lines = [f"# {_heading(runs)}"]
    for title, chosen in ((section, FACTORS), ("soil_multiples", None)):
        names = [name for name in found.values if (name in FACTORS) == (chosen is not None)]
        if names:
            lines += ["", f"[{title}]"]
            std = {n: f", std = {found.std[n]:.2g}" if isfinite(found.std[n]) else "" for n in names}
            lines += [f"{n} = {{ value = {found.values[n]:.6g}{std[n]} }}" for n in names]
    return "\n".join(lines) + "\n"


def study_text(study: Study) -> str:
    """The study as text for the terminal."""
    report = study.report
    lines = ["", "parameter      value        standard error"]
    for name, found in report["parameters"].items():
        error = "not known: one run" if found["std"] is None else f"{found['std']:.2g} {found['unit']}"
        lines.append(f"{name:13s}  {found['value']:<11.5g}  {error}")
    if report["not_identified"]:
        lines.append(f"not identified by these runs: {', '.join(report['not_identified'])}")
    lines += [
        "",
        f"rms lateral error over peak, median / p95, judged on {report['judged_on']} runs (load of the moment; mean)",
    ]
    lines += [f"{n:22s} {percent(v)}; {percent(report['mean_load'][n])}" for n, v in report["laws"].items()]
    for soil, row in report["left_out"].items():
        lines.append(f"{soil:22s} never seen {percent(row['without'])}, seen {percent(row['with'])}")
    return "\n".join(lines)


def _heading(runs: Sequence[WheelRun]) -> str:
    groups = ", ".join(dict.fromkeys(run.group for run in runs))
    return f"Fitted on {len(runs)} single-wheel runs ({groups}) by softsoil calibrate."
