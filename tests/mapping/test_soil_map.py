"""Soil maps: cells fused by information and by what drives disagree, and the soil of a drive of the model itself."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from drives import clay_bicycle, clay_drive
from softsoil.commands.map import _covered
from softsoil.estimator.tuning import ABSENT_WHEELS_ERROR
from softsoil.estimator.verdict import Verdict
from softsoil.figures.soil_map import fields
from softsoil.mapping import soil_map
from softsoil.mapping.cells import Cell, fuse
from softsoil.mapping.drive_soil import DriveSoil, drive_soil
from softsoil.mapping.frame import placed
from softsoil.mapping.map_file import as_json, load_map
from softsoil.mapping.place import largest_leap, misplaced, way_of
from softsoil.mapping.soil_map import SoilMap, laid, map_soil, surveyed
from softsoil.recording.derive import mark
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.noise import add_noise
from softsoil.symbolic.soil import CLAY


def drive(n, information, x=(1.0, 2.0), common=0.03, name="a"):
    count = len(x)
    n, information = np.full(count, n), np.full(count, information)
    return DriveSoil(name, Verdict("identified", ""), np.array(x), np.zeros(count), n, information, common)


@pytest.fixture(scope="module")
def log():
    return add_noise(clay_drive(25.0), "good", 2)


@pytest.fixture(scope="module")
def surveys(log):
    return surveyed(log, "", clay_bicycle(), 0.7, 1.0)


def test_drives_that_agree_are_fused_by_information():
    (cell,) = fuse([drive(0.50, 300.0), drive(0.54, 100.0)], 5.0)
    assert cell.n == pytest.approx(0.51) and (cell.windows, cell.drives) == (4, 2)
    assert cell.std == pytest.approx(np.hypot(np.sqrt(1 / 800), 0.03 * 0.51)) and cell.verdict == "identified"


def test_drives_that_contradict_each_other_are_no_confident_number():
    """One is surer than the other, which was all that counted."""
    (cell,) = fuse([drive(0.45, 800.0), drive(0.85, 40.0)], 5.0)
    assert cell.verdict == "inconsistent" and 0.5 < cell.n < 0.8
    assert cell.n - 2 * cell.std < 0.45 and cell.n + 2 * cell.std > 0.85


def test_the_error_common_to_all_drives_stays_however_many_there_are():
    (one,), (many,) = fuse([drive(0.5, 1e8)], 5.0), fuse([drive(0.5, 1e8, common=0.04)] * 9, 5.0)
    assert one.std == pytest.approx(0.03 * 0.5, rel=1e-4) and many.std == pytest.approx(0.04 * 0.5, rel=1e-4)


def test_ground_that_differs_within_a_large_cell_makes_it_uncertain():
    x = np.arange(1.0, 100.0, 2.0)
    both = replace(drive(0.5, 2000.0, x), n=np.where(x < 50.0, 0.45, 0.60))
    (cell,) = fuse([both], 100.0)
    assert cell.verdict == "inconsistent" and cell.std > 0.07
    assert {c.verdict for c in fuse([both], 10.0)} == {"identified"}


@pytest.mark.parametrize(
    ("n", "information", "word"), [(1.59, 1e4, "at_bound"), (0.5, 1e4, "identified"), (0.5, 50.0, "not_excited")]
)
def test_every_cell_has_a_verdict(n, information, word):
    assert [c.verdict for c in fuse([drive(n, information)], 5.0)] == [word]


def test_cells_are_told_by_place_and_need_two_windows():
    cells = fuse([drive(0.5, 100.0, (1.0, 2.0, 6.0, 7.0, 11.0))], 5.0)
    assert [(c.column, c.windows) for c in cells] == [(0, 2), (1, 2)]


@pytest.mark.parametrize("size", [0.0, np.nan, np.inf])
def test_a_cell_needs_a_size(size):
    with pytest.raises(ValueError, match="expected a positive number of metres"):
        fuse([drive(0.5, 100.0)], size)


@pytest.mark.study
def test_without_wheel_speeds_the_driveline_is_the_logs_and_the_error_wider(log):
    measured = drive_soil(log, clay_bicycle(), 0.7, 1.0)
    derived = drive_soil(mark(log, "derived", *WHEEL_CHANNELS), clay_bicycle(), 0.7, 1.0)
    flat, with_absent = (one.common**2 - one.verdict.evidence.soil.more**2 for one in (measured, derived))
    assert with_absent == pytest.approx(flat + ABSENT_WHEELS_ERROR**2)
    assert "wheel speeds from the balance of forces" in derived.verdict.reason or not derived.verdict.usable


def test_the_soil_of_a_drive_is_that_of_its_model(log, surveys):
    ground = laid([surveys], None, 15.0)
    assert surveys.verdict.word == "identified" and len(ground.cells) > 3
    assert np.mean([abs(c.n - 0.5) / c.std for c in ground.cells]) < 2.0
    assert np.mean([c.n for c in ground.cells]) == pytest.approx(0.5, abs=0.05)
    assert len(ground.cells) <= ground.driven < len(ground.cells) + 6
    assert surveys.covered > 0.9 and surveys.blocked["speed"] == 0.0
    cell = ground.cells[0]
    assert ground.at(15.0 * cell.column + 1.0, 15.0 * cell.row + 14.0) == cell and ground.at(-1e3, 0.0) is None


def test_windows_that_overlap_are_not_as_many_as_they_are():
    """n of white noise per second, in windows that share half of theirs with the next: the mean's error is the stated one."""
    rng, values, stated = np.random.default_rng(3), [], []
    for _ in range(400):
        halves = 0.5 + 0.03 * rng.standard_normal(13)
        one = replace(drive(0.5, 1e9, np.linspace(0.5, 4.5, 12), common=0.0), n=0.5 * (halves[:-1] + halves[1:]))
        (cell,) = fuse([one], 5.0)
        values.append(cell.n)
        stated.append(cell.std)
    assert np.median(stated) == pytest.approx(np.std(values), rel=0.2)


