"""The part of a drive that goes forwards: standstills and reversing cut it, noise and gaps do not."""

import numpy as np
import pytest

from softsoil.recording.drive import Recording
from softsoil.recording.forward import forward_part


def log(u, dt=0.01):
    u = np.asarray(u, dtype=float)
    return Recording("log", {"t": 3.0 + dt * np.arange(len(u)), "u": u}, {"true_n": np.arange(len(u), dtype=float)})


def test_a_drive_without_a_standstill_is_left_alone():
    drive = log(np.full(500, 4.0))
    assert forward_part(drive) is drive


@pytest.mark.parametrize("speed", [0.0, -1.5])
def test_the_longest_stretch_between_standstills_is_kept(speed):
    drive = log(np.r_[np.full(100, speed), np.full(300, 4.0), np.full(100, speed), np.full(500, 3.0), np.full(50, speed)])
    part = forward_part(drive)
    np.testing.assert_array_equal(part.t, drive.t[500:1000])
    np.testing.assert_array_equal(part["u"], 3.0)
    np.testing.assert_array_equal(part.truth["true_n"], np.arange(500, 1000))
    assert len(part.notes) == 1 and "500 of 1050 rows" in part.notes[0] and "8 to 12.99 s" in part.notes[0]


def test_a_dip_shorter_than_a_standstill_and_a_gap_do_not_cut():
    u = np.full(400, 4.0)
    u[100:115] = 0.0
    u[200:260] = np.nan
    drive = log(u)
    assert forward_part(drive) is drive


def test_a_gap_inside_a_standstill_belongs_to_it():
    u = np.r_[np.full(300, 4.0), np.zeros(100), np.full(200, 4.0)]
    u[320:380] = np.nan
    assert len(forward_part(log(u))) == 300


@pytest.mark.parametrize("u", [np.full(100, -1.0), np.full(100, np.nan)])
def test_a_log_that_never_goes_forwards_comes_back_as_it_is(u):
    drive = log(u)
    assert forward_part(drive) is drive
