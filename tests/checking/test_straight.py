"""A lateral velocity without a turn is that of a sensor which is turned, or of a heading which is off."""

from dataclasses import replace

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.cross_check import check_channels
from softsoil.checking.straight import NAME
from softsoil.importing.earth_velocity import turned_by_heading
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive

VEHICLE = reference_vehicle()


def found(drive):
    """The check on a drive, None where there is none."""
    return next((check for check in check_channels(drive, VEHICLE) if check.name == NAME), None)


@pytest.fixture(scope="module")
def good():
    return add_noise(read_drive(MULTI_LOG).between(0.0, 25.0), "good", 1)


@pytest.mark.parametrize("turned", [0.06, -0.06])
def test_a_sensor_that_is_turned_is_said_with_its_cure(good, turned):
    u, v, cos, sin = good["u"], good["v"], np.cos(turned), np.sin(turned)
    check = found(good.with_channels(u=u * cos - v * sin, v=v * cos + u * sin))
    assert not check.passed and not check.beyond_doubt and check.channel == "v"
    offset, yaw = (float(check.cure.split(f"{key} = ")[1].split()[0]) for key in ("offset", "yaw"))
    assert offset == pytest.approx(turned, abs=0.01) and yaw == -offset


def test_the_offset_of_a_heading_that_turns_velocities_puts_it_right(good):
    """Of a receiver, turned by a heading that reads 0.06 rad too little."""
    psi = np.unwrap(good["psi"])
    east, north = good["u"] * np.cos(psi) - good["v"] * np.sin(psi), good["u"] * np.sin(psi) + good["v"] * np.cos(psi)
    ahead, aside = turned_by_heading(east, north, psi - 0.06, good.dt)
    check = found(good.with_channels(u=ahead, v=aside))
    offset = float(check.cure.split("offset = ")[1].split()[0])
    _, again = turned_by_heading(east, north, psi - 0.06 + offset, good.dt)
    assert not check.passed and np.mean(again - good["v"]) == pytest.approx(0.0, abs=0.05)


def test_a_right_one_passes_and_one_that_is_not_measured_is_not_asked(good):
    assert found(good).passed
    without = {name: values for name, values in good.channels.items() if name != "v"}
    assert found(replace(good, channels=without)) is None
