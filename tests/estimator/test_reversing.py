"""A log in whose middle the vehicle stops and reverses: used on both sides of it, said, and no window runs across it."""

from dataclasses import replace

import numpy as np
import pytest

import softsoil
from softsoil.checking.usable import usable
from softsoil.declaration.late_steering import late_steering
from softsoil.windows.shooting import Shooting, shooting_drive
from tests.reversing import with_reversing


@pytest.fixture(scope="module")
def model():
    return softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))


@pytest.fixture(scope="module")
def both():
    """A drive, the same with reversing in its middle, and the time at which that goes on."""
    whole = softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 30.0)
    log, on = with_reversing(whole, 0.5 * (whole.t[-1] - whole.t[0]))
    return whole, log, on


@pytest.fixture(scope="module")
def straight(both, model):
    return softsoil.estimate(both[0], model, n0=0.7, method="horizon")


@pytest.fixture(scope="module")
def found(both, model):
    return softsoil.estimate(both[1], model, n0=0.7)


@pytest.mark.parametrize("method", ["ukf", pytest.param("horizon", marks=pytest.mark.study)])
def test_an_estimate_goes_on_after_reversing(both, model, straight, found, method):
    on = both[2]
    if method == "horizon":
        found = softsoil.estimate(both[1], model, n0=0.7, method=method)
    assert found.verdict.word == "identified"
    assert found.n_front[-1] == pytest.approx(straight.n_front[-1], rel=0.05)
    assert found.t[-1] > on + 5.0


def test_no_window_runs_across_it(both, model):
    _, log, on = both
    drive = shooting_drive(usable(log, model.geometry, late_steering(model.geometry)), model, 2.0)
    windows = Shooting(model, drive, 1.0)
    ends = drive.t[windows.rows + windows.steps]
    assert (drive.measured[windows.rows[:, None] + np.arange(windows.steps + 1), 3] > 0.2).all()
    assert (ends < on - 10.0).any() and (drive.t[windows.rows] > on).any()
    for path in softsoil.predict(log, model, 0.5, 2.5).recorded[:, :, 3]:
        assert np.nanmin(path) > 0.2


def test_an_inconsistent_drive_that_stands_in_its_middle_has_no_late_clock(both, model, found):
    doubted = replace(found, verdict=replace(found.verdict, word="inconsistent"))
    whole = both[0]
    log, _ = with_reversing(whole, 0.5 * (whole.t[-1] - whole.t[0]), back=16.0)
    assert softsoil.late_clocks(log, model, doubted) == ()


def test_reversing_is_said(both, model):
    (note,) = (note for note in usable(both[1], model.geometry).notes if note.startswith("u:"))
    assert "the vehicle reverses for" in note
