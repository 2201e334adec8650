"""Figures of the case studies on measured data."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.cases.cmu import REFINED, CmuCase
from softsoil.figures.labels import DEGREE, law_words, plain
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, TRUE, page
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.refinement.result import Refinement

SPEEDS = ((0, "locked wheel", TRUE), (10, "rim as fast as the carriage", ESTIMATED), (100, "ten times as fast", REAR))
"""Commanded rim speeds shown (mm/s), carriage at 10 mm/s."""


def draw_cmu(case: CmuCase, base: str, path: Path) -> Path:
    """Side force and sinkage over the slip angle, held-out error per angle, and what each candidate leaves."""
    title = "A wheel in sand (CMU): every line is predicted from the other slip angles"
    with page(path, title, 10, 7, 2, 2) as axes:
        _forces(axes[0, 0], case, base)
        _sinkage(axes[0, 1], case, base)
        _per_angle(axes[1, 0], case, base)
        _candidates(axes[1, 1], case, base)
    return path


def _mean(case: CmuCase, values: Any, speed: int) -> tuple[Any, Any]:
    chosen = case.wheel.rim_speed == speed
    angles = np.array(case.angles)
    return angles, np.array([values[chosen & (case.wheel.angle == a)].mean() for a in angles])


def _forces(axis: Any, case: CmuCase, base: str) -> None:
    wheel, result = case.wheel, case.judged[base]
    for speed, label, color in SPEEDS:
        chosen = wheel.rim_speed == speed
        axis.plot(wheel.angle[chosen], wheel.run.f_y[chosen], ".", color=color, ms=5)
        axis.plot(*_mean(case, result[REFINED].held["angle"], speed), color=color, label=label)
        axis.plot(*_mean(case, result["as_declared"].fitted, speed), color=color, ls=":", lw=1.1)
    axis.plot([], [], ".", color=SOFT, label="measured")
    axis.plot([], [], color=SOFT, ls=":", label=f"{law_words(base)} as declared")
    axis.set(title="Side force", xlabel="slip angle, deg", ylabel="N")
    axis.legend(loc="upper left")


def _sinkage(axis: Any, case: CmuCase, base: str) -> None:
    wheel, result = case.wheel, case.judged[base]
    measured = np.full(len(wheel), np.nan) if wheel.run.sinkage is None else wheel.run.sinkage
    for speed, label, color in SPEEDS:
        chosen = wheel.rim_speed == speed
        axis.plot(wheel.angle[chosen], 1e3 * measured[chosen], ".", color=color, ms=5)
        axis.plot(*_mean(case, 1e3 * result[REFINED].held_sinkage, speed), color=color, label=label)
        axis.plot(*_mean(case, 1e3 * result["as_declared"].held_sinkage, speed), color=color, ls=":", lw=1.1)
    axis.set(title="Sinkage", xlabel="slip angle, deg", ylabel="mm")


def _per_angle(axis: Any, case: CmuCase, base: str) -> None:
    place = np.arange(len(case.angles))
    for shift, name, color, label in (
        (-0.2, "as_declared", INITIAL, f"{law_words(base)} as declared"),
        (0.2, REFINED, ESTIMATED, "with side wall and digging"),
    ):
        axis.bar(
            place + shift, [case.error(base, name, "angle", a) for a in case.angles], 0.38, color=color, label=label
        )
    axis.axhline(case.repeat, color=TRUE, ls="--", lw=1, label="scatter of repeats")
    axis.set(title="Error on the angle left out", xlabel="slip angle, deg", ylabel="rms side force, N")
    axis.set_xticks(place, case.angles)
    axis.legend(loc="upper left")


def _candidates(axis: Any, case: CmuCase, base: str) -> None:
    names = list(case.judged[base])
    errors = [case.error(base, name) for name in names]
    axis.barh([plain(name) for name in names], errors, color=[ESTIMATED if name == REFINED else SOFT for name in names])
    axis.axvline(0.5 * errors[0], color=TRUE, ls="--", lw=1)
    axis.invert_yaxis()
    axis.set(title="Candidates, held out by angle", xlabel="rms side force, N (dashed: half of the baseline)")


SHOWN_SECONDS = 6.0
"""s of the held-out part in the picture of the yaw rate."""


def draw_dart(logs: Mapping[str, Refinement], path: Path) -> Path:
    """Per log: the ranking with its standard errors, the yaw rate over held-out windows, and its verdict.

    logs: by name, what refine says of each.
    """
    title = "A 1:10 car on hard floor (TU Delft): what its model lacks, judged on the last third"
    with page(path, title, 10, 2.9 * len(logs), len(logs), 2, squeeze=False, width_ratios=(1.1, 1.6)) as axes:
        for row, (name, found) in zip(axes, logs.items(), strict=True):
            _ranking(row[0], name, found)
            _yaw_rate(row[1], found)
    return path


def _ranking(axis: Any, name: str, found: Refinement) -> None:
    shown = found.ranking[:7]
    named = {effect.name for effect in found.effects}
    axis.barh(
        [plain(c.name) for c in shown], [100 * c.gain for c in shown], xerr=[100 * c.std for c in shown],
        color=[ESTIMATED if c.name in named else SOFT for c in shown], ecolor=TRUE,
    )  # fmt: skip
    axis.invert_yaxis()
    axis.set(title=f"{name}: {plain(found.verdict)}", xlabel="held-out cost removed, %")


def _yaw_rate(axis: Any, found: Refinement) -> None:
    """Recorded and predicted over the held-out windows of the first stretch."""
    bench, state = found.bench, STATE_CHANNELS.index("omega_z")
    shooting, held = bench.shootings[0], bench.held[0]
    rows = shooting.rows[held][:, None] + np.arange(1, shooting.steps + 1)
    t = shooting.drive.t[rows]
    lines = [(shooting.drive.measured[rows, state], TRUE, "recorded"),
             (shooting.predict(bench.absent[0])[held, :, state], INITIAL, "as declared")]  # fmt: skip
    if found.effects:
        lines.append((shooting.predict(found.selection.bench.absent[0])[held, :, state], ESTIMATED, "refined"))
    for k in range(len(t)):
        if t[k, -1] > t[0, 0] + SHOWN_SECONDS:
            break
        for values, color, label in lines:
            axis.plot(t[k], DEGREE * values[k], color=color, lw=1.1, label=label if k == 0 else None)
    axis.set(title="Yaw rate, windows of 1 s, held out", xlabel="time, s", ylabel="deg/s")
    axis.legend(loc="best", ncols=3)
