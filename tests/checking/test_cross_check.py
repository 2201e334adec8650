"""Channels against each other: good logs pass, hostile ones are refused or warned about, each with its channel and cure."""

import re
from dataclasses import replace

import numpy as np
import pytest

from drives import CLAY_LOG, LOAM_LOG, MULTI_LOG, reference_vehicle
from softsoil.cases.hostile import VARIANTS, variant
from softsoil.checking.cross_check import check_channels, refuse_contradictions, warnings
from softsoil.checking.offsets import time_offsets
from softsoil.recording.derive import completed
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive, write_drive

LEFT_TO_THE_VERDICT = {
    "steer clipped": "steering stops look the same",
    "hard ground": "no channel contradicts another: only the force balance shows that there is no soil",
    "wheels 3 % fast": "more slip looks the same",
    "steering ratio 10 % off": "softer soil looks the same",
    "wheels 1 s late": "slip that follows the acceleration looks the same, and this drive hardly spreads its wheels",
}
HARMLESS = {v.name for v in VARIANTS if v.harmless}
SLOW = {"a million rows"}


@pytest.fixture(scope="module")
def good():
    return read_drive(MULTI_LOG)


def outcome(recording, path):
    """("refused" | "warned" | "silent", words) of a log as every command opens it."""
    try:
        drive = read_drive(write_drive(recording, path))
        checks = check_channels(drive, reference_vehicle())
        refuse_contradictions(path.name, checks)
    except ValueError as error:
        return "refused", str(error)
    doubts = warnings(checks)
    return ("warned", " ".join(doubts)) if doubts else ("silent", "")


@pytest.mark.parametrize("hostile", [v for v in VARIANTS if v.name not in SLOW], ids=lambda v: v.name)
def test_hostile_logs_are_refused_or_warned_about(hostile, good, tmp_path):
    found, words = outcome(hostile.of(good), tmp_path / "log.parquet")
    if hostile.name in HARMLESS | set(LEFT_TO_THE_VERDICT):
        assert found in ("silent", "warned")
    else:
        assert found in ("refused", "warned")
        assert "expected" in words and "found" in words and "\n" not in words


@pytest.mark.parametrize("hertz", [1.0, 3.0])
def test_a_slow_heading_is_compared_from_sample_to_sample(hertz, good):
    drive = add_noise(good, "table5", 1)
    slow = np.full(len(drive), np.nan)
    slow[:: round(1.0 / hertz / drive.dt)] = 1.0

    def checks_of(psi):
        return {check.name: check for check in check_channels(drive.with_channels(psi=slow * psi), reference_vehicle())}

    right = checks_of(drive["psi"])
    assert right["yaw_rate_heading"].passed and right["yaw_rate_bias"].passed
    for psi, words in (
        (-drive["psi"], "sign = -1 for psi, or compass = true where it grows clockwise from north"),
        (drive["steer"], "map another column to psi or omega_z"),
    ):
        wrong = checks_of(psi)["yaw_rate_heading"]
        assert wrong.beyond_doubt and words in wrong.cure


def test_a_flipped_yaw_rate_is_named_and_shifts_no_clock(good):
    drive = add_noise(good, "good", 1)
    flipped = drive.with_channels(omega_z=-drive["omega_z"])
    wrong = [check for check in check_channels(flipped, reference_vehicle()) if check.beyond_doubt]
    assert wrong[0].channel == "omega_z" and "sign = -1 for omega_z" in wrong[0].cure and "z-down" in wrong[0].cure
    steer = {offset.group: offset for offset in time_offsets(flipped, reference_vehicle())}.get("steer")
    assert steer is None or not steer.trusted or abs(steer.late_s) < 0.25
    right = {offset.group: offset for offset in time_offsets(drive, reference_vehicle())}
    assert all(offset.trusted for offset in right.values())


def test_a_flipped_steering_angle_of_a_short_wave_is_beyond_doubt():
    """A second later a wave of 3.2 s fits a little again."""
    t = np.arange(0.0, 30.0, 0.02)
    steer, vehicle = 0.2 * np.sin(2 * np.pi * t / 3.2) + 0.05 * np.sin(0.9 * t), reference_vehicle()
    omega = 0.7 * 2.0 * steer / (vehicle.l_f + vehicle.l_r)
    channels = {"t": t, "u": np.full(len(t), 2.0), "omega_z": omega, "steer": -steer}
    found = {check.name: check for check in check_channels(Recording("wave", channels), vehicle)}["steer_yaw_rate"]
    assert found.beyond_doubt and "sign = -1 for steer" in found.cure and "(+0.3" in found.found


