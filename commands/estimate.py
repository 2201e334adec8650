"""`softsoil estimate`: the estimator over one log."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from softsoil.commands.options import ColumnsOption, MethodOption, NoiseOption, SeedOption, SkipOption, open_drive
from softsoil.commands.options_model import (
    LawOption,
    ModelOption,
    OutOption,
    SoilOption,
    VehicleOption,
    about_vehicle,
    declaration,
    say_vehicle,
)
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.commands.vehicle_check import refuse_another
from softsoil.estimator.estimate import estimate as estimate_log
from softsoil.estimator.horizons import START_UP
from softsoil.estimator.late_clocks import LateClock, late_clocks
from softsoil.estimator.terrain import TerrainEstimate
from softsoil.estimator.tuning import UNSTATED_ERROR
from softsoil.estimator.verdict import Verdict
from softsoil.figures.labels import plain
from softsoil.figures.terrain import draw_estimate
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_n
from softsoil.symbolic.vehicle import TURNING


def estimate(
    log: Annotated[Path, typer.Argument(help="The log: CSV, CSV.gz or Parquet.", show_default=False)],
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = None,
    model: ModelOption = None,
    method: MethodOption = "ukf",
    n0: Annotated[
        float | None, typer.Option("--n0", help="First guess of n (default: the soil's).", show_default=False)
    ] = None,
    columns: ColumnsOption = None,
    noise: NoiseOption = "none",
    seed: SeedOption = 0,
    skip: SkipOption = START_UP,
    out: OutOption = None,
) -> None:
    """Run the terrain estimator over one log.

    With --model and its effects one n stands for both axles; without effects front and rear have their own, as in the paper.
    Where the verdict is identified, n at the end is that of windows with free initial states, by either method.

    Example: softsoil estimate data/multi_clay_n0.50.parquet --soil clay --n0 0.7
    """
    folder = output_folder(out, "estimate", ("estimate.json", "estimate.png"))
    say_vehicle(vehicle, model)
    declared = declaration(vehicle, soil, law, model)
    clean, noisy = open_drive(log, columns, noise, seed, vehicle=vehicle, model=model)
    refuse_another(noisy, declared.vehicle)
    built = declared.build()
    first = float(declared.soil.n) if n0 is None else n0
    with progress(clean.name) as told:
        found = estimate_log(noisy, built, first, method=method, start=skip, progress=told)
    clocks = late_clocks(noisy, built, found, start=skip)
    _say(found, noisy, clocks, built.doubted, unstated=not declared.vehicle.states_errors)
    if not np.isfinite(found.n_front[-1]):  # no soil: nothing to draw
        say_written([write_result(folder / "estimate.json", as_json(found, clocks), about_vehicle(vehicle, model))])
        return
    figure = draw_estimate(clean.name, clean, found, named_n(clean.name), folder / "estimate.png")
    say_written([write_result(folder / "estimate.json", as_json(found, clocks), about_vehicle(vehicle, model)), figure])


def as_json(found: TerrainEstimate, clocks: Sequence[LateClock] = ()) -> dict:
    """The content of estimate.json; clocks: that would explain an inconsistent estimate."""
    if found.verdict is None:
        raise ValueError("estimate.json: expected an estimate with its verdict, found none")
    return {
        "verdict": found.verdict.word,
        "reason": found.verdict.reason,
        "n_front": found.n_front[-1],
        "n_rear": found.n_rear[-1],
        "n_front_std": found.n_front_std[-1],
        "n_rear_std": found.n_rear_std[-1],
        "n0": found.n0 if np.isfinite(found.n0) else None,
        "converged_s": found.converged_s,
        "nis_inside_95": found.nis_inside_95 if len(found.nis) and not found.noise_free else None,
        "filter": _filter(found),
        "windows": _windows(found),
        "late_clocks": [vars(clock) for clock in clocks],
        "changes_s": found.changes,
        "revoked_s": found.revoked,
        "drift": None if found.drift is None else vars(found.drift),
        "step_us": {"median": np.median(found.step_us), "p99": np.percentile(found.step_us, 99)},
        "trace": {"t": found.t, "n_front": found.n_front, "n_rear": found.n_rear},
    }


def _filter(found: TerrainEstimate) -> dict | None:
    """n and its standard deviation per axle as the filter itself had them at the end, where windows corrected it."""
    if found.by_filter is None:
        return None
    n, std = zip(*found.by_filter, strict=True)
    return {"n": n, "std": std}


def _windows(found: TerrainEstimate) -> dict | None:
    """What the verdict rests on, from windows with free initial states: n per axle or one for both, the yaw inertia that the
    drive asks for as a share of the declared one, and the strain of an identified vehicle's numbers; None without windows."""
    evidence = None if found.verdict is None else found.verdict.evidence
    if evidence is None:
        return None
    inertia = {"share": 1.0 + evidence.inertia, "std": evidence.inertia_std}
    change = evidence.change
    load = change and {"share": change.load, "std": change.load_std}
    steering = change and {"share": 1.0 + change.steering, "std": change.steering_std}
    by_force = dict(zip(("front", "rear"), evidence.soil.forces, strict=True))
    soil = {"tenth": evidence.soil.tenth, "std": evidence.soil.std, "force": by_force, "law_std": evidence.soil.law_std}
    strain = change and change.strain
    vehicle = {"yaw_inertia": inertia, "strain": strain, "load": load, "steering": steering}
    return {"n": evidence.n, "std": evidence.std, **vehicle, "soil": soil}


