"""An inconsistent drive whose clocks are off is told so; one that is inconsistent for another reason is not."""

from dataclasses import replace

import pytest

import softsoil
from softsoil.commands.estimate import as_json
from softsoil.estimator.late_clocks import CLOCKS, own_clocks, shifted
from softsoil.recording.derive import mark
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.noise import add_noise


@pytest.fixture(scope="module")
def log():
    return add_noise(softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 18.0), "good", 2)


def model(**numbers):
    return softsoil.bicycle(softsoil.load_vehicle("reference").with_(**numbers), softsoil.load_soil("clay"))


def test_no_clock_is_asked_for_twice_or_of_channels_that_are_not_there(log):
    assert set(own_clocks(log)) == set(CLOCKS)
    without = own_clocks(mark(log, "derived", *WHEEL_CHANNELS))
    assert without["steer"] == ("steer",) and "steer and the wheels" not in without


@pytest.mark.study
def test_a_clock_that_is_off_is_named_with_its_side_and_its_n(log):
    what, late = "steer and the wheels", 4
    drive = shifted(log, CLOCKS[what], -late)
    found = softsoil.estimate(drive, model(), 0.7)
    assert found.verdict.word == "inconsistent"
    clocks = softsoil.late_clocks(drive, model(), found)
    assert what in [clock.what for clock in clocks]
    clock = next(clock for clock in clocks if clock.what == what)
    assert clock.late == pytest.approx(late * log.dt, abs=0.015)
    assert abs(clock.n - 0.5) < max(0.03, 2 * clock.std)
    assert f"late = {clock.late:.2f}" in clock.sentence
    assert as_json(found, clocks)["late_clocks"][0]["what"] == clocks[0].what


@pytest.mark.study
def test_a_wrong_inertia_is_no_clock_and_an_identified_drive_is_not_looked_at(log):
    heavy = model(yaw_inertia=1.4 * model().geometry.yaw_inertia)
    found = softsoil.estimate(log, heavy, 0.7)
    assert found.verdict.word == "inconsistent" and softsoil.late_clocks(log, heavy, found) == ()
    good = replace(found, verdict=replace(found.verdict, word="identified"))
    assert good.verdict.usable and softsoil.late_clocks(log, heavy, good) == ()
