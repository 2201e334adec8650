"""Figure of what a model leaves unexplained in a drive."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from softsoil.figures.labels import DEGREE, plain, quantity
from softsoil.figures.style import ESTIMATED, REAR, TRUE, page, second_scale
from softsoil.refinement.residual import WINDOW, DriveResidual


def draw_residual(name: str, model: str, found: DriveResidual, path: Path) -> Path:
    """One page: unexplained lateral force of both axles over time and against each other, and errors over the horizons."""
    title = f"{name}: what {plain(model)} leaves unexplained"
    with page(path, title, 10, 6.4, 2, 2, width_ratios=(2, 1)) as axes:
        _over_time(axes[0, 0], found)
        _against(axes[0, 1], found)
        _rates(axes[1, 0], found)
        _horizons(axes[1, 1], found)
    return path


def _over_time(axis: Any, found: DriveResidual) -> None:
    for label, force, color in (("front", found.force_f, ESTIMATED), ("rear", found.force_r, REAR)):
        axis.plot(found.t, force, color=color, marker=".", ms=3, lw=1, label=label)
    axis.axhline(0, color=TRUE, lw=0.8)
    axis.set(title=f"Unexplained lateral force, windows of {WINDOW:g} s", ylabel="N per axle")
    axis.legend(loc="best")


def _against(axis: Any, found: DriveResidual) -> None:
    axis.plot(found.force_f, found.force_r, ".", color=TRUE, ms=4)
    forces = np.abs(np.concatenate([found.force_f, found.force_r]))
    reach = 1.1 * float(np.max(forces[np.isfinite(forces)], initial=1.0))
    axis.plot([-reach, reach], [reach, -reach], color=REAR, ls="--", lw=1, label="pure yaw moment")
    axis.axhline(0, color=ESTIMATED, ls=":", lw=1, label="front only")
    axis.set(
        title="Rear against front", xlabel="front, N", ylabel="rear, N", xlim=(-reach, reach), ylim=(-reach, reach)
    )
    axis.legend(loc="best")


def _rates(axis: Any, found: DriveResidual) -> None:
    axis.plot(found.t, found.rate_v, color=TRUE, lw=1)
    axis.set(title="Unexplained accelerations", xlabel="time, s", ylabel="dv/dt, m/s²")
    right = second_scale(axis, "yaw acceleration, deg/s²", REAR)
    right.plot(found.t, DEGREE * found.rate_r, color=REAR, lw=1)


def _horizons(axis: Any, found: DriveResidual) -> None:
    horizons = np.array([float(h) for h in found.mse])
    shades = ("#102a43", "#00798c", "#5fb49c", "#edae49", "#d1495b", "#8d6a9f")
    for name, color in zip(next(iter(found.mse.values())), shades, strict=True):
        shown = quantity(name)
        values = shown.factor * np.sqrt(np.array([entry[name] for entry in found.mse.values()], dtype=float))
        axis.plot(horizons, np.where(values > 0, values, np.nan), "o-", color=color, ms=3, label=shown.label)
    axis.set(xscale="log", yscale="log", title="Rms prediction error", xlabel="horizon, s", ylabel="rms error, units as named")
    axis.set_xticks(horizons, [f"{h:g}" for h in horizons])
    axis.minorticks_off()
    low, high = axis.get_ylim()
    axis.set_ylim(low, high * (high / low) ** 0.45)  # room for the legend above the lines
    axis.legend(loc="upper left", ncols=2, fontsize=7)
