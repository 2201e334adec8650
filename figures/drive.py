"""Figures of the closed loop: paths, errors, what the estimator and the solver did; and an animation with the plan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from softsoil.figures.labels import quantity
from softsoil.figures.style import ESTIMATED, INITIAL, RC, SOFT, TRUE, page
from softsoil.mpc_demo.closed_loop import CONTROLLERS, ESTIMATING, LoopLog
from softsoil.mpc_demo.scenarios import Scenario

COLORS = dict(zip(CONTROLLERS, (INITIAL, TRUE, ESTIMATED), strict=True))
LABELS = dict(zip(CONTROLLERS, ("wrong first guess of n", "true n", "estimated n"), strict=True))
OVERHANG = 0.1
"""Of the vehicle's outline before the front and behind the rear axle, over the wheelbase."""


def draw_drive(scenario: Scenario, logs: Sequence[LoopLog], path: Path) -> Path:
    """One page for one course: paths, error along the way, n, steering, speed, solve times."""
    with page(path, f"{scenario.name.replace('_', ' ')}: {scenario.why}", 12, 9, 3, 2) as axes:
        figure, grid = axes[0, 0].figure, axes[0, 0].get_gridspec()
        for axis in axes[0]:
            axis.remove()
        top = figure.add_subplot(grid[0, :])
        _map(top, scenario)
        steering = quantity("steer")
        for log in logs:
            first = log is next(other for other in logs if other.controller == log.controller)
            style = {"color": COLORS[log.controller], "label": LABELS[log.controller] if first else None, "lw": 1.2}
            truth, t, along = log.column("truth"), log.column("t"), log.column("along")
            top.plot(truth[:, 0], truth[:, 1], **style)
            axes[1, 0].plot(along, log.column("error"), **style)
            axes[1, 1].plot(t, log.column("n_used"), **style)
            axes[2, 0].plot(along, steering.factor * log.column("steer"), **style)
            axes[2, 1].plot(t, log.column("solve_ms"), ".", ms=2, color=COLORS[log.controller])
        top.legend(loc="upper left", ncols=3)
        n_true = [scenario.n_true(row["truth"][0]) for row in logs[-1].rows]
        axes[1, 1].plot(logs[-1].column("t"), n_true, color=SOFT, ls="--", label="truth")
        axes[1, 1].legend(loc="best")
        axes[1, 0].axvspan(0, scenario.warm_up, color=SOFT, alpha=0.15, lw=0)
        axes[1, 0].set(title="Distance left of the path (grey: not judged)", xlabel="along the path, m", ylabel="m")
        axes[1, 1].set(title="Sinkage exponent that the controller uses", xlabel="time, s", ylabel="n")
        axes[2, 0].set(title="Steering", xlabel="along the path, m", ylabel=steering.label)
        axes[2, 1].set(title="Time of a solve", xlabel="time, s", ylabel="ms", yscale="log")
    return path


def _map(axis: Any, scenario: Scenario) -> None:
    axis.plot(*scenario.path.points.T, color=SOFT, lw=5, alpha=0.4, zorder=0)
    for x, y, radius, _, _ in scenario.obstacles:
        axis.add_patch(Circle((x, y), radius, color=INITIAL, alpha=0.35, lw=0))
    axis.set(title="The course from above", xlabel="x, m", ylabel="y, m", aspect="equal")
    axis.set_xlim(scenario.path.points[0, 0] - 2, scenario.path.points[-1, 0] + 2)
    low, high = scenario.path.points[:, 1].min(), scenario.path.points[:, 1].max()
    axis.set_ylim(min(low - 2.5, -3.0), max(high + 2.5, 3.0))


def animate(scenario: Scenario, log: LoopLog, path: Path, frames: int = 110) -> Path:
    """GIF of one run: vehicle, way so far, predicted horizon, and n with its band up to now."""
    rows = np.unique(np.linspace(0, len(log.rows) - 1, frames).astype(int))
    truth, n, std, t = log.column("truth"), log.column("n"), log.column("n_std"), log.column("t")
    with matplotlib.rc_context(dict(RC)):
        figure = Figure(figsize=(9, 3.6), dpi=80, layout="constrained")
        FigureCanvasAgg(figure)
        top, below = figure.subplots(2, 1, height_ratios=(1.3, 1))
        _map(top, scenario)
        top.set_title(f"{scenario.name.replace('_', ' ')}, {LABELS[log.controller]}: plan ahead in colour")
        (way,) = top.plot([], [], color=TRUE, lw=1.0)
        (plan,) = top.plot([], [], color=ESTIMATED, lw=2.5)
        body = top.add_patch(Polygon(np.zeros((4, 2)), color=TRUE, alpha=0.85, lw=0))
        below.plot(t, [scenario.n_true(place[0]) for place in truth], color=SOFT, ls="--", label="true n")
        estimated = log.controller == ESTIMATING
        (trace,) = below.plot([], [], color=ESTIMATED, label="estimated n" if estimated else "n it drives on")
        below.set(xlim=(0, t[-1]), ylim=(min(n.min(), 0.4) - 0.1, n.max() + 0.15), xlabel="time, s", ylabel="n")
        band = below.fill_between([], [], color=ESTIMATED, alpha=0.12, lw=0, label="±2 std" if estimated else None)
        below.legend(loc="upper right", ncols=3)

        def frame(i: int) -> tuple:
            x, y, psi = truth[i, :3]
            way.set_data(truth[: i + 1, 0], truth[: i + 1, 1])
            plan.set_data(*log.plans[i].T)
            body.set_xy(_outline(log, x, y, psi))
            trace.set_data(t[: i + 1], n[: i + 1])
            now = slice(0, i + 1)
            if estimated:
                band.set_data(t[now], n[now] - 2 * std[now], n[now] + 2 * std[now])
            return way, plan, body, trace, band

        FuncAnimation(figure, frame, frames=rows, blit=False).save(path, writer=PillowWriter(fps=12))
    return path


def _outline(log: LoopLog, x: float, y: float, psi: float) -> np.ndarray:
    """(4, 2) corners of the vehicle, its front axle at (x, y)."""
    front, back, half = OVERHANG * log.wheelbase, (1.0 + OVERHANG) * log.wheelbase, log.half_width
    corners = np.array([[front, half], [front, -half], [-back, -half], [-back, half]])
    cos, sin = np.cos(psi), np.sin(psi)
    return corners @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
