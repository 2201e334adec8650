"""Figures of the terrain estimate and the prediction study (paper, Figs. 4-6 and Table 8)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import chdtri

from softsoil.estimator.horizons import Windows
from softsoil.estimator.terrain import TerrainEstimate
from softsoil.figures.labels import SYMBOLS, quantity
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, TRUE, page, second_scale
from softsoil.mpc_demo.study import LogStudy
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.evidence import interpolated

GAP = 0.5
"""s: longest gap between samples of a slower sensor that a line is drawn across."""
PORTION_S = 12.0
"""s: stretch of the drive whose paths are drawn."""


def draw_study(study: LogStudy, path: Path) -> Path:
    """One page for one log: the drive, n over time, paths, and prediction errors."""
    with page(path, f"{study.log}: {_verdict(study)}", 11, 7.2, 2, 3) as axes:
        _drive(axes[0, 0], study.clean)
        _n_over_time(axes[0, 1], study.estimate, study.n_true)
        _paths(axes[0, 2], study)
        for axis, horizon in zip(axes[1], study.initial, strict=True):
            _errors(axis, study.initial[horizon], study.estimated[horizon])
        axes[1, 0].set_ylabel("rms error, units as named")
        axes[1, 0].legend(loc="upper left")
    return path


def draw_estimate(
    name: str, drive: Recording, estimate: TerrainEstimate, n_true: float | None, path: Path
) -> Path:
    """One page for one estimate: the drive, n over time, NIS."""
    front, rear = (
        f"{n[-1]:.3f} ± {std[-1]:.3f}"
        for n, std in ((estimate.n_front, estimate.n_front_std), (estimate.n_rear, estimate.n_rear_std))
    )
    end = f"n {front}" if front == rear else f"n front {front}, rear {rear}"
    word = "" if estimate.verdict is None else f"{estimate.verdict.word.replace('_', ' ')}, "
    innovations = len(estimate.nis) > 0
    with page(path, f"{name}: {word}{end}", 9, 6.5 if innovations else 4.6, 3 if innovations else 2, 1, sharex=True) as axes:
        _drive(axes[0], drive)
        _n_over_time(axes[1], estimate, n_true)
        if innovations:
            _nis(axes[2], estimate)
        for axis in axes[:-1]:
            axis.set_xlabel("")
    return path


def _verdict(study: LogStudy) -> str:
    known = "" if study.error_percent is None else f" (true {study.n_true:.3f}, error {study.error_percent:.0f} %)"
    word = "" if study.estimate.verdict is None else f"{study.estimate.verdict.word.replace('_', ' ')}, "
    return f"{word}n from {study.n_initial:.2f} to {study.n_estimated:.3f}{known}"


def _drive(axis: Any, drive: Recording) -> None:
    reach = max(round(GAP / drive.dt), 1)
    steer, speed = np.rad2deg(interpolated(drive["steer"], reach)), interpolated(drive["u"], reach)
    axis.plot(drive.t, steer, color=ESTIMATED, lw=1.0)
    for first, last in drive.ruts:
        axis.axvspan(first, last, color=SOFT, alpha=0.3, lw=0)
    axis.set(title="Steering and speed" + (" (grey: in its own ruts)" if drive.ruts else ""), xlabel="time, s")
    axis.set_ylabel("steering angle, deg", color=ESTIMATED)
    axis.tick_params(axis="y", colors=ESTIMATED)
    right = second_scale(axis, "speed, m/s", REAR)
    right.plot(drive.t, speed, color=REAR, lw=1.6)
    right.set_ylim(float(np.nanmin(speed, initial=0.0)), None)


def _n_over_time(axis: Any, estimate: TerrainEstimate, n_true: float | None) -> None:
    series = [("estimate, front", estimate.n_front, estimate.n_front_std, ESTIMATED)]
    if not np.allclose(estimate.n_front, estimate.n_rear, equal_nan=True):
        series.append(("estimate, rear", estimate.n_rear, estimate.n_rear_std, REAR))
    else:
        series[0] = ("estimate, both axles", *series[0][1:])
    own = slice(None) if estimate.by_filter is None else slice(-1)
    for label, n, std, color in series:
        axis.fill_between(estimate.t[own], (n - 2 * std)[own], (n + 2 * std)[own], color=color, alpha=0.18, lw=0)
        axis.plot(estimate.t[own], n[own], color=color, label=label)
        if estimate.by_filter is not None:
            mark = {"fmt": "o", "ms": 5, "capsize": 4, "color": TRUE if color == ESTIMATED else color}
            axis.errorbar(estimate.t[-1], n[-1], 2 * std[-1], label=label.replace("estimate", "corrected by windows"), **mark)
    axis.axhline(estimate.n0, color=INITIAL, ls=":", label="first guess")
    if n_true is not None:
        axis.axhline(n_true, color=TRUE, ls="--", label="true")
    axis.set(title="Sinkage exponent, ±2 std", xlabel="time, s", ylabel="n")
    axis.legend(loc="best")


def _paths(axis: Any, study: LogStudy) -> None:
    """The paper's Fig. 5: a stretch of the drive, predicted with the middle horizon."""
    horizon = list(study.initial)[1] if len(study.initial) > 1 else next(iter(study.initial))
    guess, estimate = study.initial[horizon], study.estimated[horizon]
    count = max(1, round(PORTION_S / horizon))
    shown = slice(len(guess.rows) // 3, len(guess.rows) // 3 + count)
    turn = _along_the_way(guess.recorded[shown])
    for i, (truth, first, second) in enumerate(
        zip(guess.recorded[shown], guess.predicted[shown], estimate.predicted[shown], strict=True)
    ):
        said = i == 0
        axis.plot(*turn(truth), color=TRUE, lw=2.2, label="true" if said else None)
        axis.plot(*turn(first), color=INITIAL, ls=":", lw=1.8, label="first guess" if said else None)
        axis.plot(*turn(second), color=ESTIMATED, ls="--", lw=1.6, label="estimate" if said else None)
        axis.plot(*turn(truth[:1]), "o", color=TRUE, ms=4)
    axis.set(title=f"Predicted {horizon:g} s ahead, reset at dots", xlabel="along the way, m", ylabel="across, m")
    axis.legend(loc="best")


def _along_the_way(recorded: np.ndarray) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Turns states (N, 6) to positions along and across the chord of the stretch drawn, so that errors across are seen."""
    if not len(recorded):
        return lambda states: (states[:, 0], states[:, 1])
    start, chord = recorded[0, 0, :2], recorded[-1, -1, :2] - recorded[0, 0, :2]
    cos, sin = chord / max(float(np.hypot(*chord)), 1e-9)
    return lambda states: (
        cos * (states[:, 0] - start[0]) + sin * (states[:, 1] - start[1]),
        cos * (states[:, 1] - start[1]) - sin * (states[:, 0] - start[0]),
    )


def _errors(axis: Any, initial: Windows, estimated: Windows) -> None:
    places = np.arange(len(STATE_CHANNELS))
    for offset, windows, color, label in (
        (-0.2, initial, INITIAL, "first guess"),
        (0.2, estimated, ESTIMATED, "estimate"),
    ):
        values = np.array([quantity(name).factor * np.sqrt(value) for name, value in windows.mse.items()])
        axis.bar(places + offset, np.where(values > 0, values, np.nan), 0.38, color=color, label=label)
    axis.set_yscale("log")
    axis.set_xticks(places, [f"{SYMBOLS[name]}\n{quantity(name).unit}" for name in STATE_CHANNELS])
    axis.grid(axis="x", visible=False)
    axis.set_title(f"Predicted {initial.horizon:g} s ahead ({len(initial.rows)} windows)")


def _nis(axis: Any, estimate: TerrainEstimate) -> None:
    low, high = (chdtri(np.maximum(estimate.dof, 1), share) for share in (0.975, 0.025))  # sensors differ from update to update
    axis.fill_between(estimate.t, low, high, step="mid", color=ESTIMATED, alpha=0.15, lw=0, label="95 % band")
    axis.plot(estimate.t, estimate.nis, ".", color=TRUE, ms=2)
    axis.set_yscale("log")
    axis.set_ylim(min(1e-2, 0.5 * float(np.quantile(estimate.nis, 0.01))), max(10 * float(high.max()), 10))
    inside, above = (100 * share for share in (estimate.nis_inside_95, estimate.nis_above_95))
    axis.set(
        title="Normalised innovation squared: "
        + ("a log without sensor noise" if estimate.noise_free else f"{inside:.0f} % in the band, {above:.0f} % above"),
        xlabel="time, s", ylabel="NIS",
    )  # fmt: skip
    axis.legend(loc="upper right")
