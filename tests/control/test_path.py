"""Paths as they are recorded: with stops in them, closed, short, and driven beyond their end."""

import numpy as np
import pytest

from driven_vehicle import ModelVehicle, driven
from softsoil.control.path import Path

NORTH = np.column_stack([np.zeros(41), 0.5 * np.arange(41.0)])


@pytest.mark.parametrize("at", [0, 7, 40])
@pytest.mark.parametrize("times", [2, 3, 10])
def test_a_point_that_stands_several_times_has_the_course_of_the_way(at, times):
    """It was east: a vehicle left the end of a path that was recorded with a stop."""
    path = Path(np.insert(NORTH, [at] * (times - 1), NORTH[at], axis=0))
    np.testing.assert_allclose(path.psi, np.pi / 2, atol=1e-12)
    np.testing.assert_allclose(path.at(np.array([25.0])), [[0.0, 25.0, np.pi / 2]], atol=1e-9)


def test_beyond_its_end_a_vehicle_is_beyond_its_end():
    """Farther than a vehicle is looked for, too: it was at the path's beginning."""
    path = Path(NORTH)
    for y in (21.0, 27.0, 29.0, 60.0):
        assert path.project(0.4, y, near=y - 0.5)[0] == pytest.approx(y)


def test_way_points_farther_apart_than_it_is_looked_for_are_passed_in_order():
    path, near = Path(np.array([[0.0, 0.0], [20.0, 0.0], [40.0, 0.0]])), None
    for x in np.arange(0.0, 39.0, 0.5):
        along, left = path.project(x, 0.1, near)
        assert along == pytest.approx(x) and left == pytest.approx(0.1)
        near = along


def test_a_drive_keeps_to_a_path_that_ends_in_a_stop():
    points = np.vstack([np.column_stack([np.zeros(80), 0.25 * np.arange(80.0)]), [[0.0, 0.25 * 79]] * 10])
    vehicle = ModelVehicle(y=0.0)
    vehicle.z[2] = np.pi / 2
    _, log = driven(vehicle, 5.0, path=Path(points))
    assert log.commands[-1].finished
    assert np.abs(log.column("left")).max() < 0.1 and np.abs(log.column("steer")).max() < 0.05
