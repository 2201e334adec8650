"""Obstacles: wherever on the globe they stand, and however many stand beside the path."""

import numpy as np
import pytest

from driven_vehicle import Braked, ModelVehicle, driven
from nmpc_problem import small_ocp
from softsoil.control.horizon import watched
from softsoil.control.nmpc_clearance import ABSENT, gaps_now, judged, placed, planned_gaps
from softsoil.control.nmpc_status import Status
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
    assert gaps[:, 0].min() == pytest.approx(-1.0 - (ocp.body - ocp.settings.margin), abs=0.2)
    assert np.isinf(planned_gaps(ocp, z, placed(ocp, None))).all()
    np.testing.assert_array_equal(placed(ocp, [[origin[0] + 3.0, origin[1], -0.5]]), placed(ocp, None))
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


def test_a_vehicle_that_is_close_beside_an_obstacle_drives_on():
    """Within the margin already, at a walking pace: every plan began there, none was clear, and it stood there for good."""
    ocp = small_ocp()
    for gap, goes in ((-0.04, True), (0.05, True)):
        vehicle = Braked(y=0.0)
        vehicle.z[:4] = [19.0, 0.0, 0.0, 2.0]
        aside = ocp.body - ocp.settings.margin + 0.6 + gap
        _, log = driven(vehicle, 4.0, path=Path(LINE), obstacles=[[17.5, aside, 0.6, 0.0, 0.0]])
        assert (vehicle.z[0] > 26.0 and not log.commands[-1].halt) is goes, gap
    ahead = Braked(y=0.0)
    ahead.z[:4] = [15.6, 0.0, 0.0, 2.0]
    _, log = driven(ahead, 3.0, path=Path(LINE), obstacles=[[17.2, 0.0, 0.6, 0.0, 0.0]])
    assert ahead.z[0] < 17.2 - 0.6 and log.commands[-1].halt, "one that would come nearer is none"


def test_a_plan_that_comes_no_nearer_than_now_touches_nothing():
    gaps = np.array([[-0.05, 0.5], [-0.05, 0.3], [0.2, 0.1]])

    def found(less=0.0, first=0.0):
        return judged(Status.CONVERGED, gaps - less, gaps[0] - [first, 0.0], -0.1)[::2]

    clear = (Status.CONVERGED, -1)
    assert found() == clear and found([[0.0, 0.0], [0.02, 0.0], [0.0, 0.0]]) == clear
    assert found([[0.0, 0.0], [0.04, 0.0], [0.0, 0.0]]) == (Status.BLOCKED, 1), "nearer by more than a little"
    assert found([[0.0, 0.0], [0.0, 0.0], [0.0, 0.11]]) == (Status.BLOCKED, 2), "another one"
    assert found([[0.0, 0.0], [0.06, 0.0], [0.0, 0.0]], 0.04) == (Status.BLOCKED, 1), "never beyond the nearest"
    assert found([[0.0, 0.0], [0.10, 0.0], [0.0, 0.0]], 0.10) == clear, "which it is already, and stays"
    ocp = small_ocp()
    z = ocp.z.pack(x=3.0, y=1.0, psi=0.5)
    ahead, left = np.array([np.cos(0.5), np.sin(0.5)]), np.array([-np.sin(0.5), np.cos(0.5)])
    there = np.array([[*(z[:2] - ahead + 2.0 * left), 0.5], ABSENT])
    assert gaps_now(ocp, z, there) == pytest.approx([1.5 - ocp.body + ocp.settings.margin, np.inf]), "straight beside it"
    assert judged(Status.CONVERGED, np.zeros((3, 0)), np.zeros(0), -0.1) == (Status.CONVERGED, np.inf, -1)


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
