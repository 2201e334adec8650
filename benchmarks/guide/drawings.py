"""Drawings of the concepts: `python -m benchmarks.guide.drawings [--out docs/pictures]`.

conventions.png: axes, angles and points of the bicycle, the wheel from above and from the side; stages.png: the stages of the
model and which effects of the catalogue correct what after each, read from the catalogue.
"""

from __future__ import annotations

import argparse
import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.guide.reference_effects import STAGES
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, TRUE, page
from softsoil.files.package_data import REFERENCE_VEHICLE
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle

OUT = Path(__file__).resolve().parents[2] / "docs" / "pictures"
GIVEN = {
    "inputs": "steering angle and rate, du/dt, wheel spins",
    "vehicle": "mass, axles, yaw inertia, heights",
    "loads": "front and rear axle load",
    "tracks": "each wheel: place, load, angle",
    "contacts": "each wheel: soil, velocity in the wheel plane",
    "forces": r"each wheel: force law gives $F_x$, $F_y$, sinkage",
    "balance": "lateral force and yaw moment",
    "rates": r"rates of $x$, $y$, $\psi$, $u$, $v$, $\omega_z$",
    "outputs": "what the sensors read",
}
"""Stage -> what it computes (docstring of symbolic/bicycle.py)."""


def draw_conventions(path: Path) -> Path:
    """Write the drawing of axes, wheel and slip to `path`."""
    mosaic = [["vehicle", "vehicle"], ["above", "side"]]
    with page(path, "", 7.6, 7.6, mosaic=mosaic, height_ratios=(1.15, 1.0)) as axes:
        for axis in axes.values():
            axis.set_axis_off()
            axis.set_aspect("equal")
        _vehicle(axes["vehicle"])
        _wheel_above(axes["above"])
        _wheel_side(axes["side"])
    return path


def _arrow(axis: Any, start: Any, end: Any, color: str, text: str = "", shift: Any = (4, 4)) -> None:
    """An arrow from start to end with its text near the end."""
    axis.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.6, "shrinkA": 0, "shrinkB": 0})
    if text:
        axis.annotate(text, end, shift, textcoords="offset points", color=color, fontsize=11)


