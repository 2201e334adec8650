"""A messy bag through inspect and import: every channel within sensor noise, clocks right, n that of the clean log."""

import json
import re
import tomllib
import tracemalloc
from array import array
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import softsoil.importing.bag as bag_module
from benchmarks.judges.messy_bags import (
    BALLAST,
    BALLAST_BYTES,
    EPOCH,
    LATE,
    ORIGIN,
    SIGMA,
    changed_lines,
    edited,
    write_bag,
)
from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.offsets import time_offsets
from softsoil.checking.words import Check
from softsoil.commands.cli import app
from softsoil.estimator.terrain import estimate_terrain
from softsoil.importing.bring_in import as_mapped, bring_in, inspect_sources, read_sources
from softsoil.importing.draft_map import channel_named, draft
from softsoil.importing.import_map import map_from_table
from softsoil.importing.loose_table import open_table
from softsoil.importing.merge import merge
from softsoil.importing.sources import Series
from softsoil.recording.derive import completed
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY

KINDS = (("mcap", False), ("sqlite3", False), ("rosbag1", False), ("mcap", True), ("sqlite3", True), ("rosbag1", True))


@pytest.fixture(scope="module")
def clean():
    return read_drive(MULTI_LOG)


@pytest.fixture(scope="module")
def bag(clean, tmp_path_factory):
    return write_bag(clean, tmp_path_factory.mktemp("bags") / "messy", "mcap")


def imported(path, align=True, edit=edited, lag=0.0):
    plan = map_from_table(tomllib.loads(edit(draft(inspect_sources([path])))), "map")
    return bring_in("messy", plan, read_sources([path], plan), reference_vehicle(), align, lag)


@pytest.fixture(scope="module")
def messy(bag):
    return imported(bag)


def test_the_draft_needs_few_lines_by_hand(bag):
    text = draft(inspect_sources([bag]))
    assert changed_lines(text, edited(text)) <= 10
    assert {"u", "v", "psi", "omega_z", "steer", "omega_rr"} <= set(tomllib.loads(text)["channels"])


def test_every_channel_is_within_its_sensor_noise(messy, clean):
    t = messy.drive.t + messy.merged.start_s - EPOCH
    for name, sigma in SIGMA.items():
        truth = np.interp(t, clean.t - clean.t[0], np.unwrap(clean[name]) if name == "psi" else clean[name])
        error = (messy.drive[name] - truth)[np.isfinite(messy.drive[name]) & (t > 2.0)]
        if name in ("x", "y"):
            error = error - np.median(error)  # the origin of the local frame is the first fix
        assert len(error) > 400
        assert np.std(error) < 1.15 * sigma, name
        assert abs(np.mean(error)) < 0.2 * sigma, name
    assert messy.drive.origin == pytest.approx(ORIGIN, abs=1e-3) and messy.as_json()["origin"] == list(messy.drive.origin)


def test_the_late_steering_is_found_within_15_ms_and_nothing_else_is_shifted(messy):
    assert set(messy.shifts) == {"/vehicle/steering"}
    assert messy.shifts["/vehicle/steering"] == pytest.approx(-LATE, abs=0.015)
    offset = next(o for o in messy.offsets if o.group == "steer")
    assert offset.late_s == pytest.approx(LATE, abs=0.015) and offset.std < 0.05
    assert offset.after > 0.97 > 0.8 > offset.before


def test_without_align_the_offset_is_reported_and_not_applied(bag):
    found = imported(bag, align=False)
    assert found.shifts == {}
    (check,) = [c for c in found.checks if c.name == "clock_steer"]
    assert not check.passed and check.beyond_doubt and "--align" in check.cure


def test_a_sign_that_the_map_has_turned_already_is_to_be_taken_out():
    channels = {"steer": {"source": "can.csv:angle", "sign": -1}, "u": "can.csv:u", "omega_z": "can.csv:w"}
    plan = map_from_table({"channels": channels}, "map")
    wrong = Check("steer_yaw_rate", "steer", False, "-0.9", "+1", "sign = -1 for steer (positive to the left)", True)
    assert as_mapped(wrong, plan).cure.startswith("no sign, ratio or factor below 0 for steer, as the map has it now (pos")
    other = replace(wrong, channel="omega_z", cure="sign = -1 for omega_z")
    assert as_mapped(other, plan) is other


