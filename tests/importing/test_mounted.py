"""Sensors by their places and frames: what hangs upside down, what measures one axis, and what the map does not allow."""

import json
import tomllib

import numpy as np
import pandas as pd
import pymap3d
import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from drives import MULTI_LOG, reference_vehicle
from softsoil.importing.bring_in import bring_in, inspect_sources, read_sources
from softsoil.importing.draft_map import draft
from softsoil.importing.import_map import map_from_table
from softsoil.importing.local_frame import latitude_longitude
from softsoil.importing.merge import merge
from softsoil.importing.sources import Series
from softsoil.recording.read import read_drive

VEHICLE = reference_vehicle()
BEHIND = 1.3


@pytest.fixture(scope="module")
def clean():
    return read_drive(MULTI_LOG).between(0.0, 20.0)


def brought(clean, channels, values, mount):
    """A drive of one source per channel; `values` take the place of the clean ones."""
    series = {f"{name}.csv": Series(f"{name}.csv", clean.t, {name: values.get(name, clean[name])}) for name in channels}
    plan = map_from_table({"channels": {name: f"{name}.csv:{name}" for name in channels}, "mount": mount}, "map")
    return merge("log", plan, series, VEHICLE).recording


@pytest.mark.parametrize("heading", [False, True])
def test_an_ins_that_hangs_upside_down_is_brought_in_as_its_draft_says(clean, heading, tmp_path):
    """x forward, y right, z down, with fixes and a heading from north: they are of the earth, however it hangs."""
    lat, lon, _ = pymap3d.enu2geodetic(clean["x"], clean["y"], 0.0, 48.0, 11.0, 0.0)
    table = {
        "time": clean.t, "latitude": lat, "longitude": lon, "yaw_rate": -clean["omega_z"], "speed": clean["u"],
        "steer": clean["steer"], "acc_x": clean["a_x_imu"], "acc_y": -clean["a_y_imu"], "acc_z": np.full(len(clean), -9.81),
    }  # fmt: skip
    if heading:
        table["heading_deg"] = np.rad2deg(np.pi / 2 - clean["psi"]) % 360.0
    path = tmp_path / "ins.csv"
    pd.DataFrame(table).to_csv(path, index=False)
    plan = map_from_table(tomllib.loads(draft(inspect_sources([path]))), "map")
    drive = merge("ins", plan, read_sources([path], plan), VEHICLE).recording
    rows = slice(100, len(drive) - 100)
    assert np.allclose(drive["omega_z"][rows], clean["omega_z"][rows], atol=1e-6)
    if heading:
        assert np.allclose(np.cos(drive["psi"] - clean["psi"][: len(drive)])[rows], 1.0, atol=1e-6)
        return
    found = latitude_longitude("x", drive["x"], drive["y"], drive.origin)[0]
    north = np.deg2rad(found - lat[: len(drive)])[rows] * 6.366e6
    assert np.allclose(north, VEHICLE.l_f * np.sin(clean["psi"][: len(drive)])[rows], atol=0.1)
    assert any("aligned with them, since no heading is mapped" in note for note in drive.notes)


@pytest.mark.parametrize("mount", ["v.csv", "velocity"])
def test_a_sensor_of_v_alone_has_its_place_and_turn(clean, mount):
    yaw = 0.1
    u, v = clean["u"], clean["v"] - BEHIND * clean["omega_z"]
    measured = -u * np.sin(yaw) + v * np.cos(yaw)
    place = {mount: {"x": -BEHIND, "yaw": yaw}}
    if mount == "velocity":
        ahead = u * np.cos(yaw) + v * np.sin(yaw)
        drive = brought(clean, ("u", "v", "omega_z", "steer"), {"v": measured, "u": ahead}, place)
    else:
        drive = brought(clean, ("u", "v", "omega_z", "steer"), {"v": measured}, place)
    assert np.allclose(drive["v"], clean["v"][: len(drive)], atol=0.02 if mount == "velocity" else 1e-9)