NOT_STATED = "; a soil file may state their errors, which softsoil soil fits"
MATTERS = 0.01
"""Least share of n by which a parameter's tenth moves it that is printed."""
NEXT = {
    **dict.fromkeys(
        ("inconsistent", "axles_disagree"),
        "softsoil refine, with the same log, vehicle and soil, names what the model or a channel lacks",
    ),
    "no_soil": "softsoil refine --law hard_ground fits friction and tread",
}
"""Verdict -> the command that answers it."""
ANEW = {
    "vehicle": "softsoil identify anew, with the numbers that its file says are contradicted measured again",
    "soil": "softsoil soil anew, with drives that agree with the class",
}
"""File that its own logs contradict -> the command that answers it, whatever else the drive says."""


def verdict_line(verdict: Verdict) -> str:
    """The verdict in one line, before any number."""
    return f"{plain(verdict.word)}: {verdict.reason}" + ("" if verdict.usable else "; do not use this n")


def _of_class(found: TerrainEstimate) -> list[str]:
    """What n owes to the other parameters of the declared class, those that matter, the largest first."""
    evidence = None if found.verdict is None else found.verdict.evidence
    if evidence is None:
        return []
    tenths = sorted(evidence.soil.tenth.items(), key=lambda item: -abs(item[1]))
    moved = ", ".join(f"{name} {100 * share:+.0f} %" for name, share in tenths if abs(share) >= MATTERS)
    line = f"n is that of the declared soil: where one of its parameters is a tenth larger, n is another: {moved}"
    stated = f"; by the errors that its file states ± {100 * evidence.soil.std:.0f} % of n, in its standard deviation"
    front, rear = (100 * share for share in evidence.soil.forces)
    law = f"1 % more lateral force of the front axle is {front:+.1f} % of n, of the rear axle {rear:+.1f} %"
    return [line + (stated if evidence.soil.std > 0.0 else NOT_STATED), law] if moved else []


def _not_looked_at(found: TerrainEstimate, unstated: bool) -> list[str]:
    """What a verdict knows nothing of, as the vehicle's file states no errors; unstated: nor how well it is known."""
    evidence = None if found.verdict is None else found.verdict.evidence
    if evidence is None:
        return []
    if evidence.change is not None:
        known = f"n_error, [joint_error], or {', '.join(TURNING)} in [uncertainty]"
        words = f"the vehicle's file does not state how well it is known ({known}): {100 * UNSTATED_ERROR:.0f} % of n is in its"
        return [f"{words} standard deviation for that"] if unstated else []
    allowed = f": {100 * UNSTATED_ERROR:.0f} % of n is in its standard deviation for them" if unstated else ""
    return [
        "not looked at: a load, the steering's scale and the vehicle's numbers, since its file states no errors of them (that of "
        f"softsoil identify does){allowed}"
    ]


def _say(
    found: TerrainEstimate, drive: Recording, clocks: Sequence[LateClock], doubted: Sequence[str], unstated: bool
) -> None:
    if found.verdict is None:
        raise ValueError("estimate: expected an estimate with its verdict, found none")
    console.print(verdict_line(found.verdict), style="bold" if found.verdict.usable else "bold red", highlight=False)
    doubtful = [note for note in drive.notes if note.startswith("warning:")]  # printed where the log was opened
    if doubtful and not found.verdict.usable:
        console.print("next: mend what the warnings above name; what else is named here may come from that", highlight=False)
    for clock in clocks:
        console.print(f"clock: {clock.sentence}", highlight=False)
    if found.verdict.word in NEXT:
        console.print(f"next: {next((ANEW[file] for file in doubted), NEXT[found.verdict.word])}", highlight=False)
    if not np.isfinite(found.n_front[-1]):
        return
    lines = [
        f"n front {found.n_front[-1]:.3f} ± {found.n_front_std[-1]:.3f}, rear {found.n_rear[-1]:.3f} ± "
        f"{found.n_rear_std[-1]:.3f}; within 10 % of its end after {found.converged_s:.1f} s",
        f"{np.median(found.step_us):.0f} µs per update with its predictions",
    ]
    windows = _windows(found)
    if found.by_filter is not None:
        (front, front_std), (rear, rear_std) = found.by_filter
        own = f"{front:.3f} ± {front_std:.3f}" + (f", {rear:.3f} ± {rear_std:.3f}" if rear != front else "")
        lines.insert(1, f"n is that of the windows; the filter itself ends at {own}")
    elif windows is not None and len(found.nis):
        both = ", ".join(f"{n:.3f} ± {std:.3f}" for n, std in zip(windows["n"], windows["std"], strict=True))
        lines.insert(1, f"windows with free initial states, for comparison: {both}")
    if len(found.nis):
        inside, above = (100 * share for share in (found.nis_inside_95, found.nis_above_95))
        lines.append(
            "NIS says nothing here: the log carries far less noise than the filter assumes"
            if found.noise_free
            else f"NIS inside its 95 % band {inside:.1f} % of the time, above it {above:.1f} %"
        )
    lines += _of_class(found) + _not_looked_at(found, unstated)
    lines += [f"soil taken to have changed at {t:.1f} s" for t in found.changes]
    if found.drift is not None:
        classes = ", or ".join((found.drift.likely, *found.drift.also))
        lines.append(f"drift at {found.drift.t:.1f} s ({found.drift.channel} is corrected to one side): likely {classes}")
    for words, counts in (("rows without a sample", found.counts.invalid), ("left out, outside the gate", found.counts.gated)):
        alike: dict[int, list[str]] = {}
        for name, count in counts.items():
            if drive.measured(name):
                alike.setdefault(count, []).append(name)
        lines += [f"{words}: {', '.join(names)}, {count} times" for count, names in alike.items()]
    lines += [f"input held: {name} {count} times" for name, count in found.counts.held_inputs.items()]
    for line in (*lines, *(note for note in drive.notes if note not in doubtful)):
        console.print(line, highlight=False)
