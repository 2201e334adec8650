"""The rear axle's lateral velocity in the place of the centre of gravity's, or its position in that of the front axle, by how it
turns."""

from dataclasses import replace

import numpy as np
import pytest

from drives import CLAY_LOG, LOAM_LOG, MULTI_LOG, reference_vehicle
from softsoil.checking.cross_check import check_channels
from softsoil.checking.place import NAME, POSITIONS, place_checks, position_checks
from softsoil.checking.usable import usable
from softsoil.recording.drive import Recording
from softsoil.recording.evidence import Motion
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive


def without_accelerometer(log, behind):
    """A drive with noise, its v that of a point so far (m) behind the centre of gravity."""
    drive = add_noise(read_drive(log), "good", 1)
    channels = {name: values for name, values in drive.channels.items() if not name.startswith("a_")}
    return replace(drive, channels={**channels, "v": drive["v"] - behind * drive["omega_z"]})


@pytest.mark.parametrize("log", [MULTI_LOG, LOAM_LOG], ids=("multi", "lock"))
def test_the_rear_axles_lateral_velocity_is_doubted_and_the_centre_of_gravitys_is_not(log):
    vehicle = reference_vehicle()
    right, rear = (without_accelerometer(log, behind) for behind in (0.0, vehicle.l_r))
    (passed,), (doubted,) = (place_checks(Motion.of(drive), vehicle) for drive in (right, rear))
    assert passed.passed and not passed.cure
    assert not doubted.passed and not doubted.beyond_doubt and f"[mount], x = {-vehicle.l_r:.2f}" in doubted.cure
    assert NAME in [check.name for check in check_channels(rear, vehicle) if not check.passed]


def test_with_an_accelerometer_or_without_v_it_says_nothing():
    drive = read_drive(MULTI_LOG)
    assert place_checks(Motion.of(drive), reference_vehicle()) == []
    bare = without_accelerometer(MULTI_LOG, 0.0)
    bare = replace(bare, channels={name: values for name, values in bare.channels.items() if name != "v"})
    assert place_checks(Motion.of(bare), reference_vehicle()) == []


def test_an_accelerometer_that_is_not_where_mount_has_it_is_named_beside_the_velocity():
    drive = add_noise(read_drive(CLAY_LOG), "good", 1)
    turning = np.gradient(read_drive(CLAY_LOG)["omega_z"], drive.dt)
    moved = replace(drive, channels={**drive.channels, "a_y_imu": drive["a_y_imu"] - 0.4 * turning})
    (doubted,) = [c for c in check_channels(moved, reference_vehicle()) if c.name == "lateral_velocity_rate"]
    assert "v of a point 0.40 ± 0.01 m ahead of the accelerometer's in [mount] would explain it" in doubted.found
    assert not doubted.passed and "places of the sources" in doubted.cure


@pytest.mark.parametrize(("ahead", "words"), [(1.5, "v of a point 1.5 ± 0.1 m ahead"), (-1.2, "v of a point 1.2 ± 0.1 m behind")])
def test_noise_does_not_make_the_place_of_a_velocity_a_wrong_unit(ahead, words):
    """The noise of v is left by its place, not by a scale that shrinks what is noisy."""
    drive = read_drive(MULTI_LOG)
    moved = add_noise(drive.with_channels(v=drive["v"] + ahead * drive["omega_z"]), "table5", 1)
    (doubted,) = [c for c in check_channels(moved, reference_vehicle()) if c.name == "lateral_velocity_rate"]
    assert words in doubted.found and "give the place of its source in [mount]" in doubted.cure and "unit" not in doubted.cure


def test_a_unit_and_a_place_that_explain_as_well_are_both_named():
    drive = read_drive(MULTI_LOG)
    doubled = add_noise(drive.with_channels(v=2.0 * drive["v"]), "table5", 1)
    (doubted,) = [c for c in check_channels(doubled, reference_vehicle()) if c.name == "lateral_velocity_rate"]
    assert "correct sign or unit of v; or" in doubted.cure and "places of the sources" in doubted.cure


def by_an_antenna(behind, *absent):
    """A drive with noise, without v and what else is `absent`; its antenna is so far (m) behind the front axle."""
    drive = add_noise(read_drive(MULTI_LOG), "good", 1)
    psi = read_drive(MULTI_LOG)["psi"]
    moved = {"x": drive["x"] - behind * np.cos(psi), "y": drive["y"] - behind * np.sin(psi)}
    channels = {name: values for name, values in drive.channels.items() if name not in ("v", *absent)}
    return replace(drive, channels={**channels, **moved})


@pytest.mark.parametrize("absent", [(), ("psi",), ("a_x_imu", "a_y_imu")])
def test_an_antenna_without_its_place_is_set_aside_where_v_is_not_measured(absent):
    vehicle = reference_vehicle()
    right, wrong = by_an_antenna(0.0, *absent), by_an_antenna(vehicle.l_f + 0.4, *absent)
    (passed,), (doubted,) = (position_checks(Motion.of(drive), vehicle) for drive in (right, wrong))
    assert passed.passed and not doubted.passed and "[mount]" in doubted.cure and doubted.name == POSITIONS
    assert usable(right, vehicle).measured("x", "y")
    with pytest.warns(UserWarning, match="the position of the front axle"):
        drive = usable(wrong, vehicle)
    assert not drive.measured("x") and "x: set aside; dead reckoning from speed and heading, from zero" in drive.notes
    assert "v: not in the log; the rear axle's course" in " ".join(drive.notes)


@pytest.mark.parametrize("period", [6.0, 20.0])
def test_without_a_heading_slip_of_a_fast_drive_is_no_other_place(period):
    """15 m/s: v of the laid heading is that of the slip, (l_r - c u^2) omega_z."""
    vehicle, t = reference_vehicle(), np.arange(0.0, 120.0, 0.02)
    u = 15.0 + 2.0 * np.sin(0.11 * t)
    omega = 0.12 * np.sin(2 * np.pi * t / period) + 0.03 * np.sin(2 * np.pi * t / 47.0)
    aside = (vehicle.l_r - 0.02 * u**2) * omega + vehicle.l_f * omega
    path = np.cumsum((u + 1j * aside) * np.exp(1j * np.cumsum(omega) * 0.02)) * 0.02
    noise = np.random.default_rng(1).normal(0.0, 1.0, (4, len(t)))
    channels = {"t": t, "x": path.real + 0.05 * noise[0], "y": path.imag + 0.05 * noise[1], "u": u + 0.05 * noise[2]}
    drive = Recording("fast", {**channels, "omega_z": omega + 0.005 * noise[3], "steer": 0.2 * omega})
    assert all(check.passed for check in position_checks(Motion.of(drive), vehicle))


def test_with_a_measured_v_positions_are_compared_with_that():
    assert position_checks(Motion.of(add_noise(read_drive(MULTI_LOG), "good", 1)), reference_vehicle()) == []


def test_a_grade_is_no_other_place_of_v():
    """20 % uphill along x: the accelerometer sees it by the heading."""
    drive = add_noise(read_drive(LOAM_LOG), "good", 1)
    sloped = drive.with_channels(a_y_imu=drive["a_y_imu"] - 0.2 * 9.81 * np.sin(drive["psi"]))
    (doubted,) = [c for c in check_channels(sloped, reference_vehicle()) if c.name == "lateral_velocity_rate"]
    assert not doubted.passed and "slopes by 18.8 ± 0.5 %" in doubted.found and "nothing is wrong with v" in doubted.cure
