"""The sinkage exponent of each drive and the verdict on it, by windows with free initial states.

Windows that start at recorded states carry their noise into n, more than anything else that a right model is off by. Where the
vehicle's file states a joint error, n is that of the joint fit of all drives (`softsoil.refinement.joint_fit`); else a moving
horizon over the drive has it, as in `softsoil estimate --method horizon`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.modes import run_guess, standing
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.verdict import Verdict, initial_guesses, judge
from softsoil.recording.drive import Recording
from softsoil.refinement.fit import Fit
from softsoil.refinement.trace import Bench
from softsoil.symbolic.soil import Soil


@dataclass(frozen=True)
class DriveN:
    """n of one drive, its standard deviation and the verdict on it."""

    n: float
    std: float
    verdict: Verdict


def drive_n(
    recordings: Sequence[Recording],
    declaration: Declaration,
    soils: Sequence[Soil],
    start: float,
    fitted: tuple[Bench, Fit],
    joint: bool,
) -> tuple[DriveN, ...]:
    """n of each drive with the vehicle and law of a declaration, each on its own soil; empty on hard ground.

    start: seconds left out at the beginning; fitted: bench and fit of the same vehicle, whose n stands where `joint`, a fit with
    free starts, or where a drive holds no window.
    """
    bench, last = fitted
    if not bench.sinks:
        return ()
    found = []
    for recording, soil, free in zip(recordings, soils, bench.ground, strict=True):
        n, std = last.named()[free.name]
        std = float(np.hypot(std, declaration.vehicle.n_error * n))
        model = Declaration(declaration.vehicle, soil, declaration.law).build()
        verdict = judge(recording, model, float(soil.n), (n,) if joint else None, tied=True, start=start)
        if verdict.evidence is not None and not joint:
            n, std = float(verdict.evidence.n[0]), float(verdict.evidence.std[0])
        found.append(DriveN(n, std, verdict))
    return tuple(found)


def plain_n(
    recordings: Sequence[Recording],
    declaration: Declaration,
    soils: Sequence[Soil],
    start: float,
    fitted: tuple[Bench, Fit],
    joint: bool,
) -> tuple[float, ...]:
    """n of each drive as of `drive_n`, without a verdict on it, for comparison."""
    bench, last = fitted
    if not bench.sinks:
        return ()
    values = [last.named()[free.name][0] for free in bench.ground]
    if joint:
        return tuple(values)
    rules = HorizonRules()
    for i, (recording, soil) in enumerate(zip(recordings, soils, strict=True)):
        model = Declaration(declaration.vehicle, soil, declaration.law).build()
        with contextlib.suppress(ValueError):  # a drive that holds no two windows
            windows = drive_windows(recording, model, start, rules)
            runs, _ = standing([run_guess(windows, guess, True, rules) for guess in initial_guesses(float(soil.n))])
            values[i] = float(runs[0].horizon.n[0])
    return tuple(values)


def not_to_be_used(found: Sequence[DriveN], reason: str) -> tuple[DriveN, ...]:
    """The same n, none of them identified, for a reason that lies in the vehicle."""
    word = "inconsistent"
    return tuple(replace(d, verdict=replace(d.verdict, word=word, reason=reason)) if d.verdict.usable else d for d in found)
