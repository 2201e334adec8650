"""The parts of a drive that go forwards: standstills and reversing are left out, noise and gaps are not."""

import numpy as np
import pytest

from softsoil.recording.drive import Recording
from softsoil.recording.forward import driven, with_note_of_reversing


def log(u, dt=0.01):
    u = np.asarray(u, dtype=float)
    return Recording("log", {"t": 3.0 + dt * np.arange(len(u)), "u": u}, {"true_n": np.arange(len(u), dtype=float)})


def test_a_drive_without_a_standstill_is_driven_throughout():
    assert driven(log(np.full(500, 4.0)), 2.0).all()


@pytest.mark.parametrize("speed", [0.0, -1.5])
@pytest.mark.parametrize("start", [0.0, 1.0])
def test_standing_reversing_and_the_start_up_after_them_are_not_driven(speed, start):
    drive = log(np.r_[np.full(100, speed), np.full(300, 4.0), np.full(100, speed), np.full(500, 3.0), np.full(50, speed)])
    expected, later = drive["u"] > 0, round(start / drive.dt)
    expected[100 : 100 + later] = expected[500 : 500 + later] = False
    np.testing.assert_array_equal(driven(drive, start + drive.dt / 2), expected)


def test_a_dip_shorter_than_a_standstill_and_a_gap_do_not_cut():
    u = np.full(400, 4.0)
    u[100:115] = 0.0
    u[200:260] = np.nan
    assert driven(log(u)).all()


def test_a_gap_inside_a_standstill_belongs_to_it():
    u = np.r_[np.full(300, 4.0), np.zeros(100), np.full(200, 4.0)]
    u[320:380] = np.nan
    np.testing.assert_array_equal(driven(log(u)), np.r_[np.ones(300, bool), np.zeros(100, bool), np.ones(200, bool)])


@pytest.mark.parametrize("u", [np.full(100, -1.0), np.full(100, np.nan)])
def test_a_log_that_never_goes_forwards_is_not_driven(u):
    assert not driven(log(u)).any()


def test_reversing_is_noted_with_its_length_and_standing_is_not():
    forwards = np.full(300, 4.0)
    standing = log(np.r_[forwards, np.zeros(100), forwards])
    assert with_note_of_reversing(standing) is standing
    u = np.r_[forwards, np.full(202, -1.0), forwards, np.full(101, -1.0)]
    u[1:-1:2] = np.nan  # of a sensor at half the clock's rate
    (note,) = with_note_of_reversing(log(u)).notes
    assert "reverses for 3 s" in note and "first at 6 s" in note and "n is held there" in note
