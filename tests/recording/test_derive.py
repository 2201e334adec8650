"""Absent channels are derived from the others, marked, and near what was left out."""

from dataclasses import replace

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.estimator.terrain import estimate_terrain
from softsoil.recording.derive import completed
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Recording
from softsoil.recording.laid_heading import laid_heading
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive, write_drive
from softsoil.recording.states import known_states, measured_states
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY


@pytest.fixture(scope="module")
def good():
    return read_drive(MULTI_LOG)


def without(drive, *names):
    return replace(drive, channels={k: v for k, v in drive.channels.items() if k not in names})


@pytest.mark.parametrize(("absent", "alone"), [("x", "y"), ("y", "x")])
def test_a_coordinate_that_stands_alone_is_set_aside_and_said(good, absent, alone):
    notes = completed(without(good, absent), reference_vehicle()).notes
    assert f"{absent}: not in the log; dead reckoning from speed and heading, from zero" in notes
    assert f"{alone}: set aside, since it stands alone; dead reckoning from speed and heading, from zero" in notes


@pytest.mark.parametrize(
    ("dropped", "channel", "most"),
    [
        (("v",), "v", 0.012),
        (("v", "a_y_imu"), "v", 0.02),
        (("v", "x", "y", "psi"), "v", 0.04),
        (("psi", "x", "y"), "psi", 0.01),
        (WHEEL_CHANNELS, "omega_rr", 1.5),  # as it rolls freely: the slip is the model's
        (WHEEL_CHANNELS[:3], "omega_rl", 1.5),
    ],
)
def test_a_derived_channel_is_near_the_measured_one(good, dropped, channel, most):
    drive = completed(without(good, *dropped), reference_vehicle())
    rows = slice(200, None)
    error = drive[channel][rows] - good[channel][rows]
    if channel == "psi":
        error = error - error[0]
    assert np.sqrt(np.mean(error**2)) < most
    assert drive.state_of(channel) == "derived" and not drive.measured(channel)
    assert any(note.startswith(channel) or channel in note for note in drive.notes)


@pytest.mark.parametrize("names", [("psi",), ("x", "y")])
@pytest.mark.parametrize("gap", [(6.0, 14.0), (12.0, np.inf), (0.0, 8.0)])
def test_where_positions_or_heading_are_missing_for_a_while_v_is_that_of_the_rear_axle(good, names, gap):
    """A heading that is held, or a line between positions, is no motion: v was up to 2 m/s off there."""
    drive = good.between(0.0, 20.0)
    out = (drive.t >= gap[0]) & (drive.t <= gap[1])
    cut = without(drive.with_channels(**{name: np.where(out, np.nan, drive[name]) for name in names}), "v")
    found = completed(cut, reference_vehicle())
    assert np.sqrt(np.mean((found["v"] - drive["v"])[out & (drive.t > 2.0)] ** 2)) < 0.08
    assert np.abs(found["v"] - drive["v"])[drive.t > 2.0].max() < 0.2, "nor at the rim"
    assert any(note.startswith("v: ") and "s without them the rear axle" in note for note in found.notes)


@pytest.mark.parametrize("rows", [2, 3, 6, 11])
def test_a_few_rows_are_completed_too(good, rows):
    short = Recording("short", {name: without(good, "v")[name][:rows] for name in without(good, "v").channels})
    assert np.isfinite(completed(short, reference_vehicle())["v"]).all()


def test_an_accelerometer_that_only_shows_spikes_is_none(good):
    spiky = without(good.with_channels(a_y_imu=np.full(len(good), 13.0)), "v", "psi")
    assert np.isfinite(completed(spiky, reference_vehicle())["v"]).all()


