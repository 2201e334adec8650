"""Tables that tools make of robot messages: rostopic, PlotJuggler, NumPy; columns named by a field's path."""

import tomllib

import numpy as np
import pandas as pd
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.importing.bring_in import bring_in, inspect_sources, read_sources
from softsoil.importing.draft_map import channel_named, draft, geodetic
from softsoil.importing.import_map import map_from_table
from softsoil.importing.message_columns import with_headings
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.read import read_drive

EPOCH = 1.79e9
PATHS = {
    "x": "pose.pose.position.x", "y": "pose.pose.position.y", "u": "twist.twist.linear.x", "v": "twist.twist.linear.y",
    "omega_z": "twist.twist.angular.z", "a_x_imu": "linear_acceleration.x", "a_y_imu": "linear_acceleration.y",
    "steer": "drive.steering_angle",
}  # fmt: skip


@pytest.fixture(scope="module")
def log():
    return read_drive(MULTI_LOG).between(2.0, 20.0)


def columns(log, name_of):
    """Channels by the paths of messages, the heading as a quaternion, gravity beside the accelerations."""
    named = {name_of(path): log[channel] for channel, path in PATHS.items()}
    named |= {name_of(f"joint.wheel_{name[-2:]}.velocity"): log[name] for name in WHEEL_CHANNELS}
    turn = {"x": np.zeros(len(log)), "y": np.zeros(len(log)), "z": np.sin(log["psi"] / 2), "w": np.cos(log["psi"] / 2)}
    gravity = 9.81 + 0.01 * np.sin(log.t)
    named |= {name_of(f"pose.pose.orientation.{part}"): values for part, values in turn.items()}
    return named | {name_of("linear_acceleration.z"): gravity, name_of("angular_velocity.x"): 0.01 * np.cos(log.t)}


def rostopic(log, path):
    stamps = (1e9 * (EPOCH + log.t)).astype(np.int64)
    head = {"%time": stamps, "field.header.seq": np.arange(len(log)), "field.header.stamp": stamps}
    pd.DataFrame(head | columns(log, lambda field: f"field.{field}")).to_csv(path, index=False)


def plotjuggler(log, path):
    named = columns(log, lambda field: f"/robot/{field.replace('.', '/')}")
    pd.DataFrame({"__time": EPOCH + log.t} | named).to_csv(path, index=False)


@pytest.mark.parametrize("written", [rostopic, plotjuggler])
def test_a_table_of_messages_needs_no_map(written, log, tmp_path):
    path = tmp_path / "odom.csv"
    written(log, path)
    text = draft(inspect_sources([path]))
    plan = map_from_table(tomllib.loads(text), "map")
    assert 'point = "centre_of_gravity"' in text and "needed" not in text and "z-down" not in text.split("[mount")[1]
    drive = bring_in("odom", plan, read_sources([path], plan), reference_vehicle()).drive
    for name in ("u", "v", "omega_z", "steer", "a_x_imu", "a_y_imu", *WHEEL_CHANNELS):
        assert drive.state_of(name) == "measured"
        assert np.interp(5.0, drive.t, drive[name]) == pytest.approx(np.interp(5.0, log.t - log.t[0], log[name]), abs=2e-3), name
    assert np.interp(5.0, drive.t, drive["psi"]) == pytest.approx(np.interp(5.0, log.t - log.t[0], log["psi"]), abs=1e-3)
    front = np.interp(5.0, log.t - log.t[0], log["x"]) + reference_vehicle().l_f * np.cos(np.interp(5.0, drive.t, drive["psi"]))
    assert np.interp(5.0, drive.t, drive["x"]) == pytest.approx(front, abs=5e-3)


@pytest.mark.parametrize(("header", "comments"), [("t,u,v,omega_z,steer", "# "), ("t; u; v; omega_z; steer", "% ")])
def test_a_header_that_is_a_comment_is_a_header(header, comments, log, tmp_path):
    path = tmp_path / "log.csv"
    rows = np.column_stack([log.t, *(log[name] for name in ("u", "v", "omega_z", "steer"))])
    separator = ";" if ";" in header else ","
    np.savetxt(path, rows, delimiter=separator, header=f"written by hand\n{header}", comments=comments)
    (holding,) = inspect_sources([path])
    assert holding.count == len(log) and [*holding.fields] == ["u", "v", "omega_z", "steer"]


def test_fields_of_messages_are_known_by_their_paths():
    names = {
        "twist.linear.x": "u", "/odom/twist/twist/linear/y": "v", "linear_velocity_x": "u", "angular_velocity_z": "omega_z",
        "imu.linear_acceleration.x": "a_x_imu", "position_y": "y", "velocity_x": "u", "acceleration_y": "a_y_imu",
        "pose.orientation.heading": "psi", "joints.wheel_rear_left.velocity": "omega_rl", "/heading/data": "psi",
        "vehicle.speed": "u", "orientation.x": None, "pose.covariance.0": None, "twist.angular.x": None,
        "linear_acceleration.z": None, "magnetic_field.x": None,
    }  # fmt: skip
    assert {name: channel_named(name) for name in names} == names


def test_a_fix_is_known_by_its_path():
    fix = ("/gps/fix/latitude", "/gps/fix/longitude")
    assert geodetic(["/gps/fix/status", *fix]) == (*fix, "")


def test_the_velocity_of_a_receiver_is_not_that_along_the_vehicle(log, tmp_path):
    path = tmp_path / "gps.csv"
    pd.DataFrame({"time": EPOCH + log.t, "linear.x": log["u"], "linear.y": log["v"]}).to_csv(path, index=False)
    assert "u = \"gps.csv:linear.x\"" not in draft(inspect_sources([path]))


def test_what_is_no_quaternion_has_no_heading():
    frame = pd.DataFrame({f"orientation.{part}": [0.0, 0.0, 0.0] for part in "xyz"} | {"orientation.w": [0.0, 1.0, np.nan]})
    heading = with_headings(frame)["orientation.heading"].to_numpy()
    assert np.isnan(heading[[0, 2]]).all() and heading[1] == 0.0
    assert list(with_headings(frame[["orientation.z", "orientation.w"]]).columns) == ["orientation.z", "orientation.w"]