def test_a_yaw_rate_of_the_other_sign_shifts_no_clock(bag):
    plain = 'omega_z = "/imu/data:angular_velocity.z"'

    def flipped(text):
        assert plain in text
        return edited(text).replace(plain, 'omega_z = {source = "/imu/data:angular_velocity.z", sign = -1}')

    assert imported(bag, edit=flipped).shifts == {}


def test_a_lag_of_the_steering_that_the_vehicle_declares_is_no_clock(bag):
    """Road wheels that follow a steering angle 0.1 s later, and do not seem to: its clock is late by as much more."""
    found = imported(bag, lag=0.1)
    assert found.shifts["/vehicle/steering"] == pytest.approx(-LATE - 0.1, abs=0.015)
    (check,) = [c for c in found.checks if c.name == "clock_steer"]
    assert check.passed


def n_of(drive):
    return estimate_terrain(drive, bicycle(reference_vehicle(), CLAY), 0.7, tied=True, start=2.0).n_front[-1]


@pytest.mark.study
def test_n_of_a_messy_bag_is_that_of_the_clean_log(clean, tmp_path):
    """Rates, jitter, dropouts, lever arm and the late clock together; 4 ms of the steering's clock are 1.7 % of n.

    What is left of the clock is the vehicle file's yaw inertia: 1 % of it is about 1 ms.
    """
    found = imported(write_bag(clean, tmp_path / "exact", "mcap", noise=0.0))
    assert found.shifts["/vehicle/steering"] == pytest.approx(-LATE, abs=0.004)
    assert n_of(found.drive) == pytest.approx(n_of(clean), rel=0.01)


@pytest.mark.study
@pytest.mark.slow
def test_sensor_noise_on_the_clocks_moves_n_within_one_percent(bag, messy):
    """Against the same bag with the true offset: noise moves n by itself, on one clock too, by 1 to 3 %."""
    plan = map_from_table(tomllib.loads(edited(draft(inspect_sources([bag])))), "map")
    series = read_sources([bag], plan)
    true_clock = merge("messy", plan, series, reference_vehicle(), {"/vehicle/steering": -LATE}).recording
    assert n_of(messy.drive) == pytest.approx(n_of(completed(true_clock, reference_vehicle())), rel=0.01)


def test_a_late_channel_of_one_table_is_shifted_by_its_map(clean, tmp_path):
    """A yaw rate 0.05 s late in the table that holds all others: the warning says what to write, and that brings n back."""
    log = tmp_path / "log.csv"
    frame = pd.DataFrame({name: clean[name] for name in ("t", "x", "y", "psi", "u", "v", "omega_z", "steer", *WHEEL_CHANNELS)})
    frame["omega_z"] = np.interp(clean.t - 0.05, clean.t, clean["omega_z"])
    frame.to_csv(log, index=False)
    plan = tomllib.loads(draft(inspect_sources([log])))

    def brought_in():
        mapped = map_from_table(plan, "map")
        return bring_in("log", mapped, read_sources([log], mapped), reference_vehicle())

    (warned,) = [c for c in brought_in().checks if c.name == "clock_psi"]
    (said,) = re.findall(r"late = ([\d.]+) at omega_z", warned.cure)
    assert not warned.passed and float(said) == pytest.approx(0.05, abs=0.01)
    plan["channels"]["omega_z"] = {"source": plan["channels"]["omega_z"], "late": float(said)}
    found = brought_in()
    assert next(c for c in found.checks if c.name == "clock_psi").passed
    assert found.as_json()["channels"]["omega_z"]["offset_s"] == pytest.approx(-float(said))
    assert any("late, as its map says" in note for note in found.drive.notes)
    inside = (found.drive.t > 1.0) & (found.drive.t < found.drive.t[-1] - 1.0)
    error = found.drive["omega_z"] - np.interp(found.drive.t + found.merged.start_s, clean.t, clean["omega_z"])
    assert np.max(np.abs(error[inside])) < 0.1 * np.std(clean["omega_z"])
    assert n_of(found.drive) == pytest.approx(n_of(clean), rel=0.02)


