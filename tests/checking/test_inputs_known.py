"""Where steering and wheel speeds are known, and what is said of the rest."""

import numpy as np
import pytest

from drives import CLAY_LOG, MULTI_LOG, reference_vehicle
from softsoil.checking.usable import usable
from softsoil.recording.between import samples
from softsoil.recording.clock import on_fine_clock
from softsoil.recording.drive import Recording
from softsoil.recording.forward import HELD_INPUTS, MISSED, inputs_known
from softsoil.recording.read import read_drive

T = np.arange(0.0, 10.0, 0.01)


def drive(t, steer):
    return Recording("d", {"t": t, "u": np.full(len(t), 3.0), "omega_z": np.zeros(len(t)), "steer": steer})


@pytest.mark.parametrize("length", [0.5 * HELD_INPUTS, 2.0 * HELD_INPUTS])
def test_a_short_gap_is_bridged_and_a_long_one_is_not(length):
    gap = (T > 4.0) & (4.0 + length > T)
    known = inputs_known(drive(T, np.where(gap, np.nan, 0.1)))
    assert np.array_equal(known, ~gap if length > HELD_INPUTS else np.ones(len(T), dtype=bool))


def test_long_before_the_first_and_after_the_last_number_nothing_is_known():
    outside = (T < 0.995) | (T > 9.005)
    far = (T < 0.995 - HELD_INPUTS) | (T > 9.005 + HELD_INPUTS)
    assert np.array_equal(inputs_known(drive(T, np.where(outside, np.nan, 0.1))), ~far)


def test_a_slow_sensor_has_longer_gaps():
    rows = np.arange(len(T)) % 40 == 0  # 2.5 Hz
    assert inputs_known(drive(T, np.where(rows, 0.1, np.nan)))[T[rows][-1] >= T].all()
    rows[(T > 4.0) & (T < 4.0 + 1.1 * MISSED * 0.4)] = False
    unknown = ~inputs_known(drive(T, np.where(rows, 0.1, np.nan)))
    assert unknown[(T > 4.1) & (T < 4.9)].all() and not unknown[T < 3.9].any()


def test_a_steering_slower_than_its_log_survives_the_fine_clock():
    t = np.arange(0.0, 20.0, 0.05)
    rows = np.arange(len(t)) % 2 == 0
    rows[(t > 8.0) & (t < 10.0)] = False
    fine = on_fine_clock(drive(t, np.where(rows, np.sin(t), np.nan)))
    inside = (fine.t > 8.05) & (fine.t < 9.95)
    outside = (fine.t < 7.9) | ((fine.t > 10.1) & (fine.t < 19.9))
    assert np.isnan(fine["steer"][inside]).all() and np.isfinite(fine["steer"][outside]).all()


@pytest.mark.parametrize(("hertz", "stop"), [(50.0, 1.0), (50.0, 0.4), (20.0, 0.4)])
def test_a_steering_that_waves_between_stops_is_measured_in_every_row(hertz, stop):
    """A clean angle at another rate, as a file or as a state of such a shape: a curve, which rests at its stops."""
    log = read_drive(CLAY_LOG)
    t = np.arange(log.t[0], log.t[-1], 1.0 / hertz)
    angle = np.interp(t, log.t, np.clip(log["steer"], -stop, stop))
    assert samples("steer", t, angle) is None and samples("y", t, angle) is None


def test_the_notes_say_how_long_inputs_are_missing():
    log = read_drive(MULTI_LOG)
    gap = (log.t > log.t[0] + 15.0) & (log.t < log.t[0] + 16.0)
    holed = usable(log.with_channels(steer=np.where(gap, np.nan, log["steer"])), reference_vehicle())
    (note,) = [note for note in holed.notes if "missing for" in note]
    assert "missing for 0.996 s" in note and "no window" in note
    assert not [note for note in usable(log, reference_vehicle()).notes if "missing for" in note]