def test_a_speed_that_is_far_below_the_positions_is_beyond_doubt_and_no_steering_is_missed(good):
    drive, vehicle = add_noise(good, "good", 1), reference_vehicle()
    slow = {check.name: check for check in check_channels(drive.with_channels(u=0.12 * drive["u"]), vehicle)}
    assert slow["speed_position"].beyond_doubt and "correct unit or scale of u" in slow["speed_position"].cure
    assert slow["steered"].passed
    slow = replace(good, channels={**good.channels, **{name: 0.12 * good[name] for name in ("x", "y", "u", "v")}})
    for noise in ("good", {"x": 1.2, "y": 1.2, "u": 0.05, "omega_z": 0.005}):
        creeping = add_noise(slow, noise, 1)
        assert "speed_position" not in {check.name for check in check_channels(creeping, vehicle) if not check.passed}


def test_an_accelerometer_that_rolls_with_the_body_is_named(good):
    drive = add_noise(good, "good", 1)
    found = {c.name: c for c in check_channels(drive.with_channels(a_y_imu=1.12 * drive["a_y_imu"]), reference_vehicle())}
    assert not found["accelerometer_y"].passed and "it rolls with the body" in found["accelerometer_y"].cure


def test_positions_without_a_heading_turn_as_the_yaw_rate_says(good):
    drive, vehicle = add_noise(good, "good", 1), reference_vehicle()

    def found(**channels):
        log = drive.with_channels(**channels)
        log = replace(log, channels={name: values for name, values in log.channels.items() if name != "psi"})
        return {check.name: check for check in check_channels(log, vehicle)}["course_heading"]

    assert found().passed and found(x=-drive["x"], y=-drive["y"]).passed, "a frame may be turned"
    for wrong in (found(y=-drive["y"]), found(x=-drive["x"]), found(x=drive["y"], y=drive["x"])):
        assert wrong.beyond_doubt and "sign = -1 for x or for y, or swap them" in wrong.cure
    apart = found(x=np.roll(drive["x"], 1500), y=np.roll(drive["y"], 700))
    assert not apart.passed
    turning = replace(drive, channels={name: values for name, values in drive.channels.items() if name != "psi"})
    biased = turning.with_channels(omega_z=turning["omega_z"] + 0.03)
    (said,) = [check for check in check_channels(biased, vehicle) if check.name == "yaw_rate_bias"]
    assert "offset = -0.0" in said.cure and not said.beyond_doubt
    assert "yaw_rate_bias" not in {check.name for check in check_channels(turning, vehicle)}
    fast = {check.name: check for check in check_channels(biased.with_channels(u=1.2 * drive["u"]), vehicle)}
    assert not fast["yaw_rate_bias"].passed and not fast["speed_position"].passed, "one doubt hides no other"


def test_a_steering_wheels_angle_is_named_before_what_it_does_to_the_wheels(good):
    drive = add_noise(good, "good", 1)
    wrong = [c for c in check_channels(drive.with_channels(steer=14.0 * drive["steer"]), reference_vehicle()) if c.beyond_doubt]
    assert wrong[0].channel == "steer" and "give ratio" in wrong[0].cure
    assert not any(check.name.startswith("wheel_omega_f") for check in wrong), "the wheels are right"


def test_velocities_in_the_worlds_frame_are_named(good):
    drive, vehicle = add_noise(good, "good", 1), reference_vehicle()
    cos, sin = np.cos(drive["psi"]), np.sin(drive["psi"])
    turned = drive.with_channels(u=drive["u"] * cos - drive["v"] * sin, v=drive["u"] * sin + drive["v"] * cos)
    (wrong,) = (check for check in check_channels(turned, vehicle) if check.name == "velocity_frame")
    assert wrong.beyond_doubt and "world's frame" in wrong.cure
    assert not [check for check in check_channels(drive, vehicle) if check.name == "velocity_frame"]


def test_a_motion_with_z_down_is_named_where_steering_and_wheels_agree(good):
    checks = check_channels(variant("z down").of(good), reference_vehicle())
    wrong = next(check for check in checks if check.beyond_doubt)
    assert wrong.channel == "omega_z" and 'frame = "z-down"' in wrong.cure


def test_a_coarse_clock_is_no_scale_of_the_gyro(good):
    (found,) = (c for c in check_channels(variant("5 Hz").of(good), reference_vehicle()) if c.name == "yaw_rate_heading")
    assert found.passed and "1.01" in found.found