def test_windows_in_which_nothing_was_measured_are_in_no_cell():
    (cell,) = fuse([drive(0.5, 300.0), drive(0.7, 0.0, name="b")], 5.0)
    assert (cell.windows, cell.drives) == (2, 1) and cell.n == pytest.approx(0.5)
    assert fuse([drive(0.5, 0.0)], 5.0) == ()


def test_a_receiver_that_is_silent_for_a_while_leaves_the_map_as_it_is_elsewhere(log):
    silent = (log.t > log.t[0] + 9.0) & (log.t < log.t[0] + 14.0)
    deaf = log.with_channels(**{name: np.where(silent, np.nan, log[name]) for name in STATE_CHANNELS})
    ground = map_soil([deaf], clay_bicycle(), 0.7, cell=40.0)
    assert all(np.isfinite([cell.n, cell.std]).all() for cell in ground.cells) and len(ground.cells) > 1


def test_a_turn_without_positions_is_not_laid_on_its_chord(log):
    """Almost 10 s are known by speed and heading alone: windows lie where it drove, or nowhere; on the chord 1.4 m beside."""
    rows, t = np.arange(len(log)), log.t
    deaf = log.with_channels(**{name: np.where((rows >= 100) & (rows < 900), np.nan, log[name]) for name in ("x", "y")})
    one = drive_soil(deaf, clay_bicycle(), 0.7, 1.0)
    way = np.column_stack([log["x"], log["y"]])
    off = [np.min(np.hypot(*(way - [x, y]).T)) for x, y in zip(one.x, one.y, strict=True)]
    assert len(off) > 20 and max(off) < 0.5
    lost = log.with_channels(**{name: np.where(t > t[0] + 5.0, np.nan, log[name]) for name in ("x", "y")})
    one = drive_soil(lost, clay_bicycle(), 0.7, 1.0)
    assert 0.3 < one.blocked["position"] < 0.8 and len(one.x) < 25


