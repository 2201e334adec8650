"""How a map's fields become channels: means of several, one speed for several wheels, tables, rows without a channel."""

import math

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.importing.bring_in import bring_in, idle_entries
from softsoil.importing.import_map import map_from_table, split_label
from softsoil.importing.merge import merge
from softsoil.importing.sources import Series
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.read import read_drive

LEAST = {name: f"log.csv:{name}" for name in ("u", "omega_z", "steer")}
VEHICLE = reference_vehicle()


@pytest.fixture(scope="module")
def clean():
    return read_drive(MULTI_LOG).between(0.0, 20.0)


def recording(clean, channels, **values):
    series = Series("log.csv", clean.t, {**{name: clean[name] for name in LEAST}, **values})
    return merge("log", map_from_table({"channels": {**LEAST, **channels}}, "map"), {"log.csv": series}, VEHICLE).recording


def test_a_mean_of_encoders_that_start_anew_each_turn_is_that_of_their_rates(clean):
    turned = {name: np.cumsum(clean[name]) * clean.dt for name in ("omega_rl", "omega_rr")}
    wrapped = {name: (angle + math.pi) % (2 * math.pi) - math.pi for name, angle in turned.items()}
    both = {"source": [f"log.csv:{name}" for name in wrapped], "rate": True}
    drive = recording(clean, {"omega_rl": both, "omega_fl": {"source": "log.csv:omega_rl", "rate": True}}, **wrapped)
    rates = {name: np.gradient(angle, clean.t) for name, angle in turned.items()}
    assert np.allclose(drive["omega_fl"], rates["omega_rl"], atol=1e-6)
    assert np.allclose(drive["omega_rl"], 0.5 * sum(rates.values()), atol=1e-6)


@pytest.mark.parametrize(("unit", "turn"), [("rad", 2 * math.pi), ("deg", 360.0)])
def test_a_mean_of_two_headings_knows_that_a_turn_is_nothing(clean, unit, turn):
    """Two receivers near 180 degrees, one on each side of it."""
    heading = turn / 2 + 0.02 * turn * np.sin(clean.t)
    a, b = ((heading + off + turn / 2) % turn - turn / 2 for off in (0.003 * turn, -0.003 * turn))
    drive = recording(clean, {"psi": {"source": ["log.csv:a", "log.csv:b"], "unit": unit}}, a=a, b=b)
    assert np.allclose(np.exp(1j * drive["psi"]), np.exp(1j * heading * 2 * math.pi / turn), atol=1e-6)


def test_one_speed_of_all_wheels_beside_one_wheels_own_stands_for_the_others(clean):
    mean = np.mean([clean[name] for name in WHEEL_CHANNELS], axis=0)
    drive = recording(clean, {"omega_all": "log.csv:motor", "omega_fl": "log.csv:fl"}, motor=mean, fl=clean["omega_fl"])
    assert drive.state_of("omega_fl") == "measured" and np.allclose(drive["omega_fl"], clean["omega_fl"])
    assert [drive.state_of(name) for name in WHEEL_CHANNELS[1:]] == ["derived"] * 3
    turning = (drive["omega_rr"] - drive["omega_rl"]) * VEHICLE.radius / VEHICLE.rear_track
    assert np.allclose(turning, drive["omega_z"], atol=1e-9)


def test_the_clock_of_a_slow_yaw_rate_is_its_own_and_a_drive_begins_where_all_are_there(clean):
    rate, speed = np.full(len(clean), np.nan), clean["u"].copy()
    rate[::5] = clean["omega_z"][::5]
    speed[clean.t < clean.t[0] + 6.9] = np.nan
    plan = map_from_table({"channels": LEAST}, "map")
    series = {"log.csv": Series("log.csv", clean.t, {"u": speed, "omega_z": rate, "steer": clean["steer"]})}
    found = merge("log", plan, series, VEHICLE)
    assert found.recording.dt == pytest.approx(5 * clean.dt)
    assert found.start_s - clean.t[0] == pytest.approx(6.9, abs=5 * clean.dt)


