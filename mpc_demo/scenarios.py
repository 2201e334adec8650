"""Courses for the closed loop: a path, a speed, obstacles, and the soil under them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.control.courses import WARM_UP, double_lane_change, slalom, straight
from softsoil.control.path import Path
from softsoil.plant.soil_field import SoilField
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, Soil
from softsoil.symbolic.vehicle import Vehicle

Array = NDArray[np.float64]

GUESS_OFF = 0.25
"""How far above the truth the wrong first guess of n stands."""
WHEELBASE = 2.721
"""m: of the vehicle for which the courses are laid out."""


@dataclass(frozen=True)
class Scenario:
    """One course.

    name; soil: under the course, as the plant has it; believed: class that the controllers know (all but n);
    n_true: the n of the controller with the true n, by place along x (m); n_guess: the wrong first guess;
    path; speed: m/s; obstacles: (K, 5) x, y, radius (m) and velocity (m/s); why: what it is for;
    warm_up: length at the beginning on which nothing is judged (m).
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
    warm_up: float = WARM_UP

    @property
    def seconds(self) -> float:
        """Time that the course takes at its speed (s)."""
        return float(self.path.s[-1] / self.speed)


NONE = np.zeros((0, 5))


def _field(gap: float, warm_up: float) -> Array:
    """Obstacles in the way, `gap` m apart along it after warm_up m, their edges just over the middle line."""
    places = [(warm_up + 12.0, 0.5, 1.0), (warm_up + 12.0 + gap, -0.6, 1.0), (warm_up + 12.0 + 2 * gap, 0.4, 1.0)]
    return np.array([(x, y, r, 0.0, 0.0) for x, y, r in places])


def scenarios(size: float = 1.0, warm_up: float = WARM_UP) -> dict[str, Scenario]:
    """Every course by name, for a vehicle `size` times as long as the reference vehicle (`size_of`).

    warm_up: length of the weave before each, for a vehicle of size 1 (m). Lengths grow with the size and speeds with its root,
    which leaves the accelerations as they are (Froude's similarity).
    Raises ValueError for a size that is not positive.
    """
    if not size > 0:
        raise ValueError(f"scenarios: expected size > 0, found {size}")
    found = {}
    changing, ahead, turning = double_lane_change(warm_up=warm_up), straight(warm_up=warm_up), slalom(warm_up=warm_up)
    for soil, speed, gap in ((CLAY, 6.0, 15.5), (SANDY_LOAM, 7.0, 14.0)):
        n = float(soil.n)
        guess = n + GUESS_OFF
        uniform = SoilField.uniform(soil)
        for name, path, pace, obstacles, why in (
            ("lane_change", changing, speed, NONE, "near the limit of the soil's lateral force"),
            ("obstacles", ahead, speed - 1.0, _field(gap, warm_up), "passing obstacles on both sides, with little room"),
            ("slalom", turning, speed - 1.0, NONE, "steady turning to both sides"),
        ):
            key = f"{name}_{soil.name}"
            known = lambda x, n=n: n  # noqa: E731
            course = Scenario(key, uniform, soil, known, guess, path, pace, obstacles, why, warm_up)
            found[key] = _enlarged(course, size)
    found["two_soils"] = _enlarged(_two_soils(size, warm_up), size)
    return found


def size_of(vehicle: Vehicle) -> float:
    """Length of a vehicle over that of the reference vehicle, by their wheelbases and to a tenth."""
    return max(round(vehicle.wheelbase / WHEELBASE, 1), 0.1)


def _enlarged(course: Scenario, size: float) -> Scenario:
    """The course `size` times as long and wide."""
    root = np.sqrt(size)
    obstacles = course.obstacles * [size, size, size, root, root]
    path = Path(size * course.path.points)
    return replace(course, path=path, speed=root * course.speed, obstacles=obstacles, warm_up=size * course.warm_up)


def _two_soils(size: float, warm_up: float) -> Scenario:
    border = size * (warm_up + 3.0 + 26.0)
    after = CLAY.with_(n=0.75)
    return Scenario(
        "two_soils", SoilField.change_at(CLAY, after, border), CLAY,
        lambda x: 0.5 if x < border else 0.75, 0.5, slalom(waves=4, warm_up=warm_up), 5.0, NONE,
        "clay whose n goes from 0.5 to 0.75 in mid-course; the guess knows only the first", warm_up,
    )  # fmt: skip
