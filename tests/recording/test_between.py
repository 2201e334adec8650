"""Rows between the samples of a slower sensor are no measurements, and n does not suffer from them."""

from dataclasses import replace

import numpy as np
import pytest

from drives import MULTI_LOG
from softsoil.cases.hostile import GPS, variant
from softsoil.checking.usable import checked
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.estimate import estimate
from softsoil.recording.between import held, only_samples, samples, straight
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive, write_drive
from softsoil.refinement.residual import residual
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle

VEHICLE = load_vehicle("reference")
T = np.arange(3000) * 0.01


@pytest.fixture(scope="module")
def noisy():
    return add_noise(read_drive(MULTI_LOG), "good", 3)


def log(noisy, name, tmp_path):
    """The variant called `name` of a drive, as a file holds it."""
    return write_drive(variant(name).of(noisy), tmp_path / "log.parquet")


def slow(period, line):
    """Samples every `period` s of a sensor with noise, as rows of T hold them, and the samples' times."""
    times = np.arange(0.0, T[-1] + period, period)
    values = np.sin(0.7 * times) + 0.05 * np.random.default_rng(1).standard_normal(len(times))
    return np.interp(T, times, values) if line else values[np.searchsorted(times, T, side="right") - 1], times


@pytest.mark.parametrize("period", [0.02, 0.025, 0.05, 0.072, 0.1, 0.37, 1.0])
def test_a_value_that_is_held_is_measured_once(period):
    values, times = slow(period, line=False)
    rows = held(values)
    assert rows is not None and abs(rows.sum() - len(times)) <= 2
    after = T[rows][:, None] - times
    assert np.where(after < -1e-9, np.inf, after).min(axis=1).max() < 0.01 + 1e-9, "the first row that holds it"


@pytest.mark.parametrize("digits", [16, 4])
@pytest.mark.parametrize("period", [0.02, 0.05, 0.072, 0.1, 0.37])
def test_a_line_between_samples_measures_nothing(period, digits):
    values, times = slow(period, line=True)
    rows = straight(T, np.round(values, digits))
    assert rows is not None and 0.9 * len(times) < rows.sum() <= len(times)
    assert np.abs(T[rows][:, None] - times).min(axis=1).max() < 0.01


def test_what_every_row_measures_stays(noisy):
    assert only_samples(noisy) is noisy and only_samples(read_drive(MULTI_LOG)).notes == ()
    noise = np.random.default_rng(2).standard_normal(len(T))
    coarse = np.round(np.cumsum(noise), 0)
    stairs = np.repeat(np.arange(6.0), 500)
    ramps = np.clip(np.mod(T, 3.0), 0.0, 0.2)
    for values in (noise, coarse, stairs, ramps, np.sin(T), np.zeros(len(T))):
        assert held(values) is None and straight(T, values) is None
        assert samples("u", T, values) is samples("u", T, np.where(T > 5.0, np.nan, values)) is None
    assert samples("u", T, np.full(len(T), np.nan)) is None


@pytest.mark.parametrize("line", [False, True])
@pytest.mark.parametrize("empty", [slice(0, 3), slice(777, 778), slice(500, 900)])
def test_an_empty_row_hides_no_samples(line, empty):
    values, times = slow(0.1, line)
    values[empty] = np.nan
    rows, said = samples("u", T, values)
    assert "samples 0.1 s from each other" in said and not rows[empty].any()
    there = len(times) - (empty.stop - empty.start) / 10
    assert 0.9 * there < rows.sum() <= there + 2


def test_a_steering_angle_that_the_driver_holds_is_one(noisy):
    angle = 0.1 * np.random.default_rng(4).standard_normal(len(noisy))
    stepped = np.repeat(angle, 100)[: len(noisy)]
    assert only_samples(replace(noisy, channels={**noisy.channels, "steer": stepped})).notes == ()


def test_the_notes_say_which_channels(noisy, tmp_path):
    drive, doubts = checked(read_drive(log(noisy, "x, y, u, v held at 10 Hz", tmp_path)), VEHICLE)
    assert doubts == ()
    assert [note.split(":")[0] for note in drive.notes] == list(GPS) and "samples 0.096 s" in drive.notes[0]
    assert all(0.1 < np.isfinite(drive[name]).mean() < 0.14 for name in GPS)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["x, y, u, v at 10 Hz, lines between",
     *(pytest.param(name, marks=pytest.mark.study) for name in ("x, y, u, v held at 10 Hz", "steer held at 20 Hz"))],
)  # fmt: skip
def test_n_is_identified_from_such_logs(noisy, name, tmp_path):
    found = estimate(log(noisy, name, tmp_path), bicycle(VEHICLE, CLAY), 0.7, method="horizon")
    assert found.verdict.word == "identified" and abs(found.n_front[-1] / 0.5 - 1.0) < 0.06


@pytest.mark.slow
def test_the_residual_of_such_a_log_is_that_of_the_whole_one(noisy, tmp_path):
    declared = Declaration(VEHICLE, CLAY)
    whole, held_ = residual(noisy, declared), residual(log(noisy, "x, y, u, v held at 10 Hz", tmp_path), declared)
    for axle in ("front", "rear"):
        assert 0.3 < held_.axles[axle]["rms"] / whole.axles[axle]["rms"] < 3.0
    assert held_.mse["0.5"]["omega_z"] < 2.0 * whole.mse["0.5"]["omega_z"]
