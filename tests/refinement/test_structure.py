"""What is left of the axle forces: noise makes none of it."""

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.estimator.horizons import predict
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.residual import drive_residual
from softsoil.refinement.structure import _noisier, structure
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY

SOIL = CLAY.with_(n=0.5)


@pytest.mark.parametrize("noise", (pytest.param("good", marks=pytest.mark.study), "table5"))
def test_sensor_noise_is_nothing_that_a_model_lacks(noise):
    vehicle = reference_vehicle()
    model = bicycle(vehicle, SOIL)
    found = structure(add_noise(read_drive(MULTI_LOG), noise, 2), model, vehicle, model.p.nominal, 2.0)
    assert found.judged and not found.left


def test_noise_that_is_added_once_more_is_not_the_log_s_own():
    """Of a log made with noise of the same number, as by --noise with --seed 0."""
    clean = read_drive(MULTI_LOG)
    noisy = add_noise(clean, "good", 0)
    own, more = (one["u"] - before["u"] for one, before in ((noisy, clean), (_noisier(noisy, 0), noisy)))
    assert abs(np.corrcoef(own, more)[0, 1]) < 0.1


@pytest.mark.parametrize("noise", (*(pytest.param(n, marks=pytest.mark.study) for n in ("none", "good")), "table5"))
def test_a_force_that_a_model_lacks_is_left_whatever_the_noise(noise):
    """A steering 0.06 rad off."""
    vehicle = reference_vehicle()
    model = bicycle(vehicle, SOIL)
    drive = read_drive(MULTI_LOG)
    pushed = drive.with_channels(steer=drive["steer"] + 0.06)
    found = structure(add_noise(pushed, noise, 2), model, vehicle, model.p.nominal, 2.0)
    assert found.left and np.isfinite(found.share["front"])


@pytest.mark.study
@pytest.mark.parametrize(
    ("effect", "size"),
    [("lever_arm", {"velocity_lever": 0.86, "position_lever": 0.0}), ("gyro_bias", {"gyro_bias": 0.02})],
    ids=lambda v: str(v)[:9],
)  # fmt: skip
def test_what_a_sensor_does_is_taken_off_where_the_model_has_it(effect, size):
    """Axle forces and predictions of a log whose sensor is elsewhere or biased are those of the right log."""
    vehicle = reference_vehicle()
    right = add_noise(read_drive(MULTI_LOG), "good", 2)
    seen = {"v": right["v"] + 0.86 * right["omega_z"]} if effect == "lever_arm" else {"omega_z": right["omega_z"] + 0.02}
    log = right.with_channels(**seen)
    plain, refined = (bicycle(vehicle, SOIL, "turn_slip", {**vehicle.effects, **more}) for more in ({}, {effect: size}))
    without, found, of_right = (
        drive_residual(*pair, vehicle).mse["2.5"]["v"] for pair in ((log, plain), (log, refined), (right, plain))
    )
    assert found == pytest.approx(of_right, rel=0.1)
    if effect == "lever_arm":
        assert without > 4.0 * of_right
    left = structure(log, refined, vehicle, refined.p.nominal, 2.0)
    assert not left.left and max(left.share.values()) < 0.1


@pytest.mark.study
def test_in_a_derived_channel_there_is_nothing_of_a_sensor():
    """A log without v: with a lever arm of its absent sensor declared, predictions are those without."""
    vehicle = reference_vehicle()
    log = read_drive(MULTI_LOG).between(0.0, 20.0)
    blind = Recording(log.name, {name: values for name, values in log.channels.items() if name != "v"})
    elsewhere = {"lever_arm": {"velocity_lever": 0.5, "position_lever": 0.0}}
    refined = bicycle(vehicle, SOIL, "turn_slip", {**vehicle.effects, **elsewhere})
    with_, without = (predict(blind, model, 0.5, 2.5).mse for model in (refined, bicycle(vehicle, SOIL)))
    assert with_["y"] == pytest.approx(without["y"], rel=1e-3) and with_["omega_z"] == pytest.approx(without["omega_z"], rel=1e-3)


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