@pytest.mark.parametrize("turn", [0.0, 3.0])
@pytest.mark.parametrize("noise", ["good", "table5"])
def test_a_heading_is_laid_on_positions_of_any_frame(good, turn, noise):
    """East and north of a receiver beside a gyro with a bias: no compass."""
    noisy = add_noise(good, noise, 4)
    x, y = np.cos(turn) * noisy["x"] - np.sin(turn) * noisy["y"], np.sin(turn) * noisy["x"] + np.cos(turn) * noisy["y"]
    log = without(noisy.with_channels(x=x, y=y, omega_z=noisy["omega_z"] + 0.01), "psi")
    drive = completed(log, reference_vehicle())
    away = np.angle(np.exp(1j * (drive["psi"] - good["psi"] - turn)))
    assert np.abs(away).max() < 0.015 and drive.state_of("psi") == "derived" and drive.measured("x", "y")
    assert "psi: not in the log; the integral of the yaw rate, aligned with the positions" in drive.notes


def test_a_heading_of_an_hour_with_a_gyro_that_wanders_and_stops_is_laid():
    """Bias from 0 to 0.01 rad/s, 18 rad in all, and two minutes of standing."""
    dt = 0.05
    t = np.arange(0.0, 3600.0, dt)
    u = np.where((t > 1000.0) & (t < 1120.0), 0.0, 4.0)
    omega = 0.05 * u * np.sin(2 * np.pi * t / 11.0)
    psi = np.cumsum(omega) * dt + 1.0
    noise = np.random.default_rng(2).normal(0.0, 0.05, (2, len(t)))
    path = np.cumsum(u * np.exp(1j * psi)) * dt + noise[0] + 1j * noise[1]
    laid = laid_heading(path.real, path.imag, u, 0.0 * u, omega + 0.01 * t / t[-1], dt)
    assert laid is not None and not laid.scattered and laid.agreement > 0.97
    away = np.angle(np.exp(1j * (laid.psi - psi)))
    assert np.abs(away[u > 0.0]).max() < 0.06 and np.abs(away).max() < 0.3


def test_positions_that_say_no_direction_are_set_aside(good):
    """A receiver that stands at one place while the vehicle drives."""
    still = np.random.default_rng(1).normal(0.0, 3.0, (2, len(good)))
    drive = completed(without(good.with_channels(x=still[0], y=still[1]), "psi"), reference_vehicle())
    assert completed(without(good.between(0.0, 0.03), "psi"), reference_vehicle()).state_of("psi") == "derived", "two rows"
    assert not drive.measured("x") and not drive.measured("y")
    assert any(note.startswith("x: set aside, since it says no direction of a heading") for note in drive.notes)


def test_a_whole_drive_is_left_as_it_is(good):
    assert completed(good, reference_vehicle()) is good


@pytest.mark.parametrize("name", ["u", "omega_z", "steer"])
def test_less_than_the_least_is_refused(good, name):
    with pytest.raises(ValueError, match=f"found no {name}"):
        completed(without(good, name), reference_vehicle())


def test_states_of_channels_survive_parquet(good, tmp_path):
    drive = completed(without(good, "v"), reference_vehicle())
    again = read_drive(write_drive(drive, tmp_path / "drive.parquet"))
    assert again.state_of("v") == "derived" and again.state_of("u") == "measured"
    assert again.state_of("gyro") == "absent"


def test_a_state_that_is_none_of_the_three_is_refused():
    with pytest.raises(ValueError, match="expected measured, derived or absent"):
        Recording("r", {"t": np.arange(3.0)}, state={"t": "guessed"})  # type: ignore[dict-item]


def test_derived_states_start_a_model_and_judge_nothing(good):
    drive = completed(without(good, "v"), reference_vehicle())
    at = STATE_CHANNELS.index("v")
    assert np.isnan(measured_states(drive)[:, at]).all()
    assert np.isfinite(known_states(drive)[:, at]).all()


def test_n_without_v_and_without_pose_is_that_of_the_whole_log(good):
    model = bicycle(reference_vehicle(), CLAY)
    whole = estimate_terrain(good, model, 0.7, tied=True, start=2.0).n_front[-1]
    for dropped in (("v",), ("x", "y", "psi")):
        drive = completed(without(good, *dropped), reference_vehicle())
        n = estimate_terrain(drive, model, 0.7, tied=True, start=2.0).n_front[-1]
        assert n == pytest.approx(whole, rel=0.04)
