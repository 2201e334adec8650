"""Every fault of a log is named: file, column, row, what was expected."""

import gzip

import numpy as np
import pandas as pd
import pytest

from drives import CLAY_LOG, LOAM_LOG, clay_drive
from softsoil.recording.columns import load_columns
from softsoil.recording.drive import CHANNEL_UNITS, Recording
from softsoil.recording.read import read_drive, write_drive


@pytest.fixture
def table() -> pd.DataFrame:
    """Six seconds of a good log."""
    return pd.DataFrame(clay_drive(6.0).channels)


@pytest.fixture
def read(table, tmp_path):
    """Writes a changed table and reads it: read(change) with change(table) -> table or None."""

    def go(change=lambda table: None, name="log.csv", columns=None):
        changed = change(table)
        path = tmp_path / name
        (table if changed is None else changed).to_csv(path, index=False)
        return read_drive(path, columns)

    return go


@pytest.mark.parametrize("name", ["late.csv", "late.csv.gz", "late.parquet"])
def test_large_times_and_places_are_written_whole(tmp_path, name):
    """To the last digit: a clock that counts from the machine's start, positions in a national grid."""
    drive = clay_drive(3.0)
    drive = drive.with_channels(t=drive.t + 20000.0, x=drive["x"] + 4.5e6)
    again = read_drive(write_drive(drive, tmp_path / name))
    for channel, values in drive.channels.items():
        np.testing.assert_array_equal(again[channel], values, channel)
    assert again.dt == drive.dt


def broken(column, row, value):
    def change(table):
        table[column] = table[column].astype(object)
        table.loc[row - 1, column] = value

    return change


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t.drop(columns="omega_z"), ["log.csv", "expected column 'omega_z'", "found columns"]),
        (lambda t: t.rename(columns={"omega_z": "omega_Z"}), ["expected column 'omega_z'", "nearest is 'omega_Z'"]),
        (lambda t: t.rename(columns={"u": "u [m/s]"}), ["nearest is 'u [m/s]', whose unit softsoil import reads"]),
        (broken("v", 17, "fast"), ["log.csv", "'v'", "row 17", "expected a number", "'fast'"]),
        (broken("t", 30, 0.0), ["'t'", "row 30", "expected time to increase", "`softsoil import` puts"]),
        (lambda t: pd.concat([t, t]), ["'t'", "expected time to increase", "the clock was set back, or another log begins"]),
        (broken("t", 12, np.nan), ["'t'", "row 12", "expected a time"]),
        (lambda t: t.assign(steer=np.rad2deg(t.steer)), ["'steer'", "row", "expected rad", "degrees?", 'unit = "deg"']),
        (lambda t: t.assign(omega_z=np.rad2deg(t.omega_z)), ["'omega_z'", "expected rad/s", "degrees?"]),
        (lambda t: t.assign(psi=np.rad2deg(t.psi)), ["'psi'", "expected rad", "degrees?"]),
        (lambda t: t.assign(psi=-t.psi), ["'psi'", "grows to the left", "sign = -1"]),
        (lambda t: t.assign(omega_z=-t.omega_z), ["'omega_z'", "grows to the left", "heading and steering say", "z-down"]),
        (lambda t: t.assign(u=3.6 * t.u), ["'u'", "expected m/s", "km/h?"]),
        (lambda t: t.assign(t=1000 * t.t), ["'t'", "expected seconds", "milliseconds?", 'unit = "ms"']),
        (lambda t: t.assign(t=1e6 * t.t), ["'t'", "expected seconds", "microseconds?", 'unit = "us"']),
        (lambda t: t.assign(t=1e9 * t.t), ["'t'", "expected seconds", "nanoseconds?", 'unit = "ns"']),
        (lambda t: t.assign(u=np.nan), ["'u'", "expected numbers, found none"]),
        (lambda t: t.iloc[:1], ["expected at least 2 rows, found 1"]),
        (lambda t: t.iloc[:0], ["expected rows of data", "header only"]),
    ],
    ids=[
        "missing",
        "misnamed",
        "with its unit",
        "text",
        "backwards",
        "two logs",
        "nan time",
        "steer deg",
        "rate deg",
        "psi deg",
        "psi sign",
        "rate sign",
        "km/h",
        "ms",
        "us",
        "ns",
        "empty column",
        "1 row",
        "0 rows",
    ],
)
def test_fault_is_named(read, change, words):
    with pytest.raises(ValueError) as fault:
        read(change)
    for word in words:
        assert word in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_table_with_another_separator_is_sent_to_import(tmp_path):
    path = tmp_path / "log.csv"
    pd.DataFrame({"t": [0.0, 0.1], "u": [1.0, 1.0]}).to_csv(path, sep=";", index=False)
    with pytest.raises(ValueError, match="expected column 't', separated by commas; softsoil import reads other separators"):
        read_drive(path)


