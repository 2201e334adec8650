"""Circles: the commonest test drive there is, with nothing in it that varies but noise, is no log with wrong channels."""

import numpy as np
import pytest

import softsoil
from softsoil.checking.cross_check import check_channels, refuse_contradictions
from softsoil.plant.manoeuvres import Manoeuvre, Speed
from softsoil.plant.sensors import Sensors
from softsoil.plant.start import Start


class Held:
    """A steering angle that is held."""

    def __init__(self, angle):
        self.angle = angle

    def __call__(self, t):
        return self.angle + 0.0 * t


@pytest.fixture(scope="module", params=[(0.2, 4.0), (-0.3, 2.0)], ids=["left", "right, slow"])
def circle(request):
    angle, speed = request.param
    driver = Manoeuvre("circle", Held(angle), Speed(speed, wave=0.3))
    return softsoil.simulate(driver, softsoil.load_soil("clay"), 25.0, start=Start(u=speed))


def refused(drive, **channels):
    checks = check_channels(drive.with_channels(**channels), softsoil.load_vehicle("plant"))
    refuse_contradictions("log", checks)
    return ""


@pytest.mark.parametrize("noise", ["", "good", "table5"])
def test_a_right_one_is_not_refused(circle, noise):
    assert refused(Sensors(noise).apply(circle, 2) if noise else circle) == ""


@pytest.mark.parametrize(
    ("channel", "factor", "words"),
    [
        ("steer", -1.0, "steer"),
        ("steer", 0.1, "correct the unit of steer"),
        ("psi", -1.0, "psi|omega_z"),
        ("psi", 0.5, "psi"),
        ("omega_z", 180 / np.pi, "omega_z|psi"),
    ],
)
def test_a_wrong_one_is(circle, channel, factor, words):
    drive = Sensors("good").apply(circle, 2)
    with pytest.raises(ValueError, match=words):
        refused(drive, **{channel: factor * drive[channel]})