def test_a_channel_that_is_late_by_minutes_is_a_slip_of_the_pen():
    entry = {"source": "/c:u", "late": 60.0}
    with pytest.raises(ValueError, match=r"channels.u.late: expected at most 10 s, found 60"):
        map_from_table({"channels": {"u": entry}}, "map")


def test_a_channel_faster_than_the_clock_is_averaged(clean):
    """A gyro of 1 kHz on a clock of 100 Hz: its noise falls by the root of ten, its signal stays, a gap stays empty."""
    t = np.arange(0.0, 20.0, 0.001)
    slow = np.arange(0.0, 20.0, 0.01)
    noise = 0.01 * np.random.default_rng(0).standard_normal(len(t))
    keep = (t < 10.0) | (t > 10.2)
    series = {"/g": Series("/g", t[keep], {"r": (np.sin(t) + noise)[keep]}),
              "/c": Series("/c", slow, {"u": 3.0 + 0.0 * slow, "d": 0.1 * np.sin(slow)})}  # fmt: skip
    plan = map_from_table({"channels": {"u": "/c:u", "omega_z": "/g:r", "steer": "/c:d"}}, "map")
    drive = merge("fast", plan, series, reference_vehicle()).recording
    assert drive.dt == pytest.approx(0.01)
    gap = (drive.t > 10.006) & (drive.t < 10.194)
    assert np.isnan(drive["omega_z"][gap]).all() and np.isfinite(drive["omega_z"][~gap]).all()
    error = (drive["omega_z"] - np.sin(drive.t))[~gap]
    assert np.std(error) < 0.0036 and abs(np.mean(error)) < 3e-4


OTHERS = {("rosbag1", False), ("sqlite3", True)}
"""Bags that differ from others of the list by their compression alone."""


@pytest.mark.parametrize(
    ("kind", "compressed"),
    [pytest.param(*one, marks=[pytest.mark.study] if one in OTHERS else []) for one in KINDS[1:]],
    ids=lambda v: str(v),
)
def test_every_kind_of_bag_gives_the_same_drive(kind, compressed, clean, tmp_path, messy):
    found = imported(
        write_bag(clean, tmp_path / ("messy.bag" if kind == "rosbag1" else "messy"), kind, compressed=compressed)
    )
    assert len(found.drive) == len(messy.drive)
    for name in SIGMA:
        assert np.allclose(found.drive[name], messy.drive[name], atol=1e-6, equal_nan=True), name


def test_the_commands_write_what_they_say(bag, tmp_path):
    runner, out = CliRunner(), tmp_path / "out"
    first = runner.invoke(app, ["inspect", str(bag), "--out", str(out)])
    assert first.exit_code == 0 and (out / "inspect.json").is_file()
    text = edited((out / "map.toml").read_text(encoding="utf-8"))
    (out / "mine.toml").write_text(text, encoding="utf-8")
    refused = runner.invoke(app, ["import", str(bag), "--map", str(out / "mine.toml"), "--out", str(tmp_path / "none")])
    assert refused.exit_code == 2 and "late" in refused.output + refused.stderr and not (tmp_path / "none").exists()
    again = runner.invoke(app, ["import", str(bag), "--map", str(out / "mine.toml"), "--align", "--out", str(out)])
    assert again.exit_code == 0, again.output
    content = json.loads((out / "import.json").read_text(encoding="utf-8"))
    assert set(content["channels"]["steer"]) == {"state", "source", "rate_hz", "offset_s", "gaps"}
    assert content["channels"]["steer"]["offset_s"] == pytest.approx(-LATE, abs=0.015)
    assert content["channels"]["throttle"]["state"] == "absent"
    assert all({"name", "passed", "found", "expected", "cure"} <= set(c) for c in content["checks"])
    page = (out / "report.html").read_text(encoding="utf-8")
    assert (
        page.count("<table>") == 3 and "data:image/png;base64," in page and "http" not in page.replace("http-equiv", "")
    )
    drive = read_drive(out / "drive.parquet")
    assert drive.state_of("x") == "measured" and np.isnan(drive["x"]).mean() > 0.8


