"""What a map says of times and places: a part of a recording, the unit of a time column, places of one source's parts."""

import tomllib
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.importing.bring_in import idle_entries, read_sources
from softsoil.importing.draft_map import draft
from softsoil.importing.import_map import map_from_table
from softsoil.importing.merge import merge
from softsoil.importing.sources import Holding, Series, Spread
from softsoil.recording.read import read_drive

CHANNELS = {name: f"log.csv:{name}" for name in ("x", "y", "psi", "u", "v", "omega_z", "steer")}


@pytest.fixture(scope="module")
def clean():
    return read_drive(MULTI_LOG)


def merged(clean, **tables):
    series = {"log.csv": Series("log.csv", clean.t, {name: clean[name] for name in CHANNELS})}
    return merge("log", map_from_table({"channels": CHANNELS, **tables}, "map"), series, reference_vehicle())


def test_start_and_end_take_a_part_of_a_recording(clean):
    part = merged(clean, clock={"start": 3.0, "end": 12.0})
    rows = round(9.0 / clean.dt) + 1
    assert len(part.recording) == rows and part.recording.t[0] == 0.0
    assert abs(part.start_s - clean.t[0] - 3.0) < 1e-6
    first = round(3.0 / clean.dt)
    assert np.allclose(part.recording["u"], clean["u"][first : first + rows], atol=1e-9)
    assert len(merged(clean, clock={"start": 3.0}).recording) == len(clean) - first


def test_a_part_beyond_the_recording_is_refused(clean):
    with pytest.raises(ValueError, match=r"start and end within the .* s of the drive, found 500 to 600"):
        merged(clean, clock={"start": 500.0, "end": 600.0})


@pytest.mark.parametrize(("unit", "second"), [("ms", 1e3), ("us", 1e6), ("min", 1 / 60)])
def test_the_unit_of_a_time_column_that_does_not_say_it(unit, second, clean, tmp_path):
    path = tmp_path / "log.csv"
    pd.DataFrame({"t": (clean.t - clean.t[0]) * second, **{name: clean[name] for name in CHANNELS}}).to_csv(path, index=False)
    plan = map_from_table({"channels": CHANNELS, "sources": {"log.csv": {"time_unit": unit}}}, "map")
    assert np.allclose(read_sources([path], plan)["log.csv"].t, clean.t - clean.t[0], atol=1e-6)


def test_milliseconds_taken_for_seconds_are_asked_for(clean):
    series = {"log.csv": Series("log.csv", clean.t * 1e3, {name: clean[name] for name in CHANNELS})}
    with pytest.raises(ValueError, match=r'found 12 s: is its time in other units\? \[sources\."log\.csv"\] time_unit = "ms"'):
        merge("log", map_from_table({"channels": CHANNELS}, "map"), series, reference_vehicle())


def test_parts_of_one_source_have_places_of_their_own(clean):
    """Positions of an antenna 0.8 m behind the centre of gravity; velocities that the device has brought there already."""
    behind, psi = 0.8, np.unwrap(clean["psi"])
    away = behind + reference_vehicle().l_f
    antenna = {"x": clean["x"] - away * np.cos(psi), "y": clean["y"] - away * np.sin(psi)}
    series = {"log.csv": Series("log.csv", clean.t, {name: antenna.get(name, clean[name]) for name in CHANNELS})}
    place = {"x": -behind}
    plans = (map_from_table({"channels": CHANNELS, "mount": {name: place}}, "map") for name in ("position", "log.csv"))
    right, together = (merge("log", plan, series, reference_vehicle()).recording for plan in plans)
    for drive in (right, together):
        assert np.allclose(drive["x"], clean["x"][: len(drive)], atol=2e-3)
    assert np.allclose(right["v"], clean["v"][: len(right)], atol=1e-9)
    assert np.max(np.abs(together["v"] - clean["v"][: len(together)])) > 0.05