def test_a_pause_of_the_logger_throws_no_window_off_the_way(log):
    """Rows left out, and the clock a minute on: speed is not integrated across."""
    before = log.t < log.t[0] + 12.0
    after = log.t > log.t[0] + 13.0
    kept = {name: np.concatenate([values[before], values[after]]) for name, values in log.channels.items()}
    kept["t"] = np.concatenate([log.t[before], log.t[after] + 60.0])
    one = drive_soil(replace(log, channels=kept, truth={}), clay_bicycle(), 0.7, 1.0)
    way = np.column_stack([log["x"], log["y"]])
    off = [np.min(np.hypot(*(way - [x, y]).T)) for x, y in zip(one.x, one.y, strict=True)]
    assert len(off) > 30 and max(off) < 0.3


def test_a_pause_of_the_logger_is_no_leap(log):
    """Rows that are left out, as a logger that was off does."""
    pause = (log.t > log.t[0] + 9.0) & (log.t < log.t[0] + 14.0)
    kept = replace(log, channels={name: values[~pause] for name, values in log.channels.items()}, truth={})
    assert misplaced(kept, 2.5) == "" and largest_leap(kept)[0] < 1.5


@pytest.mark.parametrize("every", [2, 4])
def test_the_way_of_a_slow_log_begins_where_its_windows_do(log, surveys, every):
    slow = replace(log, channels={name: values[::every] for name, values in log.channels.items()}, truth={})
    begin = surveyed(slow, "", clay_bicycle(), 0.7, 1.0).way[0]
    assert np.hypot(*(begin - surveys.way[0])) < 3.0


def test_a_drive_without_measured_positions_is_on_no_map(log, surveys):
    nowhere = mark(log, "derived", "x", "y")
    assert misplaced(nowhere, 2.5) == "its position is not measured"
    with pytest.raises(ValueError, match=r"expected a drive that can be laid on it, found none .*position is not measured"):
        map_soil([nowhere], clay_bicycle())


def test_a_drive_that_is_not_laid_on_the_map_is_not_estimated(log, monkeypatch):
    """Its reason is known before: a minute of the machine's for nothing."""
    asked = []
    monkeypatch.setattr(soil_map, "drive_soil", lambda recording, *_: asked.append(recording.name) or drive(0.5, 100.0))
    ground = map_soil([log, replace(log, name="copy"), replace(mark(log, "derived", "x"), name="nowhere")], clay_bicycle())
    assert asked == [log.name] and [bool(one.left_out) for one in ground.drives] == [False, True, True]
    assert ground.drives[1].verdict is None


@pytest.mark.parametrize("seconds", [1.0, 2.0, 5.0])
def test_a_receiver_that_comes_back_elsewhere_has_leapt(log, seconds):
    """A lost fix and 8 m to the side after it; without the 8 m it has not, nor where nothing else was measured meanwhile."""
    lost = (log.t > log.t[0] + 9.0) & (log.t < log.t[0] + 9.0 + seconds)
    x, y = (np.where(lost, np.nan, log[name]) for name in ("x", "y"))
    aside = y + np.where(log.t > log.t[0] + 9.0, 8.0, 0.0)
    assert "leaps by" in misplaced(log.with_channels(x=x, y=aside), 2.5)
    assert misplaced(log.with_channels(x=x, y=y), 2.5) == ""
    unknown = {name: np.where(lost, np.nan, log[name]) for name in ("u", "psi")}
    assert largest_leap(log.with_channels(x=x, y=aside, **unknown))[0] < 1.0