def test_a_channel_without_a_number_is_named(clean):
    series = {"log.csv": Series("log.csv", clean.t, {**{n: clean[n] for n in LEAST}, "u": np.full(len(clean), np.nan)})}
    with pytest.raises(ValueError, match=r"log\.csv:u: expected numbers for u, found 0"):
        merge("log", map_from_table({"channels": LEAST}, "map"), series, VEHICLE)


def test_samples_beyond_a_table_are_counted(clean):
    half = 0.5 * float(np.abs(clean["steer"]).max())
    channels = {"steer": {"source": "log.csv:steer", "table": [[-half, -half], [half, half]]}}
    beyond = int((np.abs(clean["steer"]) > half).sum())
    assert f"steer: log.csv:steer: {beyond} of {len(clean)} samples lie beyond its table, taken as its ends" in recording(
        clean, channels
    ).notes
    blank = np.where(np.arange(len(clean)) % 10 == 0, clean["steer"], np.nan)
    rare = {"steer": {**channels["steer"], "source": "log.csv:rare"}}
    told = f" of {int(np.isfinite(blank).sum())} samples lie beyond its table"
    assert any(told in note for note in recording(clean, rare, rare=blank).notes)
    whole = {"steer": {"source": "log.csv:steer", "table": [[-3 * half, -1.0], [3 * half, 1.0]]}}
    assert not any("beyond its table" in note for note in recording(clean, whole).notes)


@pytest.mark.parametrize(
    ("label", "parts"),
    [
        ("drive_12:30.csv:u", ("drive_12:30.csv", "u")),
        ("log.csv.gz:speed: mean", ("log.csv.gz", "speed: mean")),
        ("/odom:twist.x", ("/odom", "twist.x")),
        ("log.csv: u", ("log.csv", "u")),
    ],
)
def test_a_colon_may_stand_in_a_file_s_name(label, parts):
    assert split_label(label) == parts


@pytest.mark.parametrize(("key", "value"), [("rate", "no"), ("compass", "false"), ("compass", 0)])
def test_what_is_true_or_false_is_no_word(key, value):
    with pytest.raises(ValueError, match=rf"channels.psi.{key}: expected true or false, found {value!r}"):
        map_from_table({"channels": {"psi": {"source": "log.csv:psi", key: value}}}, "map")


def test_a_time_column_of_no_source_is_doubted():
    plan = map_from_table({"channels": LEAST, "sources": {"lgo.csv": {"time_unit": "ms"}}}, "map")
    (check,) = idle_entries(plan)
    assert check.sentence().startswith("sources.lgo.csv: expected a source of the map (log.csv); found no channel that")


def test_an_antenna_s_positions_come_to_the_front_axle_without_a_heading(clean):
    """A receiver 0.9 m behind and 0.3 m left of the centre of gravity, 10 Hz, no heading and no v."""
    psi, slow = np.unwrap(clean["psi"]), np.arange(len(clean)) % 8 == 0
    ahead, left = -0.9 - VEHICLE.l_f, 0.3
    at = {"x": clean["x"] + ahead * np.cos(psi) - left * np.sin(psi), "y": clean["y"] + ahead * np.sin(psi) + left * np.cos(psi)}
    fixes = {name: np.where(slow, values, np.nan) for name, values in at.items()}
    channels = {**LEAST, **{name: f"gps.csv:{name}" for name in fixes}}
    mount = {"gps.csv": {"x": -0.9, "y": 0.3}}
    series = {"log.csv": Series("log.csv", clean.t, {name: clean[name] for name in LEAST}),
              "gps.csv": Series("gps.csv", clean.t, fixes)}  # fmt: skip
    found = bring_in("log", map_from_table({"channels": channels, "mount": mount}, "map"), series, VEHICLE)
    moved = found.merged.recording
    away = np.hypot(moved["x"] - clean["x"], moved["y"] - clean["y"])[slow]
    assert np.nanmedian(away) < 0.05 and np.nanmax(away) < 0.25
    assert any("aligned with them, since no heading is mapped" in note for note in moved.notes)
    assert found.drive.state_of("x") == "measured"
