"""n does not depend on the rate of a log, nor on a gap in one of its channels."""

from dataclasses import replace

import numpy as np
import pytest

from drives import LOAM_LOG, MULTI_LOG, reference_vehicle
from softsoil.checking.usable import usable
from softsoil.estimator.estimate import estimate
from softsoil.estimator.terrain import _first, estimate_terrain
from softsoil.estimator.tuning import Tuning
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SANDY_LOAM

NOISE = {"psi": 0.003, "u": 0.05, "v": 0.05, "omega_z": 0.005}


def at_rate(hertz):
    """The drive on sandy loam, whose steering is the fastest, with lines between its samples."""
    log = read_drive(LOAM_LOG)
    t = np.arange(log.t[0], log.t[-1], 1.0 / hertz)
    channels = {k: t if k == "t" else np.interp(t, log.t, np.unwrap(v) if k == "psi" else v) for k, v in log.channels.items()}
    return Recording(log.name, channels)


@pytest.mark.study
def test_a_log_of_fewer_hertz_says_the_same():
    model = bicycle(reference_vehicle(), SANDY_LOAM)
    whole = estimate(read_drive(LOAM_LOG).between(0.0, 20.0), model, 0.8)
    slow = estimate(at_rate(50.0).between(0.0, 20.0), model, 0.8)
    assert whole.verdict.word == slow.verdict.word == "identified"
    assert slow.n_front[-1] == pytest.approx(whole.n_front[-1], rel=0.02)


@pytest.mark.study
def test_a_gap_in_an_input_is_left_out():
    model, log = bicycle(reference_vehicle(), CLAY), read_drive(MULTI_LOG).between(0.0, 25.0)
    gap = (log.t > log.t[0] + 15.0) & (log.t < log.t[0] + 17.0)
    holed = log.with_channels(**{name: np.where(gap, np.nan, log[name]) for name in ("steer", *WHEEL_CHANNELS)})
    whole, found = (estimate(drive, model, 0.7) for drive in (log, holed))
    assert found.verdict.word == "identified" and not found.changes
    assert found.n_front[-1] == pytest.approx(whole.n_front[-1], rel=0.02)
    assert np.ptp(found.n_front[(found.t > log.t[0] + 15.3) & (found.t < log.t[0] + 16.9)]) < 0.02, "n learns little in it"


def slow_positions(hertz, row=0):
    """A drive with x and y in so many of its rows per second, from a certain one on, and its true ones."""
    drive = add_noise(read_drive(MULTI_LOG).between(0.0, 15.0), {**NOISE, "x": 0.02, "y": 0.02}, 1)
    seen = np.arange(len(drive)) % round(1.0 / hertz / drive.dt) == row
    return drive.with_channels(**{name: np.where(seen, drive[name], np.nan) for name in ("x", "y")}), read_drive(MULTI_LOG)


@pytest.mark.parametrize("hertz", [10.0, 2.0])
def test_an_estimate_starts_where_slow_positions_say(hertz):
    """It started at the third of them, 7 m away at 2 Hz."""
    drive, truth = slow_positions(hertz)
    found = estimate_terrain(drive, bicycle(reference_vehicle(), CLAY), 0.7, tied=True)
    away = np.hypot(*(found.states[:, i] - np.interp(found.t, truth.t, truth[name]) for i, name in enumerate(("x", "y"))))
    assert away.max() < 1.0 and away[found.t > 1.5].max() < 0.3 and not found.counts.gated and found.drift is None


@pytest.mark.parametrize(("late", "speed", "most"), [(0.1, 0.0, 0.1), (8.0, 0.0, 0.1), (2.0, 5.0, 11.0)])
def test_a_channel_that_begins_later_is_as_uncertain_as_it_changes_until_then(late, speed, most):
    """No line through noise of a few rows is drawn back over seconds."""
    t = np.arange(0.0, 30.0, 0.01)
    values = speed * t + np.random.default_rng(3).normal(0.0, 0.05, len(t))
    first, std = _first(t, np.where(t < late, np.nan, values))
    assert abs(first) < 3.0 * std + 0.1 and std < most


def test_an_outlier_among_the_first_samples_spoils_no_first_state():
    drive, _ = slow_positions(5.0)
    x = drive["x"].copy()
    x[np.flatnonzero(np.isfinite(x))[1]] += 30.0
    found = estimate_terrain(drive.with_channels(x=x), bicycle(reference_vehicle(), CLAY), 0.7, tied=True)
    truth = read_drive(MULTI_LOG)
    assert np.abs(found.states[:, 0] - np.interp(found.t, truth.t, truth["x"])).max() < 1.0


@pytest.mark.parametrize("row", [0, 1])
def test_samples_in_rows_without_an_update_count_at_the_next_one(row):
    drive, truth = slow_positions(10.0, row)
    found = estimate_terrain(drive, bicycle(reference_vehicle(), CLAY), 0.7, tied=True, tuning=Tuning(update_every=2))
    assert np.hypot(found.states[-1, 0] - truth["x"][len(drive)], found.states[-1, 1] - truth["y"][len(drive)]) < 0.3


@pytest.mark.parametrize("pause", [2.0, 8.0])
def test_a_pause_of_a_log_is_no_drift(pause):
    drive = add_noise(read_drive(MULTI_LOG).between(0.0, 30.0), "good", 1)
    there = (drive.t < 15.0) | (drive.t > 15.0 + pause)
    channels = {name: values[there] for name, values in drive.channels.items() if name not in ("x", "y")}
    log = usable(Recording("paused", channels), reference_vehicle())
    assert estimate_terrain(log, bicycle(reference_vehicle(), CLAY), 0.7, tied=True).drift is None


@pytest.mark.study
def test_what_the_model_leaves_of_a_slow_log_is_asked_too():
    """A steering 0.02 rad off at 40 Hz, with a vehicle's file that states no errors: n was identified."""
    drive = add_noise(read_drive(MULTI_LOG).between(0.0, 25.0), "good", 1)
    slow = replace(drive, channels={name: values[::2] for name, values in drive.channels.items()}, truth={})
    model = bicycle(reference_vehicle().with_(joint_error=None, uncertainty={}), CLAY)
    assert estimate(slow, model, 0.7).verdict.word == "identified"
    found = estimate(slow.with_channels(steer=slow["steer"] + 0.02), model, 0.7)
    assert found.verdict.word == "inconsistent" and "unexplained" in found.verdict.reason