def test_a_leap_of_the_receiver_leaves_a_drive_out(log):
    """12 m to the side, half-way: what follows is at another place. One sample that is off, or a drift, is no leap."""
    late = log.t > log.t[0] + 12.0
    y = log["y"] + np.where(late, 12.0, 0.0)
    size, at = largest_leap(log.with_channels(y=y))
    assert size == pytest.approx(12.0, abs=0.5) and at == pytest.approx(log.t[0] + 12.0, abs=0.3)
    whys = [placed([one], None, 10.0)[0] for one in (log, log.with_channels(y=y))]
    assert "leaps by 1" in whys[1] and not whys[0]
    spike = log["y"].copy()
    spike[800] += 12.0
    gap = (log.t > log.t[0] + 8.0) & (log.t < log.t[0] + 10.0)
    without_speed = log.with_channels(u=np.where(gap, np.nan, log["u"]))
    assert misplaced(without_speed, 2.5) == ""
    drift = log["y"] + 12.0 * (log.t - log.t[0]) / np.ptp(log.t)
    assert misplaced(log.with_channels(y=spike), 2.5) == misplaced(log.with_channels(y=drift), 2.5) == ""


def test_the_same_log_twice_is_no_more_evidence(log):
    assert placed([log, replace(log, name="copy")], None, 15.0) == ["", f"it has the rows of {log.name}"]


def test_a_log_that_is_too_short_does_not_lose_the_others(log):
    short = log.between(0.0, 2.0)
    short = replace(short.with_channels(y=short["y"] + 1.0), name="short")  # another drive
    ground = map_soil([log, short], clay_bicycle(), 0.7, start=1.0)
    assert len(ground.used) == 1 and "expected at least" in ground.drives[1].left_out
    with pytest.raises(ValueError, match=r"cells of 0\.1 m are too small"):
        map_soil([log], clay_bicycle(), 0.7, start=1.0, cell=0.1)


def test_a_way_is_points_within_a_metre_of_each_other(log):
    way = way_of(log, 100)
    steps = np.hypot(*np.diff(way, axis=0).T)
    assert np.isfinite(way).all() and 0.4 < np.median(steps) < 1.2
    holed = log.with_channels(x=np.where((log.t > 10.0) & (log.t < 14.0), np.nan, log["x"]))
    assert np.isnan(way_of(holed, 100)).any()


def test_a_map_is_read_as_it_was_written(log, surveys, tmp_path):
    ground = laid([surveys], None, 15.0)
    path = tmp_path / "map.json"
    path.write_text(json.dumps(as_json(ground, CLAY, "turn_slip")), encoding="utf-8")
    back = load_map(path)
    assert back == SoilMap(15.0, ground.cells, driven=ground.driven) and back.driven > 0
    path.write_text("{}", encoding="utf-8")
    with pytest.raises(ValueError, match=r"map.json: expected a file of softsoil map, found another"):
        load_map(path)


def test_what_keeps_windows_from_a_drive_is_said(log):
    """Half of a drive whose steering kicks: no window, and the reason."""
    t = log.t - log.t[0]
    kicked = log.with_channels(steer=log["steer"] + np.where(t > 12.0, 0.2 * np.sign(np.sin(12.0 * t)), 0.0))
    one = drive_soil(kicked, clay_bicycle(), 0.7, 1.0)
    assert 0.3 < one.covered < 0.6 and one.blocked["steering"] > 0.05 and one.blocked["inputs"] == one.blocked["speed"] == 0.0
    assert re.fullmatch(r"windows in [3-5]\d % of it, none where the steering is faster than 1.5 rad/s", _covered(one))


def test_fields_far_from_each_other_are_drawn_each_for_itself():
    near = [Cell(i, 0, 0.5, 0.01, 3, 1, "identified") for i in range(6)]
    far = [Cell(3000 + i, 4, 0.6, 0.01, 3, 1, "inconsistent") for i in range(3)]
    assert fields([*far, *near]) == [near, far]
    assert fields([*near, *[replace(cell, column=cell.column + 20) for cell in near]])[1:] == []
    assert fields([]) == [[]]