def test_gaps_stay_empty(bag, messy):
    gaps = np.diff(
        read_sources([bag], map_from_table(tomllib.loads(edited(draft(inspect_sources([bag])))), "m"))["/imu/data"].t
    )
    assert (gaps > 0.2).any()
    assert np.isnan(messy.drive["omega_z"]).sum() >= 20


@pytest.mark.study
@pytest.mark.parametrize("kind", ["mcap", "sqlite3"])
def test_images_and_clouds_are_neither_kept_nor_deserialised(kind, clean, tmp_path, monkeypatch):
    path = write_bag(clean, tmp_path / "big", kind, ballast=40)
    plan = map_from_table(tomllib.loads(edited(draft(inspect_sources([path])))), "map")
    read, original = set(), bag_module._message

    def watched(reader, connection, raw):
        read.add(connection.topic)
        return original(reader, connection, raw)

    monkeypatch.setattr(bag_module, "_message", watched)
    shares = []
    tracemalloc.start()
    series = read_sources([path], plan, shares.append)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert read == plan.wanted().keys() == series.keys() and len(BALLAST) == 2 and not read & set(BALLAST)
    assert peak < 10e6 < 40 * BALLAST_BYTES
    assert len(shares) > 5 and shares == sorted(shares) and shares[-1] == 1.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("u = 'a:b'", "expected tables channels"),
        ("[channels]\nspeed = '/odom:u'", "found 'speed'"),
        ("[channels]\nu = 'odom'", 'expected "source:field"'),
        ("[channels]\nu = {source = '/odom:u', unit = 'deg'}", "expected a unit of m/s"),
        ("[channels]\nsteer = {source = '/s:a', ratio = 0}", "a ratio and factor other than 0"),
        ("[channels]\nomega_z = {source = '/s:a', factor = 0, rate = true}", "a ratio and factor other than 0"),
        ("[channels]\nsteer = {source = '/s:a', table = [[0, 0], [0, 1]]}", "increasing"),
        ("[channels]\nu = '/odom:u'\n[mount]\nframe = 'ned'", "z-up, z-down"),
        ("[channels]\nu = '/odom:u'\n[clock]\nrate_hz = 1e9", "expected 1 to 1000"),
    ],
)
def test_faults_of_a_map_are_named(text, words):
    with pytest.raises(ValueError, match=r"map\.toml") as fault:
        map_from_table(tomllib.loads(text), "map.toml")
    assert words in str(fault.value)


def test_a_topic_that_is_not_there_is_named(bag):
    plan = map_from_table(tomllib.loads("[channels]\nu = '/odometry:u'"), "map")
    with pytest.raises(ValueError, match=r"/odom, .*found none called '/odometry'"):
        read_sources([bag], plan)


def test_rows_of_iso_time_and_words_are_no_units(tmp_path):
    """Words in the first row are units where the second has none there."""
    rows = ["2024-05-01 10:00:00.0,1.0", "2024-05-01 10:00:00.1,1.2", "2024-05-01 10:00:00.2,1.3"]
    (tmp_path / "two.csv").write_text("\n".join(["time,speed", *rows]) + "\n", encoding="utf-8")
    table = open_table(tmp_path / "two.csv")
    assert len(table.frame) == 3 and table.units == {}
    (tmp_path / "units.csv").write_text("\n".join(["time,speed", ",km/h", *rows]) + "\n", encoding="utf-8")
    table = open_table(tmp_path / "units.csv")
    assert len(table.frame) == 3 and table.units["speed"] == "km/h"
    rows = [f"{row},AUTO,RTK" for row in rows]  # columns of words beside them
    (tmp_path / "modes.csv").write_text("\n".join(["time,speed,mode,fix", "UTC,km/h,-,-", *rows]) + "\n", encoding="utf-8")
    table = open_table(tmp_path / "modes.csv")
    assert len(table.frame) == 3 and table.units["speed"] == "km/h"