def test_wheels_in_metres_per_second_and_wheels_that_slip_alike_are_told(good):
    drive, vehicle = add_noise(good, "good", 1), reference_vehicle()

    def cures(factor):
        drives = drive.with_channels(**{name: factor * drive[name] for name in WHEEL_CHANNELS})
        return [c.cure for c in check_channels(drives, vehicle) if c.name.startswith("wheel_omega") and not c.passed]

    assert len(cures(vehicle.radius)) == 4 and all('m/s? unit = "m/s"' in cure for cure in cures(vehicle.radius))
    assert len(cures(1.2)) == 4 and all("slip as much on this ground" in cure for cure in cures(1.2))
    assert len(cures(3.6 * vehicle.radius)) == 4 and all('km/h? unit = "km/h"' in cure for cure in cures(3.6 * vehicle.radius))
    assert not any("km/h" in cure for cure in cures(3.2 * vehicle.radius)), "driven wheels are no slower than the ground"
    assert cures(1.0) == []
    assert len(cures(2.1)) == 4 and all("is the vehicle's radius a diameter?" in cure for cure in cures(2.1))


def test_wheels_of_a_driven_axle_are_no_others(good):
    """Of a vehicle that declares which wheels are driven: those slip, and the towed ones lag; of others it is a doubt."""
    drive, vehicle = add_noise(good, "good", 1), reference_vehicle()
    turned = drive.with_channels(
        **{name: (1.2 if name in WHEEL_CHANNELS[:2] else 0.92) * drive[name] for name in WHEEL_CHANNELS}
    )

    def cures(log, **driveline):
        found = check_channels(log, vehicle.with_(driveline=driveline))
        return {c.channel: c.cure for c in found if c.name.startswith("wheel_omega") and not c.passed}

    front = {"centre_lock": 0.0, "front_drive": 1.0}
    assert cures(turned, **front) == {}
    for absent in WHEEL_CHANNELS:  # each axle by the wheels that it has
        assert cures(turned.with_channels(**{absent: np.full(len(turned), np.nan)}), **front) == {}
    assert all("[driveline] of the vehicle says" in cure and "factor" not in cure for cure in cures(turned).values())
    assert len(cures(turned)) == 4 and len(cures(turned, centre_lock=1.0, front_drive=0.5)) == 4
    for factor in (1.45, 1.8):  # beyond a drive's slip, or all wheels alike: a radius or a unit
        assert len(cures(drive.with_channels(**{name: factor * drive[name] for name in WHEEL_CHANNELS}), **front)) == 4
    every = drive.with_channels(**{name: 1.25 * drive[name] for name in WHEEL_CHANNELS})
    assert len(cures(every, centre_lock=0.0, front_drive=0.5)) == 4
    one = turned.with_channels(omega_fl=0.9 * turned["omega_fl"])
    assert "factor" in cures(one, **front)["omega_fl"]


def test_one_wheel_that_drags_is_in_no_other_unit(good):
    """Its ratio happens to be that of a rim speed in km/h, and the others are right."""
    drive, vehicle = add_noise(good, "good", 1), reference_vehicle()
    one = drive.with_channels(omega_rl=3.6 * vehicle.radius * drive["omega_rl"])
    (found,) = (c for c in check_channels(one, vehicle) if c.name.startswith("wheel_omega") and not c.passed)
    assert found.channel == "omega_rl" and "factor = 0.8" in found.cure and "km/h" not in found.cure


def test_a_v_of_another_point_is_said_where_positions_alone_seem_off(good):
    moved = good.with_channels(v=good["v"] + 1.6 * good["omega_z"])
    (found,) = (c for c in check_channels(moved, reference_vehicle()) if c.name == "reference_point")
    assert not found.passed and re.search(r"or v's, if that is of a point \d\.\d\d m ahead of the centre", found.cure)


def test_an_axle_that_slips_as_a_whole_may_be_driven_or_towed(good):
    """Both front wheels a fifth slower than the ground; one of them alone is a sensor's."""
    drive, vehicle = add_noise(good, "good", 1), reference_vehicle()

    def cure(*names):
        slow = drive.with_channels(**{name: 0.8 * drive[name] for name in names})
        return next(c.cure for c in check_channels(slow, vehicle) if c.name == "wheel_omega_fl")

    assert "towed ones slower" in cure("omega_fl", "omega_fr") and "towed" not in cure("omega_fl")


@pytest.mark.parametrize("path", [CLAY_LOG, LOAM_LOG, MULTI_LOG], ids=lambda path: path.stem)
def test_the_factor_of_one_wheel_leaves_it_the_slip_of_the_others(path):
    drive = read_drive(path)
    fast = drive.with_channels(omega_fl=1.15 * drive["omega_fl"])
    (found,) = [c for c in check_channels(fast, reference_vehicle()) if c.name == "wheel_omega_fl"]
    factor = float(found.cure.split("factor = ")[1].split()[0])
    assert not found.passed and 1.15 * factor == pytest.approx(1.0, abs=0.04)


