"""Obstacles: wherever on the globe they stand, and however many stand beside the path."""

import numpy as np
import pytest

from driven_vehicle import ModelVehicle, driven
from nmpc_problem import small_ocp
from softsoil.control.horizon import watched
from softsoil.control.nmpc_clearance import ABSENT, placed, planned_gaps
from softsoil.control.path import Path

ORIGINS = [(0.0, 0.0), (1100.0, 0.0), (2000.0, 3000.0), (-1000.0, 999.0)]
LINE = np.column_stack([np.arange(0.0, 40.0, 0.25), np.zeros(160)])


def trees(spare: float, step: float = 2.0) -> np.ndarray:
    """(K, 5) on both sides of the line, `spare` m from it, each of 0.3 m."""
    return np.array([[x, side * spare, 0.3, 0.0, 0.0] for x in np.arange(2.0, 40.0, step) for side in (1.0, -1.0)])


class Followed(ModelVehicle):
    """A vehicle whose way is kept."""

    way: list[np.ndarray]

    def apply(self, command, seconds):
        self.way = [*getattr(self, "way", []), self.z[:2].copy()]
        super().apply(command, seconds)


def moved(obstacles, origin) -> np.ndarray:
    return np.array(obstacles, dtype=float) + [*origin, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("origin", ORIGINS)
def test_a_plan_through_an_obstacle_touches_it_wherever_that_is(origin):
    ocp = small_ocp()
    z = np.zeros((ocp.settings.steps + 1, len(ocp.z)))
    z[:, :2] = np.array(origin) + LINE[: len(z)]
    there = placed(ocp, [[origin[0] + 3.0, origin[1], 1.0]])
    gaps = planned_gaps(ocp, z, there)
    assert gaps.min() == pytest.approx(-1.0 - (ocp.body - ocp.settings.margin), abs=0.2)
    assert np.isinf(planned_gaps(ocp, z, placed(ocp, None))).all()
    np.testing.assert_array_equal(there[:, 1:], np.tile(ABSENT, (len(z), ocp.settings.obstacles - 1, 1)))


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("beside", [None, 3.0])
def test_a_driver_passes_what_stands_on_its_path(origin, beside):
    """Two obstacles are watched: trees beside the path are not those two."""
    blocker = [[18.0, 0.2, 0.6, 0.0, 0.0]]
    obstacles = moved(blocker if beside is None else [*trees(beside), *blocker], origin)
    vehicle = Followed(y=0.4)
    vehicle.z[:2] += origin
    _, log = driven(vehicle, 7.0, path=Path(LINE + origin), obstacles=obstacles)
    way = np.array(vehicle.way)
    gaps = np.hypot(way[:, None, 0] - obstacles[:, 0], way[:, None, 1] - obstacles[:, 1]) - obstacles[:, 2]
    assert gaps.min() > 0.4, "the front axle stays clear of all"
    assert way[-1, 0] - origin[0] > 21.0 or log.commands[-1].halt


def test_what_stands_on_the_path_is_watched_before_what_stands_beside_it():
    ocp = small_ocp()
    ref = np.zeros((ocp.settings.steps + 1, 4))
    ref[:, 0] = np.linspace(0.0, 12.0, len(ref))
    z = ocp.z.pack(u=5.0)
    on, far, behind = [11.0, 0.1, 0.5, 0.0, 0.0], [11.0, 9.0, 0.5, 0.0, 0.0], [-8.0, 0.0, 0.5, 0.0, 0.0]
    crossing = [12.0, 20.0, 0.5, 0.0, -20.0 / (ocp.settings.dt * ocp.settings.steps)]
    seen = watched(ocp, np.array([*trees(3.0), far, on, behind]), 0.0, z, ref)
    assert seen.shape[1] == ocp.settings.obstacles
    np.testing.assert_array_equal(seen[0, 0], on[:3])
    assert watched(ocp, np.array([behind]), 0.0, z, ref).shape[1] == 0
    seen = watched(ocp, np.array([*trees(3.0), crossing]), 0.0, z, ref)
    np.testing.assert_array_equal(seen[0, 0], crossing[:3])
    beside = watched(ocp, np.array([[1.0, 1.5, 0.3, 0.0, 0.0], far]), 0.0, z, ref)
    assert len(beside[0]) == 2, "as many as there are"