def test_a_broken_bag_is_refused(tmp_path):
    path = tmp_path / "broken.mcap"
    path.write_bytes(b"not a bag at all")
    with pytest.raises(ValueError, match=r"broken\.mcap: expected a rosbag"):
        inspect_sources([path])


def _tables(clean, folder):
    """The drive as three tables of other loggers: ISO time with semicolons and a units row, epoch ms with tabs, Parquet."""
    t = clean.t - clean.t[0]
    stamp = pd.to_datetime((EPOCH + t) * 1e9, utc=True)
    slow = slice(None, None, 8)
    gps = pd.DataFrame(
        {
            "utc": stamp[slow].strftime("%Y-%m-%dT%H:%M:%S.%fZ"),
            "east": clean["x"][slow],
            "north": clean["y"][slow],
            "heading": np.rad2deg(np.pi / 2 - clean["psi"][slow]),
        }
    )
    lines = gps.to_csv(index=False, sep=";").splitlines()
    (folder / "gps.csv").write_text(
        "\n".join(["# logger 7", lines[0], "-;m;m;deg", *lines[1:]]) + "\n", encoding="utf-8"
    )
    imu = pd.DataFrame(
        {
            "timestamp": np.round((EPOCH + t) * 1e3, 3),
            "yaw_rate": clean["omega_z"],
            "accel_x": clean["a_x_imu"] / 9.80665,
            "accel_y": clean["a_y_imu"] / 9.80665,
        }
    )
    imu.to_csv(folder / "imu.tsv", index=False, sep="\t")
    can = pd.DataFrame(
        {
            "t": EPOCH + t,
            "speed_kmh": 3.6 * clean["u"],
            "steering wheel [deg]": -np.rad2deg(16 * clean["steer"]),
            "motor_rpm": 5 * 9.5493 * np.mean(clean.stack(*WHEEL_CHANNELS), axis=1),
        }
    )
    can.to_parquet(folder / "can.parquet")
    return [folder / name for name in ("gps.csv", "imu.tsv", "can.parquet")]


TABLE_MAP = """
[channels]
x = "gps.csv:east"
y = "gps.csv:north"
psi = {source = "gps.csv:heading", unit = "deg", compass = true}
omega_z = "imu.tsv:yaw_rate"
a_x_imu = {source = "imu.tsv:accel_x", unit = "g"}
a_y_imu = {source = "imu.tsv:accel_y", unit = "g"}
u = {source = "can.parquet:speed_kmh", unit = "km/h"}
steer = {source = "can.parquet:steering wheel", unit = "deg", ratio = 16, sign = -1}
omega_all = {source = "can.parquet:motor_rpm", unit = "rpm", ratio = 5}
"""


def test_tables_of_three_loggers_become_one_drive(clean, tmp_path):
    paths = _tables(clean, tmp_path)
    plan = map_from_table(tomllib.loads(TABLE_MAP), "map")
    found = bring_in("tables", plan, read_sources(paths, plan), reference_vehicle())
    assert [c.sentence() for c in found.checks if not c.passed] == []
    t = found.drive.t + found.merged.start_s - EPOCH
    for name in ("x", "y", "psi", "u", "omega_z", "steer", "a_x_imu"):
        truth = np.interp(t, clean.t - clean.t[0], np.unwrap(clean[name]) if name == "psi" else clean[name])
        error = found.drive[name] - truth
        assert np.nanmax(np.abs(error)) < 0.05 * max(np.nanstd(truth), 0.1), name
    assert found.drive.state_of("v") == "derived" and found.drive.state_of("omega_rl") == "derived"
    assert np.nanstd((found.drive["v"] - np.interp(t, clean.t - clean.t[0], clean["v"]))[200:]) < 0.03


def test_header_stamps_of_zero_are_said_and_a_message_without_a_header_needs_none():
    times, none = array("d", [1.0, 1.1, 1.2]), array("d", [np.nan] * 3)
    headed, plain = (bag_module._series("/odom", (times, none), array("d", [0.0, 1.0, 2.0]), ["u"], has) for has in (True, False))
    assert any("header stamps are zero" in note for note in headed.notes) and plain.notes == ()
    np.testing.assert_array_equal(headed.t, times)