def _turned(points: Any, angle: float, at: Any) -> np.ndarray:
    """Points (N, 2) turned by an angle (rad) and moved to `at`."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(points) @ np.array([[cos, sin], [-sin, cos]]) + np.asarray(at)


def _box(axis: Any, angle: float, at: Any, length: float, width: float, color: str) -> None:
    corners = [(-length / 2, -width / 2), (length / 2, -width / 2), (length / 2, width / 2), (-length / 2, width / 2)]
    axis.fill(*_turned(corners, angle, at).T, facecolor=color, alpha=0.25, edgecolor=color, lw=1.4)


def _arc(axis: Any, at: Any, radius: float, start: float, stop: float, color: str, text: str = "") -> None:
    angles = np.linspace(start, stop, 30)
    axis.plot(at[0] + radius * np.cos(angles), at[1] + radius * np.sin(angles), color=color, lw=1.2)
    middle = 0.5 * (start + stop)
    axis.text(at[0] + 1.13 * radius * np.cos(middle), at[1] + 1.13 * radius * np.sin(middle), text, color=color, fontsize=11)


def _vehicle(axis: Any) -> None:
    """The bicycle from above: (x, y) on the front axle, (u, v) at the centre of gravity."""
    psi, delta, front, rear = 0.42, 0.38, 1.55, -1.2
    at = np.array([1.6, 1.3])
    ahead, left = np.array([np.cos(psi), np.sin(psi)]), np.array([-np.sin(psi), np.cos(psi)])
    _arrow(axis, (-0.4, 0.0), (0.7, 0.0), SOFT, "$x$ (world)", (0, -14))
    _arrow(axis, (-0.4, 0.0), (-0.4, 1.1), SOFT, "$y$ (world)", (-8, 6))
    axis.plot(*zip(at + rear * ahead, at + front * ahead, strict=True), color=TRUE, lw=2)
    for place, turn, color in ((front, delta, ESTIMATED), (rear, 0.0, REAR)):
        _box(axis, psi + turn, at + place * ahead, 0.75, 0.24, color)
    axis.plot(*at, "o", color=TRUE, ms=6)
    axis.plot(*(at + front * ahead), "s", color=TRUE, ms=5)
    axis.annotate("$(x, y)$, front axle", at + front * ahead, (2, -22), textcoords="offset points", fontsize=10)
    axis.annotate("centre of gravity", at, (6, -14), textcoords="offset points", fontsize=10)
    _arrow(axis, at, at + 0.85 * ahead, INITIAL, "$u$", (-16, 2))
    _arrow(axis, at, at + 0.6 * left, INITIAL, "$v$")
    start = at + rear * ahead
    axis.plot(*zip(start, start + (1.5, 0.0), strict=True), color=SOFT, ls=":", lw=1.2)
    _arc(axis, start, 1.0, 0.0, psi, TRUE)
    axis.text(*(start + (0.72, 0.08)), r"$\psi$", color=TRUE, fontsize=11)
    end = at + front * ahead
    axis.plot(*zip(end, end + 1.3 * ahead, strict=True), color=SOFT, ls=":", lw=1.2)
    turned = np.array([np.cos(psi + delta), np.sin(psi + delta)])
    axis.plot(*zip(end, end + 1.3 * turned, strict=True), color=ESTIMATED, ls=":", lw=1.2)
    _arc(axis, end, 1.0, psi, psi + delta, ESTIMATED, r"$\delta$")
    angles = np.linspace(psi + 0.5, psi + 1.3, 30)
    curve = at[:, None] + 0.42 * np.array([np.cos(angles), np.sin(angles)])
    axis.plot(*curve, color=TRUE, lw=1.3)
    _arrow(axis, curve[:, -3], curve[:, -1], TRUE)
    axis.annotate(r"$\omega_z$", curve[:, 15], (4, 4), textcoords="offset points", fontsize=11)
    for place, name in ((front / 2, "$l_f$"), (rear / 2, "$l_r$")):
        axis.annotate(name, at + place * ahead, (4, -17) if place > 0 else (-12, 8), textcoords="offset points", fontsize=11)
    axis.set(xlim=(-1.6, 5.0), ylim=(-0.4, 3.0))
    axis.set_title("Vehicle from above, ISO 8855")


def _wheel_above(axis: Any) -> None:
    """The slip angle: course against the wheel plane."""
    _box(axis, np.pi / 2, (0.0, 0.0), 1.5, 0.55, ESTIMATED)
    _arrow(axis, (0, 0), (0, 1.45), TRUE, "$x$, wheel plane", (-40, 8))
    _arrow(axis, (0, 0), (-1.0, 0), TRUE, "$y$", (-4, 6))
    course = np.array([np.sin(0.4), np.cos(0.4)])
    _arrow(axis, (0, 0), 1.5 * course, INITIAL, "velocity", (4, -4))
    _arc(axis, (0, 0), 1.0, np.pi / 2 - 0.4, np.pi / 2, INITIAL)
    axis.text(0.55, 0.95, r"$\alpha > 0$", color=INITIAL, fontsize=11)
    _arrow(axis, (0, -0.05), (-0.75, -0.05), REAR, "$F_y > 0$", (-22, -16))
    axis.text(0, -1.25, r"$v_y = -|v| \sin\alpha$", ha="center", fontsize=11)
    axis.set(xlim=(-2.0, 2.0), ylim=(-1.5, 1.9))
    axis.set_title("Wheel from above: slip angle")


def _wheel_side(axis: Any) -> None:
    """Longitudinal slip and sinkage: rim speed against forward speed."""
    radius, sinkage = 1.0, 0.28
    angles = np.linspace(0, 2 * np.pi, 200)
    soil = -radius + sinkage
    half = np.sqrt(radius**2 - soil**2)
    under = np.linspace(-0.3 * half, half, 60)
    ground = np.concatenate([[-1.0 + 0.06] * 2, -np.sqrt(radius**2 - under**2), [soil] * 2])
    axis.fill_between(np.concatenate([[-1.9, -0.36], under, [half, 2.6]]), ground, -1.6, color=REAR, alpha=0.25, lw=0)
    axis.plot(radius * np.cos(angles), radius * np.sin(angles), color=ESTIMATED, lw=1.8)
    axis.plot([0], [0], "o", color=TRUE, ms=5)
    _arrow(axis, (0, 0), (1.5, 0), INITIAL, "$v_x$", (-4, 6))
    turn = np.linspace(2.3, 0.9, 30)
    axis.plot(0.55 * np.cos(turn), 0.55 * np.sin(turn), color=TRUE, lw=1.3)
    _arrow(axis, (0.55 * np.cos(0.95), 0.55 * np.sin(0.95)), (0.55 * np.cos(0.8), 0.55 * np.sin(0.8)), TRUE, r"$\omega$", (4, 2))
    axis.annotate("", (1.35, soil), (1.35, -1.0), arrowprops={"arrowstyle": "<->", "color": TRUE, "shrinkA": 0, "shrinkB": 0})
    axis.text(1.45, -0.95, "sinkage $h$", fontsize=10)
    axis.plot([0.1, 1.45], [-1.0, -1.0], color=TRUE, lw=0.8, ls=":")
    axis.text(0, -1.95, r"driving: $s = 1 - v_x/(r\omega)$", ha="center", fontsize=11)
    axis.text(0, -2.3, r"braking: $s = r\omega/v_x - 1$", ha="center", fontsize=11)
    axis.set(xlim=(-1.9, 2.6), ylim=(-2.5, 1.5))
    axis.set_title("Wheel from the side: slip, sinkage")


def draw_stages(path: Path) -> Path:
    """Write the figure of the model's stages, with the effects that correct each, to `path`."""
    vehicle = load_vehicle(REFERENCE_VEHICLE)
    stages = [stage.name for stage in nominal_bicycle(vehicle, CLAY).stages]
    known = catalogue(vehicle)
    acting = {stage: [e.name.replace("_", " ") for e in known.values() if stage in e.corrections] for stage in stages}
    lines = {stage: textwrap.wrap(", ".join(names) or "none", 52) for stage, names in acting.items()}
    heights = [0.28 + 0.19 * max(2, len(lines[stage])) for stage in stages]
    with page(path, "", 7.6, 0.35 + sum(heights)) as axis:
        axis.set_axis_off()
        top = 0.0
        for stage, height in zip(stages, heights, strict=True):
            low = top - height + 0.12
            axis.fill([0, 3.3, 3.3, 0], [low, low, top, top], facecolor=ESTIMATED, alpha=0.14, edgecolor=ESTIMATED)
            words = 0.5 * (low + top)
            axis.text(0.1, words + 0.02, stage, va="bottom", fontsize=10.5, fontweight="bold", color=TRUE)
            axis.text(0.1, words - 0.01, GIVEN.get(stage, STAGES.get(stage, "")), va="top", fontsize=9, color=TRUE)
            axis.text(3.5, words, "\n".join(lines[stage]), va="center", fontsize=9, color=TRUE)
            if stage != stages[-1]:
                _arrow(axis, (1.65, low), (1.65, low - 0.12), TRUE)
            top = low - 0.12
        axis.text(0, 0.12, "stage, in order of evaluation", fontsize=9, color=SOFT)
        axis.text(3.5, 0.12, "effects of the catalogue that may correct it", fontsize=9, color=SOFT)
        axis.set(xlim=(-0.05, 7.5), ylim=(top, 0.25))
    return path


def main() -> None:
    """Write both drawings."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--out", type=Path, default=OUT)
    out = options.parse_args().out
    print(f"wrote {draw_conventions(out / 'conventions.png')}")
    print(f"wrote {draw_stages(out / 'stages.png')}")


if __name__ == "__main__":
    main()
