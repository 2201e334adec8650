"""Clean drives of every kind raise no doubt: gentle, fast, repeated, with and without sensor noise."""

from functools import lru_cache

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.checking.cross_check import check_channels
from softsoil.control.courses import double_lane_change, slalom
from softsoil.plant.effects import Effects
from softsoil.plant.manoeuvres import PathFollower
from softsoil.plant.simulate import simulate
from softsoil.plant.start import Start
from softsoil.recording.noise import add_noise
from softsoil.symbolic.soil import SOILS

COURSES = {"lane change": double_lane_change, "slalom": slalom}


@lru_cache
def clean(manoeuvre, speed, soil):
    driver = PathFollower(COURSES[manoeuvre]().points) if manoeuvre in COURSES else manoeuvre
    return simulate(driver, SOILS[soil], 20.0, start=Start(u=speed), seed=1)


@pytest.mark.parametrize("noise", [None, "good", "table5"])
@pytest.mark.parametrize("soil", ["clay", "sandy_loam"])
@pytest.mark.parametrize(
    ("manoeuvre", "speed"),
    [("path", 2.5), ("path", 5.5), ("multi", 4.5), ("steps", 7.0), ("chirp", 2.5), ("paper", 4.5), ("lane change", 7.0),
     ("slalom", 2.5)],
)  # fmt: skip
def test_no_channel_is_doubted(manoeuvre, speed, soil, noise):
    drive = clean(manoeuvre, speed, soil)
    recording = drive if noise is None else add_noise(drive, noise, 3)
    doubted = [check.sentence() for check in check_channels(recording, reference_vehicle()) if not check.passed]
    assert not doubted


def test_a_lateral_velocity_that_is_mostly_noise_is_not_doubted():
    """Its noise draws its scale towards zero where the other channels are clean."""
    drive = simulate("path", SOILS["sandy_loam"], 20.0, start=Start(u=5.0), seed=1)
    noisy = drive.with_channels(v=drive["v"] + 0.25 * np.random.default_rng(0).standard_normal(len(drive)))
    assert not [check.sentence() for check in check_channels(noisy, reference_vehicle()) if not check.passed]


@pytest.mark.parametrize("noise", [None, "table5"])
def test_of_a_straight_drive_only_the_want_of_steering_is_said(noise):
    drive = simulate("straight", SOILS["clay"], 20.0, start=Start(u=2.5), seed=1)
    recording = drive if noise is None else add_noise(drive, noise, 3)
    assert {c.name for c in check_channels(recording, reference_vehicle()) if not c.passed} == {"steered"}


def test_a_flipped_lateral_velocity_of_a_gentle_drive_is_beyond_doubt():
    """Where v is nearly in step with the yaw rate, a scale of it says little, its sign still enough."""
    drive = simulate("path", SOILS["clay"], 20.0, start=Start(u=5.5), seed=1)
    wrong = [c for c in check_channels(drive.with_channels(v=-drive["v"]), reference_vehicle()) if c.beyond_doubt]
    assert any(check.channel == "v" for check in wrong)


def test_a_load_leaves_the_sensors_consistent():
    """The accelerometer stays on the vehicle, whatever lies behind it."""
    effects = Effects(payload=500.0, payload_at=(-2.6, 0.0, 1.0))
    drive = simulate("multi", SOILS["clay"], 20.0, start=Start(u=4.5), effects=effects, seed=1)
    found = {c.name: c for c in check_channels(drive, reference_vehicle())}
    assert found["accelerometer_y"].passed and found["lateral_velocity_rate"].passed


@pytest.mark.parametrize(
    ("scale", "said"), [(1.0, True), (0.4, True), (-1.0, False), (1 / 9.80665, False), (9.80665, False)]
)
def test_without_v_only_a_flipped_or_mistaken_accelerometer_is_doubted(scale, said):
    """A vehicle that slides turns up to three quarters of u omega_z into dv/dt, which nothing shows without v."""
    drive = simulate("multi", SOILS["clay"], 20.0, start=Start(u=4.5), seed=1)
    drive = drive.with_channels(v=np.full(len(drive), np.nan), a_y_imu=scale * drive["a_y_imu"])
    check = {c.name: c for c in check_channels(drive, reference_vehicle())}["accelerometer_y"]
    assert check.passed is said and check.beyond_doubt is not said
