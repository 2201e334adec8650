"""A receiver's velocities to the east and north: turned by the heading into u and v, or a speed alone."""

import math
import tomllib

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.words import Check
from softsoil.importing.bring_in import as_mapped
from softsoil.importing.draft_map import channel_named, draft
from softsoil.importing.earth_velocity import TURNED, turned_by_heading
from softsoil.importing.import_map import map_from_table
from softsoil.importing.merge import merge
from softsoil.importing.sources import Holding, Series, Spread
from softsoil.recording.read import read_drive

VEHICLE = reference_vehicle()
PLACE = {"x": -0.8, "y": 0.3}
BOTH = {"velocity_east": "gnss.csv:vel_e", "velocity_north": {"source": "gnss.csv:vel_n_mms", "unit": "mm/s"}}
REST = {"omega_z": "imu.csv:r", "steer": "imu.csv:steer"}
HEADING = {"psi": {"source": "heading.csv:deg", "unit": "deg", "compass": True}}


@pytest.fixture(scope="module")
def clean():
    return read_drive(MULTI_LOG).between(0.0, 20.0)


def merged(clean, channels, heading=slice(None)):
    """The merged recording of a receiver of 10 Hz, a compass of 20 Hz with clocks of their own, and an IMU."""
    fix, turn = np.arange(clean.t[0] + 0.013, clean.t[-1], 0.1), np.arange(clean.t[0] + 0.004, clean.t[-1], 0.05)
    at = {name: np.interp(fix, clean.t, np.unwrap(clean[name]) if name == "psi" else clean[name])
          for name in ("psi", "u", "v", "omega_z")}  # fmt: skip
    ahead, aside = at["u"] - PLACE["y"] * at["omega_z"], at["v"] + PLACE["x"] * at["omega_z"]
    east = ahead * np.cos(at["psi"]) - aside * np.sin(at["psi"])
    north = ahead * np.sin(at["psi"]) + aside * np.cos(at["psi"])
    compass = np.degrees(math.pi / 2 - np.interp(turn, clean.t, np.unwrap(clean["psi"]))) % 360.0
    series = {
        "gnss.csv": Series("gnss.csv", fix, {"vel_e": east, "vel_n_mms": 1e3 * north}),
        "heading.csv": Series("heading.csv", turn[heading], {"deg": compass[heading]}),
        "imu.csv": Series("imu.csv", clean.t, {"r": clean["omega_z"], "steer": clean["steer"]}),
    }
    plan = map_from_table({"channels": {**REST, **channels}, "mount": {"gnss.csv": PLACE}}, "map")
    return merge("log", plan, {name: series[name] for name in plan.wanted()}, VEHICLE)


def test_the_heading_turns_them_into_the_velocities_of_the_centre_of_gravity(clean):
    found = merged(clean, {**BOTH, **HEADING})
    drive, seen = found.recording, np.isfinite(found.recording["v"])
    assert 150 < seen.sum() < 250 and drive.measured("v")
    for name in ("u", "v"):
        true = np.interp(drive.t[seen] + found.start_s, clean.t, clean[name])
        assert np.abs(drive[name][seen] - true).max() < 0.03
    assert found.origins["v"].source == "gnss.csv:vel_n_mms (turned by psi)"


def test_without_a_heading_they_are_a_speed(clean):
    found = merged(clean, BOTH)
    assert not found.recording.measured("v") and "v" not in found.origins
    assert any("a speed alone, since no heading is mapped" in note for note in found.recording.notes)
    seen = np.isfinite(found.recording["u"])
    true = np.interp(found.recording.t[seen] + found.start_s, clean.t, clean["u"])
    assert np.abs(found.recording["u"][seen] - true).max() < 0.1


def test_where_the_heading_is_missing_for_a_while_v_is_too(clean):
    gone = np.r_[0:100, 160:390]  # of 20 Hz: 3 s
    drive = merged(clean, {**BOTH, **HEADING}, gone).recording
    inside = (drive.t > 5.0 + TURNED) & (drive.t < 8.0 - TURNED)
    assert not np.isfinite(drive["v"][inside]).any() and np.isfinite(drive["u"][inside]).sum() > 15
    assert np.isfinite(drive["v"][drive.t > 8.2]).any()


def test_their_own_course_is_no_heading(clean):
    rng, psi = np.random.default_rng(1), np.unwrap(clean["psi"])
    ahead, aside = (clean[name] + 0.03 * rng.standard_normal(len(clean)) for name in ("u", "v"))
    east, north = ahead * np.cos(psi) - aside * np.sin(psi), ahead * np.sin(psi) + aside * np.cos(psi)
    found = turned_by_heading(east, north, psi, clean.dt)[1]
    assert np.abs(found - aside).max() < 1e-9
    course = np.unwrap(np.arctan2(north, east))
    words = "psi: expected a heading of the vehicle; found the course of velocity_east and"
    with pytest.raises(ValueError, match=words):
        turned_by_heading(east, north, course, clean.dt)
    noise, held = 0.03 * rng.standard_normal((2, 700)), np.full(700, course[0])  # a receiver holds its course where it stands
    with pytest.raises(ValueError, match=words):
        turned_by_heading(np.r_[noise[0], east], np.r_[noise[1], north], np.r_[held, course], clean.dt)


