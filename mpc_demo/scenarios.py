"""Courses for the closed loop: a path, a speed, obstacles, and the soil under them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from plant.soil_field import SoilField
from symbolic.soil import CLAY, SANDY_LOAM, Soil

Array = NDArray[np.float64]

SPACING = 0.25
"""m between the points of a path."""
WARM_UP = 45.0
"""m: at the beginning of every course, a gentle weave on which the soil may be learnt; nothing is judged there."""
GUESS_OFF = 0.25
"""How far above the truth the wrong first guess of n stands."""


@dataclass(frozen=True)
class Path:
    """A path by its points (M, 2) (m), equally spaced closely enough to be taken as a curve.

    s (M,): length along it; psi (M,): course (rad, unwrapped).
    """

    points: Array

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 2 or len(self.points) < 2:
            raise ValueError(f"path: expected points (M, 2), M >= 2, found shape {self.points.shape}")
        moves = np.diff(self.points, axis=0)
        s = np.concatenate([[0.0], np.cumsum(np.hypot(*moves.T))])
        psi = np.unwrap(np.arctan2(np.gradient(self.points[:, 1]), np.gradient(self.points[:, 0])))
        object.__setattr__(self, "s", s)
        object.__setattr__(self, "psi", psi)

    s: Array = field(init=False)
    psi: Array = field(init=False)

    def at(self, s: Array) -> Array:
        """(K, 3) x, y, psi at lengths s (K,); straight on beyond the end."""
        beyond = np.maximum(s - self.s[-1], 0.0)
        end = self.psi[-1]
        x = np.interp(s, self.s, self.points[:, 0]) + beyond * np.cos(end)
        y = np.interp(s, self.s, self.points[:, 1]) + beyond * np.sin(end)
        return np.stack([x, y, np.interp(s, self.s, self.psi)], axis=1)

    def project(self, x: float, y: float, near: float | None = None, reach: float = 8.0) -> tuple[float, float]:
        """(length along the path, distance left of it) of the nearest point; `near`: only within `reach` m of there."""
        squares = (self.points[:, 0] - x) ** 2 + (self.points[:, 1] - y) ** 2
        if near is not None:
            squares = np.where(np.abs(self.s - near) <= reach, squares, np.inf)
        i = int(np.argmin(squares))
        cos, sin = np.cos(self.psi[i]), np.sin(self.psi[i])
        dx, dy = x - self.points[i, 0], y - self.points[i, 1]
        return float(self.s[i] + cos * dx + sin * dy), float(cos * dy - sin * dx)


@dataclass(frozen=True)
class Scenario:
    """One course.

    name; soil: under the course, as the plant has it; believed: class that the controllers know (all but n);
    n_true: what the controller with the true n is told, by place along x (m); n_guess: the wrong first guess;
    path; speed: m/s; obstacles: (K, 5) x, y, radius (m) and velocity (m/s); why: what it is for.
    """

    name: str
    soil: SoilField
    believed: Soil
    n_true: Callable[[float], float]
    n_guess: float
    path: Path
    speed: float
    obstacles: Array
    why: str

    @property
    def seconds(self) -> float:
        """Time that the course takes at its speed (s)."""
        return float(self.path.s[-1] / self.speed)


def _curve(y: Callable[[Array], Array], length: float) -> Path:
    x = np.arange(0.0, length + SPACING, SPACING)
    return Path(np.stack([x, y(x)], axis=1))


def _smooth(t: Array) -> Array:
    """0 to 1 with two continuous derivatives."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 - 15.0 * t + 6.0 * t * t)


def _warm_up(x: Array) -> Array:
    """A gentle weave that begins and ends straight."""
    inside = _smooth(x / 8.0) * _smooth((WARM_UP - x) / 8.0)
    return 0.9 * inside * np.sin(2.0 * np.pi * x / 18.0)


def double_lane_change(width: float = 3.5, ramp: float = 13.5, hold: float = 9.0) -> Path:
    """To the left and back (after ISO 3888): ramps and hold in m."""
    first, back = WARM_UP + 3.0, WARM_UP + 3.0 + ramp + hold

    def y(x: Array) -> Array:
        return _warm_up(x) + width * (_smooth((x - first) / ramp) - _smooth((x - back) / ramp))

    return _curve(y, back + ramp + 22.0)


def slalom(amplitude: float = 1.6, wave: float = 26.0, waves: int = 3) -> Path:
    """A sine of `wave` m, `waves` times."""
    stop = WARM_UP + 3.0 + waves * wave

    def y(x: Array) -> Array:
        inside = _smooth((x - WARM_UP) / (wave / 3)) * _smooth((stop - x) / (wave / 3))
        return _warm_up(x) + amplitude * inside * np.sin(2.0 * np.pi * (x - WARM_UP - 3.0) / wave)

    return _curve(y, stop + 12.0)


def straight(length: float = 60.0) -> Path:
    """Straight on after the warm-up."""
    return _curve(_warm_up, WARM_UP + length)


NONE = np.zeros((0, 5))


def _field(gap: float) -> Array:
    """Obstacles in the way, `gap` m apart along it, their edges just over the middle line."""
    places = [(WARM_UP + 12.0, 0.5, 1.0), (WARM_UP + 12.0 + gap, -0.6, 1.0), (WARM_UP + 12.0 + 2 * gap, 0.4, 1.0)]
    return np.array([(x, y, r, 0.0, 0.0) for x, y, r in places])


def scenarios() -> dict[str, Scenario]:
    """Every course by name."""
    found = {}
    for soil, speed, gap in ((CLAY, 6.0, 15.5), (SANDY_LOAM, 7.0, 14.0)):
        n = float(soil.n)
        guess = n + GUESS_OFF
        uniform = SoilField.uniform(soil)
        for name, path, pace, obstacles, why in (
            ("lane_change", double_lane_change(), speed, NONE, "near the limit of the soil's lateral force"),
            ("obstacles", straight(), speed - 1.0, _field(gap), "passing obstacles on both sides, with little room"),
            ("slalom", slalom(), speed - 1.0, NONE, "steady turning to both sides"),
        ):
            key = f"{name}_{soil.name}"
            found[key] = Scenario(key, uniform, soil, lambda x, n=n: n, guess, path, pace, obstacles, why)  # type: ignore[misc]
    found["soil_change"] = _soil_change()
    return found


def _soil_change() -> Scenario:
    border = WARM_UP + 3.0 + 26.0
    after = CLAY.with_(n=0.75)
    return Scenario(
        "soil_change", SoilField.change_at(CLAY, after, border), CLAY,
        lambda x: 0.5 if x < border else 0.75, 0.5, slalom(waves=4), 5.0, NONE,
        "clay whose n goes from 0.5 to 0.75 in mid-course; the guess knows only the first",
    )  # fmt: skip