def test_a_gap_of_v_is_none_of_u(clean):
    """Of one sensor that is not turned: a v that is missing took u with it."""
    rows = slice(300, 420)
    gap = clean["v"].copy()
    gap[rows] = np.nan
    series = {"log.csv": Series("log.csv", clean.t, {name: clean[name] for name in ("u", "omega_z", "steer")} | {"v": gap})}
    channels = {name: f"log.csv:{name}" for name in ("u", "v", "omega_z", "steer")}
    drive = merge("log", map_from_table({"channels": channels}, "map"), series, VEHICLE).recording
    assert np.isfinite(drive["u"]).all() and np.isnan(drive["v"]).sum() > 80


def test_an_accelerometer_of_one_axis_has_its_place_and_tilt(clean):
    turning = np.gradient(clean["omega_z"], clean.t)
    roll = 0.1
    read = (clean["a_y_imu"] - BEHIND * turning) * np.cos(roll) + 9.81 * np.sin(roll)
    drive = brought(clean, ("u", "omega_z", "steer", "a_y_imu"), {"a_y_imu": read}, {"a_y_imu.csv": {"x": -BEHIND, "roll": roll}})
    error = drive["a_y_imu"] - clean["a_y_imu"][: len(drive)]
    assert np.sqrt(np.mean(error**2)) < 0.12 * np.std(BEHIND * turning)
    turned = brought(clean, ("u", "omega_z", "steer", "a_y_imu"), {}, {"a_y_imu.csv": {"yaw": 0.2}})
    assert turned.notes == ("a_y_imu: its sensor's yaw is not taken off: that takes both axes of one sensor",)


@pytest.mark.parametrize(("unit", "turn"), [("rad", 2 * np.pi), ("deg", 360.0)])
def test_the_rate_of_an_angle_that_starts_anew_each_turn(clean, unit, turn):
    angle = (0.5 * clean.t / (2 * np.pi)) % 1.0 * turn
    series = {"log.csv": Series("log.csv", clean.t, {"u": clean["u"], "steer": clean["steer"], "h": angle})}
    channels = {"u": "log.csv:u", "steer": "log.csv:steer", "omega_z": {"source": "log.csv:h", "unit": unit, "rate": True}}
    drive = merge("log", map_from_table({"channels": channels}, "map"), series, VEHICLE).recording
    assert np.allclose(drive["omega_z"], 0.5, atol=1e-6)


def test_a_topic_of_two_publishers_is_one_source(tmp_path):
    """A bag of ROS 1 has a connection for each: every /tf has several."""
    store = get_typestore(Stores.ROS1_NOETIC)
    names = ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist", "geometry_msgs/msg/Vector3", "std_msgs/msg/Header")
    stamped, twist, vector, header = (store.types[name] for name in names)
    with Writer(tmp_path / "two.bag") as bag:
        topics = [bag.add_connection("/vel", stamped.__msgtype__, typestore=store, callerid=name) for name in ("/a", "/b")]
        for k in range(100):
            ns = int(1e9 + k * 1e7)
            stamp = store.types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9)
            message = stamped(header(k, stamp, "base"), twist(vector(1.0 + k, 0.0, 0.0), vector(0.0, 0.0, 0.1)))
            bag.write(topics[k % 2], ns, store.serialize_ros1(message, stamped.__msgtype__))
    (holding,) = inspect_sources([tmp_path / "two.bag"])
    assert (holding.name, holding.count) == ("/vel", 100)
    assert holding.rate_hz == pytest.approx(100.0, rel=0.01) and holding.stop_s == pytest.approx(1.99, abs=0.02)


def test_what_is_set_aside_is_not_called_measured(clean):
    series = {"log.csv": Series("log.csv", clean.t, {name: clean[name] for name in ("x", "u", "omega_z", "steer")})}
    plan = map_from_table({"channels": {name: f"log.csv:{name}" for name in ("x", "u", "omega_z", "steer")}}, "map")
    found = bring_in("log", plan, series, VEHICLE)
    written = json.loads(json.dumps(found.as_json()))["channels"]
    assert {name: one["state"] for name, one in written.items() if name in ("x", "u")} == {"x": "derived", "u": "measured"}