def test_a_heading_of_one_hertz_is_within_half_a_second_of_every_velocity(clean):
    psi, seen = np.full(len(clean), np.nan), slice(None, None, round(1.0 / clean.dt))
    psi[seen] = np.unwrap(clean["psi"])[seen]
    _, aside = turned_by_heading(clean["u"], np.zeros(len(clean)), psi, clean.dt)
    assert np.isfinite(aside).mean() > 0.94


@pytest.mark.parametrize(
    "channels",
    [
        {"velocity_east": "a.csv:ve"},
        {"velocity_east": "a.csv:ve", "velocity_north": "a.csv:vn", "u": "a.csv:speed"},
        {"velocity_east": "a.csv:ve", "velocity_north": "b.csv:vn"},
    ],
)
def test_they_come_together_from_one_source_in_the_place_of_u_and_v(channels):
    with pytest.raises(ValueError, match="expected velocity_east and velocity_north of one source, and then no u and v; found"):
        map_from_table({"channels": {**REST, **channels}}, "map")


def test_a_cure_of_their_sign_names_what_turns_them():
    plan = map_from_table({"channels": {**REST, **BOTH, **HEADING}}, "map")
    check = as_mapped(Check("sign_v", "v", False, "", "", "sign = -1 for v"), plan)
    assert check.cure == "compare psi with velocity_east and velocity_north, which it turns"
    unit = as_mapped(Check("unit_u", "u", False, "", "", "correct unit or scale of u (km/h?)"), plan)
    assert unit.cure == "correct unit or scale of velocity_east and velocity_north (km/h?)"


def drafted(*names):
    fields = {name: Spread(-4.0 if name.startswith("v") else 10.0, 90.0, True) for name in names}
    return draft([Holding("gnss.csv", "table", "", 100, 10.0, 0.0, 10.0, "t", fields)])


def test_they_are_drafted_where_no_sensor_says_u_and_v():
    text = drafted("easting", "northing", "heading_deg", "vel_east", "vel_north")
    plan = map_from_table(tomllib.loads(text), "draft")
    assert plan.channels["u"].earth and plan.channels["v"].fields == ("vel_north",) and plan.channels["psi"].compass
    assert '# u = "source:field"' not in text and '# v = "source:field"' not in text
    beside = drafted("heading_deg", "vel_east", "vel_north", "speed_kmh")
    assert "u" in tomllib.loads(beside)["channels"] and '# velocity_east = "gnss.csv:vel_east"' in beside


@pytest.mark.parametrize(("heading", "turned"), [("sensor_msgs/msg/Imu", False), ("geometry_msgs/msg/PoseStamped", True)])
def test_beside_a_speed_an_inertial_sensors_heading_turns_nothing(heading, turned):
    """Its zero is anywhere, and v would be off by it."""
    names = ("twist.linear.speed", "twist.linear.x", "twist.linear.y")
    where = "orientation" if heading.endswith("Imu") else "pose.orientation"
    held = [
        Holding("/gps/vel", "geometry_msgs/msg/TwistStamped", "bag", 10, 5.0, 0.0, 2.0, "header stamps",
                {name: Spread(-5.0, 5.0, True) for name in names}),
        Holding("/heading", heading, "bag", 10, 50.0, 0.0, 2.0, "header stamps", {f"{where}.heading": Spread(-3.0, 3.0, True)}),
    ]  # fmt: skip
    channels = tomllib.loads(draft(held))["channels"]
    assert "psi" in channels and ("velocity_east" in channels) == turned != ("u" in channels)


def test_names_of_velocities_to_the_east_and_north_are_known():
    names = {
        "vel_e": "velocity_east", "velE": "velocity_east", "ve": "velocity_east", "v_east": "velocity_east",
        "east_velocity": "velocity_east", "VN": "velocity_north", "velocity_north": "velocity_north",
        "vel_n_mps": "velocity_north", "speed_north": "velocity_north", "drive": None, "valve": None, "event": None,
        "velocity.north": "velocity_north", "position.north": "y",
        "vel_d": None, "velocity": "u", "gps_velocity": "u", "velocity_y": "v", "column_deg": "steer", "column_torque": None,
    }  # fmt: skip
    assert {name: channel_named(name) for name in names} == names