def test_columns_are_recognised_by_their_names():
    names = {
        "speed_kmh": "u",
        "yawRate": "omega_z",
        "yaw_rate": "omega_z",
        "steering_angle": "steer",
        "vy": "v",
        "wheel_speed_fl": "omega_fl",
        "accel_x": "a_x_imu",
        "heading": "psi",
        "east": "x",
        "v_long_kmh": "u",
        "Vel Lat": "v",
        "swa_deg": "steer",
        "bearing_deg": "psi",
        "yaw_deg": "psi",
        "rpm_fl": "omega_fl",
        "rear_right_rpm": "omega_rr",
        "temperature": None,
        "steering_rate": None,
        "engine_rpm": None,
        "GPS Latitude": None,
        "acc_fwd": "a_x_imu",
        "acc_left": "a_y_imu",
        "speed_lateral": "v",
        "speed_left": None,
        "hand_wheel": "steer",
        "easting_m": "x",
        "northing_m": "y",
    }
    assert {name: channel_named(name) for name in names} == names


def test_an_ins_that_stands_elsewhere_turned_and_z_down_is_brought_to_its_places(clean):
    """The motion by a sensor 1.1 m behind and 0.4 m left of the centre of gravity, turned by 0.2 rad, x ahead, y right."""
    x, y, yaw = -1.1, 0.4, 0.2
    psi, omega = np.unwrap(clean["psi"]), clean["omega_z"]
    ahead, left = x - reference_vehicle().l_f, y
    east = clean["x"] + ahead * np.cos(psi) - left * np.sin(psi)
    north = clean["y"] + ahead * np.sin(psi) + left * np.cos(psi)
    u, v = clean["u"] - y * omega, clean["v"] + x * omega
    turned_u, turned_v = u * np.cos(yaw) + v * np.sin(yaw), -u * np.sin(yaw) + v * np.cos(yaw)
    values = {"x": east, "y": -north, "psi": -(psi + yaw), "u": turned_u, "v": -turned_v, "r": -omega}
    entries = {n: f"/ins:{'r' if n == 'omega_z' else n}" for n in ("x", "y", "psi", "u", "v", "omega_z")}
    table = {
        "channels": {**entries, "steer": "/can:steer"},
        "mount": {"/ins": {"x": x, "y": y, "yaw": yaw, "frame": "z-down"}},
    }
    series = {"/ins": Series("/ins", clean.t, values), "/can": Series("/can", clean.t, {"steer": clean["steer"]})}
    drive = merge("ins", map_from_table(table, "map"), series, reference_vehicle()).recording
    for name in ("x", "y", "psi", "u", "v", "omega_z"):
        truth = psi if name == "psi" else clean[name]
        assert np.allclose(drive[name], truth[: len(drive)], atol=2e-3), name


@pytest.mark.parametrize(
    ("group", "names"), [("psi", ("psi",)), ("u", ("u",)), ("position", ("x", "y")), ("steer", ("steer",))]
)
@pytest.mark.parametrize("late", [-1.2, -0.3, 0.5, 1.6])
def test_a_late_clock_is_found(clean, group, names, late):
    """Everything of one group late by the same time, the rest in time."""
    moved = {n: np.interp(clean.t - late, clean.t, np.unwrap(clean[n]) if n == "psi" else clean[n]) for n in names}
    if group == "position":
        moved["psi"] = clean["psi"]
    found = {o.group: o for o in time_offsets(clean.with_channels(**moved), reference_vehicle())}
    assert found[group].late_s == pytest.approx(late, abs=max(0.015, 3 * found[group].std))
    assert found[group].after > found[group].before


def test_offsets_need_no_lateral_velocity(clean):
    bare = replace(clean, channels={k: v for k, v in clean.channels.items() if k not in ("v", "x", "y", "psi")})
    late = bare.with_channels(steer=np.interp(clean.t - 0.6, clean.t, clean["steer"]))
    found = {o.group: o for o in time_offsets(late, reference_vehicle())}
    assert found["steer"].late_s == pytest.approx(0.6, abs=0.1)
    assert completed(late, reference_vehicle()).state_of("v") == "derived"