def test_missing_values_and_gaps_are_noted_not_refused(read):
    def change(table):
        table.loc[5:7, "v"] = np.nan
        return table.drop(index=range(40, 60))

    drive = read(change)
    assert any("v: 3 of" in note and "row 6" in note for note in drive.notes)
    assert any("gap of" in note and "row 40" in note for note in drive.notes)
    assert np.isnan(drive["v"][5:8]).all()


def test_a_slower_sensor_is_no_loss_of_values(read):
    """Positions in every fourth row, and one of them lost: the note says their rate, not how many rows are without."""

    def change(table):
        rows = np.arange(len(table))
        return table.assign(**{name: table[name].where((rows % 4 == 0) & (rows != 20)) for name in ("x", "y")})

    drive = read(change)
    (note,) = [note for note in drive.notes if note.startswith("x, y")]
    rate = 0.25 / drive.dt
    assert note == f"x, y: of a sensor of {rate:.3g} Hz, in {int(np.isfinite(drive['x']).sum())} of {len(drive)} rows"


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda folder: folder, "found a folder"),
        (lambda folder: folder / "none.csv", "found no such file"),
        (lambda folder: _file(folder / "empty.csv", b""), "found an empty file"),
        (lambda folder: _file(folder / "log.txt", b"t,x\n1,2\n"), "expected a file name ending in"),
        (lambda folder: _file(folder / "log.parquet", b"not parquet"), "cannot be read"),
        (lambda folder: _file(folder / "log.csv.gz", b"not gzip"), "cannot be read"),
        (lambda folder: _file(folder / "cut.csv.gz", gzip.compress(b"t,x\n" * 9999)[:40]), "cannot be read"),
        (lambda folder: _file(folder / "bytes.csv", bytes(range(256))), "log|read|column|table"),
    ],
    ids=["folder", "absent", "empty", "suffix", "parquet", "gzip", "cut", "bytes"],
)
def test_file_that_is_no_log_is_named(tmp_path, make, words):
    path = make(tmp_path)
    with pytest.raises(ValueError, match=words) as fault:
        read_drive(path)
    assert str(path) in str(fault.value)


def _file(path, content):
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("suffix", [".csv", ".csv.gz", ".parquet"])
def test_what_is_written_is_read(tmp_path, suffix):
    drive = clay_drive(2.0)
    again = read_drive(write_drive(drive, tmp_path / f"drive{suffix}"))
    assert again.name == "drive"
    for name, values in drive.channels.items():
        assert np.allclose(again[name], values, rtol=1e-5, atol=1e-6), name


def test_own_logs_read_whole():
    for path, rows in ((CLAY_LOG, 2750), (LOAM_LOG, 2750)):
        drive = read_drive(path)
        assert len(drive) == rows and not drive.notes
        assert drive.dt == pytest.approx(0.012)
        assert {"true_fy_fl", "true_vy_rr", "true_delta_fl"} <= set(drive.truth)
        assert not any(name.startswith("true_") for name in drive.channels)


def test_column_map_converts_names_units_and_signs(table, tmp_path):
    other = table.rename(columns={"u": "speed", "steer": "wheel angle", "t": "stamp"})
    other["speed"] *= 3.6
    other["wheel angle"] = -np.rad2deg(other["wheel angle"])
    other["stamp"] *= 1000
    other.to_csv(tmp_path / "log.csv", index=False)
    (tmp_path / "map.toml").write_text(
        'u = {column = "speed", unit = "km/h"}\nt = {column = "stamp", unit = "ms"}\n'
        'steer = {column = "wheel angle", unit = "deg", sign = -1}\n',
        encoding="utf-8",
    )
    drive = read_drive(tmp_path / "log.csv", load_columns(tmp_path / "map.toml", CHANNEL_UNITS))
    for name in ("u", "t", "steer"):
        assert np.allclose(drive[name], table[name], atol=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("u = 3", 'expected {column = "name"'),
        ('speed = "u"', "found 'speed'"),
        ('omga_z = "r"', "did you mean 'omega_z'"),
        ('u = {column = "a", unit = "furlong"}', "expected a unit of m/s"),
        ('u = {column = "a", unit = ["m/s"]}', "expected a unit of m/s"),
        ('u = {column = "a", scale = 2}', "found 'scale'"),
        ('u = {column = "a", sign = "minus"}', "expected a number for sign"),
        ("u = {", "expected TOML"),
    ],
)
def test_column_map_faults_are_named(tmp_path, text, words):
    path = tmp_path / "map.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"map\.toml") as fault:
        load_columns(path, CHANNEL_UNITS)
    assert words in str(fault.value)


