"""Figure of what a model leaves unexplained in a drive."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from softsoil.figures.labels import DEGREE, plain, quantity
from softsoil.figures.style import ESTIMATED, REAR, TRUE, page, second_scale
from softsoil.refinement.residual import WINDOW, DriveResidual


def draw_residual(name: str, model: str, result: DriveResidual, path: Path) -> Path:
    """One page: unexplained lateral force of both axles over time and against each other, and errors over the horizons."""
    title = f"{name}: what {plain(model)} leaves unexplained"
    with page(path, title, 10, 6.4, 2, 2, width_ratios=(2, 1)) as axes:
        _over_time(axes[0, 0], result)
        _against(axes[0, 1], result)
        _rates(axes[1, 0], result)
        _horizons(axes[1, 1], result)
    return path


def _over_time(axis: Any, result: DriveResidual) -> None:
    for label, force, color in (("front", result.force_f, ESTIMATED), ("rear", result.force_r, REAR)):
        axis.plot(result.t, force, color=color, marker=".", ms=3, lw=1, label=label)
    axis.axhline(0, color=TRUE, lw=0.8)
    axis.set(title=f"Unexplained lateral force, windows of {WINDOW:g} s", ylabel="N per axle")
    axis.legend(loc="best")


def _against(axis: Any, result: DriveResidual) -> None:
    axis.plot(result.force_f, result.force_r, ".", color=TRUE, ms=4)
    forces = np.abs(np.concatenate([result.force_f, result.force_r]))
    reach = 1.1 * float(np.max(forces[np.isfinite(forces)], initial=1.0))
    axis.plot([-reach, reach], [reach, -reach], color=REAR, ls="--", lw=1, label="pure yaw moment")
    axis.axhline(0, color=ESTIMATED, ls=":", lw=1, label="front only")
    axis.set(
        title="Rear against front", xlabel="front, N", ylabel="rear, N", xlim=(-reach, reach), ylim=(-reach, reach)
    )
    axis.legend(loc="best")


def _rates(axis: Any, result: DriveResidual) -> None:
    axis.plot(result.t, result.rate_v, color=TRUE, lw=1)
    axis.set(title="Unexplained accelerations", xlabel="time, s", ylabel="dv/dt, m/s²")
    right = second_scale(axis, "yaw acceleration, deg/s²", REAR)
    right.plot(result.t, DEGREE * result.rate_r, color=REAR, lw=1)


def _horizons(axis: Any, result: DriveResidual) -> None:
    horizons = np.array([float(h) for h in result.mse])
    shades = ("#102a43", "#00798c", "#5fb49c", "#edae49", "#d1495b", "#8d6a9f")
    for name, color in zip(next(iter(result.mse.values())), shades, strict=True):
        shown = quantity(name)
        values = shown.factor * np.sqrt(np.array([entry[name] for entry in result.mse.values()], dtype=float))
        axis.plot(horizons, np.where(values > 0, values, np.nan), "o-", color=color, ms=3, label=shown.label)
    axis.set(xscale="log", yscale="log", title="Rms prediction error", xlabel="horizon, s", ylabel="rms error, units as named")
    axis.set_xticks(horizons, [f"{h:g}" for h in horizons])
    axis.minorticks_off()
    low, high = axis.get_ylim()
    axis.set_ylim(low, high * (high / low) ** 0.45)  # room for the legend above the lines
    axis.legend(loc="upper left", ncols=2, fontsize=7)
