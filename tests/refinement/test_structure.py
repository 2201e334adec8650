"""What is left of the axle forces: noise makes none of it."""

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.structure import structure
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY

SOIL = CLAY.with_(n=0.5)


@pytest.mark.parametrize("noise", ("good", "table5"))
def test_sensor_noise_is_nothing_that_a_model_lacks(noise):
    vehicle = reference_vehicle()
    model = bicycle(vehicle, SOIL)
    found = structure(add_noise(read_drive(MULTI_LOG), noise, 2), model, vehicle, model.p.nominal, 2.0)
    assert found.judged and not found.left


@pytest.mark.parametrize("noise", ("none", "good", "table5"))
def test_a_force_that_a_model_lacks_is_left_whatever_the_noise(noise):
    """A steering 0.06 rad off."""
    vehicle = reference_vehicle()
    model = bicycle(vehicle, SOIL)
    drive = read_drive(MULTI_LOG)
    pushed = drive.with_channels(steer=drive["steer"] + 0.06)
    found = structure(add_noise(pushed, noise, 2), model, vehicle, model.p.nominal, 2.0)
    assert found.left and np.isfinite(found.share["front"])


@pytest.mark.study
def test_a_pose_slower_than_the_log_judges_axle_forces_as_well():
    """Every third row, as an odometer beside an inertial sensor; a steering 0.06 rad off is left, the right one is not."""
    vehicle = reference_vehicle()
    model = bicycle(vehicle, SOIL)
    drive = add_noise(read_drive(MULTI_LOG), "good", 2)
    seen = np.arange(len(drive)) % 3 == 0
    slow = drive.with_channels(**{name: np.where(seen, drive[name], np.nan) for name in ("x", "y", "u", "v")})
    right = structure(slow, model, vehicle, model.p.nominal, 2.0)
    wrong = structure(slow.with_channels(steer=slow["steer"] + 0.06), model, vehicle, model.p.nominal, 2.0)
    assert right.judged and not right.left
    assert wrong.judged and wrong.left