def test_recording_refuses_what_does_not_fit():
    with pytest.raises(ValueError, match="expected a channel 't'"):
        Recording("a", {"x": np.zeros(3)})
    with pytest.raises(ValueError, match=r"channel x: expected shape \(3,\)"):
        Recording("a", {"t": np.arange(3.0), "x": np.zeros(2)})
    with pytest.raises(ValueError, match="increasing time"):
        Recording("a", {"t": np.array([0.0, 1.0, 1.0])})
    with pytest.raises(KeyError, match="expected one of t"):
        Recording("a", {"t": np.arange(3.0)})["v"]


def test_a_sensor_of_20_hz_on_rows_of_50_hz_is_one_of_20_hz(tmp_path):
    t = np.arange(0.0, 20.0, 0.02)
    seen = np.isin(np.arange(len(t)), np.round(np.arange(0.0, 20.0, 0.05) / 0.02).astype(int))
    wave = 0.1 * np.sin(t)
    table = pd.DataFrame({"t": t, "u": 3.0, "omega_z": wave, "steer": wave, "x": np.where(seen, 3 * t, np.nan)})
    table.to_csv(tmp_path / "log.csv", index=False)
    assert any(note.startswith("x: of a sensor of 20 Hz") for note in read_drive(tmp_path / "log.csv").notes)


@pytest.mark.parametrize("name", ["../outside", "field/one", "..", "a\\b"])
def test_no_name_of_a_drive_leads_out_of_a_folder(table, tmp_path, name):
    """Figures are called by it."""
    drive = Recording(name, {column: table[column].to_numpy() for column in table})
    found = read_drive(write_drive(drive, tmp_path / "drive.parquet", named=True)).name
    assert found and not set(found) & set("/\\") and not found.startswith(".")


@pytest.mark.parametrize("seen", [(0.0, 10.0), (50.0, 60.0)])
def test_a_gyro_that_is_missing_for_a_while_says_nothing_of_the_heading_there(tmp_path, seen):
    """To the left first, then to the right: what it read last is not how the vehicle turns later."""
    t = np.arange(0.0, 60.0, 0.01)
    rate = np.where(t < 12.0, 0.3, -0.3)
    channels = {"t": t, "u": np.full(len(t), 5.0), "psi": 0.01 * np.cumsum(rate), "steer": 0.3 * rate}
    channels["omega_z"] = np.where((t >= seen[0]) & (t < seen[1]), rate, np.nan)
    assert read_drive(write_drive(Recording("lost", channels), tmp_path / "lost.parquet")).measured("psi")


def test_the_heading_of_a_long_log_with_a_slow_yaw_rate_is_not_in_degrees(tmp_path):
    """Rows of 100 Hz, a yaw rate of 2.5 Hz: empty cells are no zeros of its integral."""
    t = np.arange(0.0, 4000.0, 0.01)
    rate = 0.5 * np.sin(0.1 * t)
    channels = {"t": t, "u": np.full(len(t), 5.0), "psi": 0.01 * np.cumsum(rate), "steer": 0.3 * rate}
    channels["omega_z"] = np.where(np.arange(len(t)) % 40 == 0, rate, np.nan)
    path = write_drive(Recording("long", channels), tmp_path / "long.parquet")
    assert read_drive(path).measured("psi")


@pytest.mark.parametrize(("turns", "degrees"), [(0.15, False), (0.15, True), (1.0, True)])
def test_a_heading_that_jumps_at_half_a_turn_is_not_in_degrees(tmp_path, turns, degrees):
    """A slight weave towards the west, with a noisy heading that is wrapped: each jump is a whole turn within a second."""
    t = np.arange(0.0, 40.0, 0.01)
    rate = turns * np.sin(2.0 * t)
    psi = np.pi - 0.5 * turns + 0.01 * np.cumsum(rate) + 0.03 * np.random.default_rng(1).standard_normal(len(t))
    psi = np.angle(np.exp(1j * psi))
    heading = np.degrees(psi) if degrees else psi
    channels = {"t": t, "u": np.full(len(t), 5.0), "psi": heading, "omega_z": rate, "steer": 0.3 * rate}
    path = write_drive(Recording("half", channels), tmp_path / "half.parquet")
    if not degrees:
        assert read_drive(path).measured("psi")
        return
    with pytest.raises(ValueError, match=r"expected rad, found a heading that turns .* degrees"):
        read_drive(path)
