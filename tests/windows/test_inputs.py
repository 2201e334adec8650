"""Inputs and measurements from a log, noise by name, and the consistency measures."""

import numpy as np
import pytest

from drives import CLAY_LOG, clay_bicycle, clay_drive
from softsoil.estimator.consistency import inside_band, whiteness_p
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.forward import HELD_INPUTS
from softsoil.recording.noise import GOOD, NOISES, TABLE5, add_noise
from softsoil.recording.read import read_drive
from softsoil.recording.states import measured_states, sensor_std
from softsoil.symbolic.signals import Layout, Signal
from softsoil.windows.inputs import measured_inputs


def test_inputs_are_those_that_made_the_drive():
    drive = clay_drive()
    inputs, held = measured_inputs(drive, clay_bicycle().external)
    found = dict(zip(clay_bicycle().external.names, inputs.T, strict=True))
    assert held == {}
    assert np.array_equal(found["steer"], drive["steer"])
    assert np.allclose(found["steer_rate"][5:-5], np.gradient(drive["steer"], drive.dt)[5:-5], atol=2e-3)
    acceleration = np.gradient(drive["u"], drive.dt)
    assert np.allclose(found["a_x"][5:-5], acceleration[5:-5], atol=0.02)
    without_imu = {name: values for name, values in drive.channels.items() if name != "a_x_imu"}
    slow, _ = measured_inputs(type(drive)("d", without_imu), clay_bicycle().external)
    assert np.allclose(slow[20:-20, 2], acceleration[20:-20], atol=0.05)


@pytest.mark.parametrize("gap", [(8.0, 12.0), (14.0, 40.0)])
def test_where_the_accelerometer_is_silent_the_speed_says_how_it_changes(gap):
    """Its last value was held to the end of the log."""
    drive = clay_drive()
    silent = (drive.t > gap[0]) & (drive.t < gap[1])
    deaf = drive.with_channels(a_x_imu=np.where(silent, np.nan, drive["a_x_imu"]))
    column = clay_bicycle().external.index("a_x")
    whole, found = (measured_inputs(one, clay_bicycle().external)[0][:, column] for one in (drive, deaf))
    believed = (drive.t > gap[0]) & (drive.t < gap[0] + HELD_INPUTS)  # of the last value, at the end of a log
    assert np.abs(found - whole)[~believed][20:-20].max() < 0.06
    short = drive.with_channels(a_x_imu=np.where((drive.t > 8.0) & (drive.t < 8.1), np.nan, drive["a_x_imu"]))
    assert np.allclose(measured_inputs(short, clay_bicycle().external)[0][:, column], whole, atol=0.02)


def test_an_accelerometer_asks_nothing_of_the_speed():
    """Not even that there are enough rows for its slope."""
    drive = clay_drive(3.0)
    short = drive.with_channels(t=drive.t).between(0.0, 0.013)
    assert len(short) == 2
    found = measured_inputs(short, clay_bicycle().external)[0][:, clay_bicycle().external.index("a_x")]
    assert np.allclose(found, short["a_x_imu"] + short["v"] * short["omega_z"])


def test_a_step_of_the_steering_stays_a_step():
    drive = clay_drive(3.0)
    steer = np.where(drive.t < 1.5, 0.0, 0.2)
    inputs, _ = measured_inputs(drive.with_channels(steer=steer), clay_bicycle().external)
    rate = inputs[:, clay_bicycle().external.index("steer_rate")]
    assert np.count_nonzero(np.abs(rate) > 1e-9) <= 6
    assert np.sum(rate) * drive.dt == pytest.approx(0.2)


def test_missing_inputs_are_interpolated_and_counted():
    drive = clay_drive(3.0)
    steer = drive["steer"].copy()
    steer[100:110] = np.nan
    inputs, held = measured_inputs(drive.with_channels(steer=steer), clay_bicycle().external)
    assert held == {"steer": 10} and np.isfinite(inputs).all()
    assert np.allclose(inputs[:, 0], drive["steer"], atol=0.02)


def test_model_with_an_input_that_no_drive_has_is_named():
    with pytest.raises(ValueError, match="it has no 'moon'"):
        measured_inputs(clay_drive(3.0), Layout.of(Signal("moon", "", "phase")))


def test_heading_is_unwrapped_around_what_is_missing():
    drive = clay_drive(6.0)
    psi = np.angle(np.exp(1j * (drive["psi"] * 10 + 3)))
    psi[50:60] = np.nan
    states = measured_states(drive.with_channels(psi=psi))
    assert np.nanmax(np.abs(np.diff(states[:, 2]))) < 1.0 and np.isnan(states[50:60, 2]).all()


@pytest.mark.parametrize("noise", [TABLE5, GOOD], ids=["table5", "good"])
def test_sensor_noise_is_found_from_the_log_alone(noise):
    drive = add_noise(read_drive(CLAY_LOG), noise, 3)
    found = sensor_std(drive, np.full(6, 1e-6))
    assert np.allclose(found, [noise[name] for name in STATE_CHANNELS], rtol=0.1)


def test_noise_is_of_its_size_leaves_the_truth_and_repeats_with_its_seed():
    drive = read_drive(CLAY_LOG)
    noisy = add_noise(drive, "table5", 5)
    for name, sigma in TABLE5.items():
        assert np.std(noisy[name] - drive[name]) == pytest.approx(sigma, rel=0.06)
    assert np.array_equal(noisy["steer"], drive["steer"]) and noisy.truth is drive.truth
    assert np.array_equal(noisy["v"], add_noise(drive, "table5", 5)["v"])
    assert not np.array_equal(noisy["v"], add_noise(drive, "table5", 6)["v"])
    assert add_noise(drive, "none", 1)["x"] is drive["x"]
    with pytest.raises(ValueError, match="noise: expected one of none, table5, good"):
        add_noise(drive, "loud", 1)
    assert set(NOISES) == {"none", "table5", "good"}


def test_band_holds_what_it_says_and_nothing_without_freedom():
    values = np.random.default_rng(2).chisquare(6, 20000)
    assert inside_band(values, np.full(20000, 6)) == pytest.approx(0.95, abs=0.01)
    assert inside_band(3 * values, np.full(20000, 6)) < 0.6
    assert np.isnan(inside_band([1.0], [0]))


def test_whiteness_tells_white_from_coloured():
    rng = np.random.default_rng(3)
    white = np.array([whiteness_p(rng.standard_normal(300)) for _ in range(200)])
    assert 0.01 <= np.mean(white < 0.05) <= 0.12
    coloured = np.convolve(rng.standard_normal(400), np.ones(5) / 5, mode="valid")
    assert whiteness_p(coloured) < 1e-6
    assert np.isnan(whiteness_p([1.0, 2.0])) and np.isnan(whiteness_p(np.ones(50)))
