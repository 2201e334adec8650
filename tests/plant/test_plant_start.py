"""Where a drive of the plant begins, what its sensors take, and what a follower of a path remembers."""

import numpy as np
import pytest

from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import PathFollower, lane_change
from softsoil.plant.sensors import Sensors
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start, start_state
from softsoil.plant.state import POSITION
from softsoil.plant.world import Plant
from softsoil.symbolic.soil import CLAY, SAND


def test_a_vehicle_rests_on_the_soil_under_it():
    vehicle = load_plant_vehicle()
    field = SoilField.over(lambda x, y: CLAY if x < 20.0 else SAND, np.arange(0.0, 41.0), [0.0, 1.0])
    height = {x: start_state(Start(x=x, u=3.0), vehicle, field)[POSITION + 2] for x in (2.0, 38.0)}
    for x, soil in ((2.0, CLAY), (38.0, SAND)):
        alone = start_state(Start(x=x, u=3.0), vehicle, SoilField.uniform(soil))[POSITION + 2]
        assert height[x] == pytest.approx(alone, abs=1e-9)
    assert height[2.0] - height[38.0] > 0.02


@pytest.mark.parametrize(
    "wrong",
    [
        {"bias": {"steer": 0.05}}, {"scale": {"throttle": 0.5}}, {"delay": {"brake": 0.1}}, {"bias": {"t": 1.0}},
        {"noise": {"yaw_rate": 0.1}},
    ],
)  # fmt: skip
def test_what_no_sensor_does_is_refused(wrong):
    with pytest.raises(ValueError, match=f"sensors: {next(iter(wrong))}: expected some of"):
        Sensors(**wrong)
    Sensors(noise={"steer": 0.002, "u": 0.1}, bias={"omega_z": 0.01}, delay={"all": 0.02})


def test_a_follower_begins_its_path_anew():
    follower, sample = PathFollower(lane_change(80.0)), {"x": 0.0, "y": 0.0, "psi": 0.2, "u": 5.0}
    first = follower(np.zeros(1), sample)
    follower(np.full(1, 9.0), {**sample, "x": 60.0})
    np.testing.assert_array_equal(follower(np.zeros(1), sample), first)


def test_a_saved_plant_is_where_it_was_asked_to_be(tmp_path):
    plant = Plant(CLAY, start=Start(u=4.0))
    plant.save(tmp_path / "state")
    np.testing.assert_array_equal(Plant.load(tmp_path / "state").state, plant.state)