def test_a_gyro_scale_that_moves_n_is_warned_of(good):
    drive = add_noise(good, "good", 1)
    for scale in (1.04, 0.96):
        (found,) = (
            c for c in check_channels(drive.with_channels(omega_z=scale * drive["omega_z"]), reference_vehicle())
            if c.name == "yaw_rate_heading"
        )  # fmt: skip
        assert not found.passed and not found.beyond_doubt
        factor = float(found.cure.split("factor = ")[1].split()[0])
        assert factor * scale == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(
    "channel", ["u", "v", "psi", "omega_z", "a_x_imu", "a_y_imu", "steer", "omega_fl", "omega_rr", "x", "y"]
)
def test_a_flipped_sign_is_beyond_doubt(channel, good, tmp_path):
    found, words = outcome(variant(f"{channel} flipped").of(good), tmp_path / "log.parquet")
    assert found == "refused"
    assert "sign = -1" in words or "compass" in words


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("wheel odometry", "is u made of the wheel speeds"),
        ("base frame at the rear axle", "m behind the front axle: give its place in [mount]"),
        ("v of the front axle", "ahead of the centre of gravity would explain it; give the place of its source"),
        ("omega_z 0.05 s late", "s early against the yaw rate"),
        ("states 0.15 s late", "0.14 s late against the accelerometer would explain it"),
    ],
)
def test_what_robots_do_is_named(name, words, good, tmp_path):
    assert words in outcome(variant(name).of(good), tmp_path / "log.parquet")[1]


@pytest.mark.parametrize("noise", ["none", "good", "table5"])
def test_a_speed_over_ground_is_no_wheel_odometry(noise, good):
    drive = good if noise == "none" else add_noise(good, noise, 1)
    (check,) = [c for c in check_channels(drive, reference_vehicle()) if c.name == "speed_source"]
    assert check.passed and "per m/s^2" in check.found


def test_there_are_at_least_forty_variants():
    assert len({v.name for v in VARIANTS}) == len(VARIANTS) >= 40


@pytest.mark.parametrize("path", [CLAY_LOG, LOAM_LOG, MULTI_LOG], ids=lambda path: path.stem)
def test_own_logs_pass_every_check_clean_and_noisy(path):
    for noise in ("none", "good"):
        drive = add_noise(read_drive(path), noise, 3)
        failed = [check.sentence() for check in check_channels(drive, reference_vehicle()) if not check.passed]
        assert failed == []


def test_table_5_noise_refuses_nothing(good):
    checks = check_channels(add_noise(good, "table5", 5), reference_vehicle())
    refuse_contradictions("log", checks)


@pytest.mark.shared
def test_reference_drives_and_effects_are_never_refused(shared_data):
    for path in sorted((shared_data / "chrono_vehicle").glob("*.csv.gz")):
        refuse_contradictions(path.name, check_channels(read_drive(path), reference_vehicle()))


def test_a_reported_bias_is_the_bias_that_is_there(good):
    shifted = good.with_channels(omega_z=good["omega_z"] + 0.05)
    (check,) = [c for c in check_channels(shifted, reference_vehicle()) if c.name == "yaw_rate_bias"]
    assert not check.passed and not check.beyond_doubt
    assert "+0.0499" in check.found or "+0.0500" in check.found or "+0.0501" in check.found


def test_derived_channels_judge_nothing(good):
    """A wrong speed moves what is derived from it; nothing but measured channels is compared."""
    bare = {k: good[k] for k in ("t", "u", "omega_z", "steer")}
    drive = completed(type(good)("bare", bare), reference_vehicle())
    names = {check.name for check in check_channels(drive, reference_vehicle())}
    assert not names & {"yaw_rate_heading", "lateral_velocity", "speed_position", "wheel_omega_fl", "clock_psi"}
    assert np.isfinite(drive.stack("x", "y", "psi", "v", "omega_fl")).all()


def test_a_yaw_rate_in_degrees_is_named_before_a_heading(good):
    turned = good.with_channels(omega_z=np.degrees(good["omega_z"]))
    (wrong,) = [check for check in check_channels(turned, reference_vehicle()) if check.name == "yaw_rate_heading"]
    assert wrong.beyond_doubt and 'unit = "deg/s" for omega_z' in wrong.cure


def test_a_parked_start_divides_by_no_speed(good):
    standing = np.arange(len(good)) < round(5.0 / good.dt)
    moving = ("u", "v", *WHEEL_CHANNELS)
    parked = good.with_channels(**{name: np.where(standing, 0.0, good[name]) for name in moving})
    with np.errstate(divide="raise"):
        check_channels(parked, reference_vehicle())


@pytest.mark.parametrize("dead", WHEEL_CHANNELS)
def test_a_wheel_sensor_that_stays_at_zero_is_named(good, dead):
    checks = check_channels(good.with_channels(**{dead: np.zeros(len(good))}), reference_vehicle())
    assert [c.channel for c in checks if c.name.startswith("wheel_omega") and not c.passed] == [dead]