def test_a_mount_that_no_channel_has_is_doubted():
    def doubts(**mount):
        return idle_entries(map_from_table({"channels": CHANNELS, "mount": mount}, "map"))

    (check,) = doubts(**{"lgo.csv": {"x": 1.0}})
    assert check.sentence().startswith("mount.lgo.csv: expected a source of the map (log.csv); found no channel that")
    assert doubts(**{"log.csv": {"x": 0.0}, "position": {"x": 1.0}}) == ()


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"clock": {"strat": 1.0}}, "expected keys of rate_hz, start, end; found 'strat'"),
        ({"clock": {"start": 9.0, "end": 4.0}}, "found start 9 and end 4"),
        ({"clock": {"start": -1.0}}, "found start -1"),
        ({"sources": {"log.csv": {"time_unit": "h"}}}, "time_unit: expected one of s, ms, us, ns, min; found 'h'"),
        ({"sources": {"log.csv": {"tmie": "t"}}}, "sources.log.csv: expected time"),
        ({"sources": {"log.csv": {"time": 3}}}, "expected the name of a column, found 3"),
    ],
)
def test_faults_of_times_are_named(tables, words):
    with pytest.raises(ValueError, match=r"map\.toml") as fault:
        map_from_table({"channels": CHANNELS, **tables}, "map.toml")
    assert words in str(fault.value)


def test_a_receivers_heading_is_drafted_as_a_compasss_and_accelerations_by_their_units():
    spread = {"latitude_deg": (48.1, 48.2), "longitude_deg": (11.5, 11.6), "heading_deg": (0.2, 359.0), "acc_x_mps2": (-3.0, 2.0)}
    fields = {name: Spread(low, high, True) for name, (low, high) in spread.items()}
    holding = Holding("gnss.csv", "table", "gnss.csv", 500, 10.0, 0.0, 50.0, "utc_ms", fields)
    drafted = tomllib.loads(draft([holding]))["channels"]
    assert drafted["psi"] == {"source": "gnss.csv:heading_deg", "unit": "deg", "compass": True}
    assert drafted["a_x_imu"] == "gnss.csv:acc_x_mps2"
    fields["heading_deg"] = Spread(-179.0, 179.0, True)
    assert "compass" not in tomllib.loads(draft([replace(holding, fields=fields)]))["channels"]["psi"]


def test_turns_per_minute_are_known_wherever_a_name_says_so():
    fields = {name: Spread(100.0, 180.0, True) for name in ("rpm_fl", "wheel_rpm_front_right", "rl_rpm", "omega_rr")}
    drafted = tomllib.loads(draft([Holding("can.csv", "table", "can.csv", 500, 10.0, 0.0, 50.0, "t", fields)]))["channels"]
    for channel, name in (("omega_fl", "rpm_fl"), ("omega_fr", "wheel_rpm_front_right"), ("omega_rl", "rl_rpm")):
        assert drafted[channel] == {"source": f"can.csv:{name}", "unit": "rpm"}
    assert drafted["omega_rr"] == "can.csv:omega_rr"


def turned(clean, offsets):
    """A gyro with z down, a compass and an accelerometer that looks backwards, each with a bias, and `offsets` in their map."""
    values = {
        **{name: clean[name] for name in ("u", "steer")}, "gyro": -clean["omega_z"] + 0.03,
        "compass": np.pi / 2 - clean["psi"] + 0.08, "back": -clean["a_x_imu"] + 0.3, "right": -clean["a_y_imu"] + 0.4,
    }  # fmt: skip
    sources = {name: Series(f"{name}.csv", clean.t, {name: value}) for name, value in values.items() if name != "right"}
    sources["back"] = Series("back.csv", clean.t, {"back": values["back"], "right": values["right"]})
    from_ = {"u": "u.csv:u", "steer": "steer.csv:steer", "omega_z": "gyro.csv:gyro", "psi": "compass.csv:compass",
             "a_x_imu": "back.csv:back", "a_y_imu": "back.csv:right"}  # fmt: skip
    channels = {name: {"source": source, "offset": offsets.get(name, 0.0)} for name, source in from_.items()}
    channels["psi"]["compass"] = True
    mount = {"gyro.csv": {"frame": "z-down"}, "back.csv": {"yaw": np.pi}}
    plan = map_from_table({"channels": channels, "mount": mount}, "map")
    return merge("log", plan, {one.name: one for one in sources.values()}, reference_vehicle()).recording


def test_the_offset_that_a_check_says_takes_the_bias_away_however_the_sensor_is_turned(clean):
    """It counted before the turn, and what was added to the map doubled the bias."""
    names = ("omega_z", "psi", "a_x_imu", "a_y_imu")
    biased = turned(clean, {})
    cures = {name: -float(np.mean(np.unwrap(biased[name]) - np.unwrap(clean[name]))) for name in names}
    assert [abs(cure) for cure in cures.values()] == pytest.approx([0.03, 0.08, 0.3, 0.4], abs=1e-6)
    cured = turned(clean, cures)
    for name in names:
        assert np.allclose(np.unwrap(cured[name]), np.unwrap(clean[name]), atol=1e-6), name
