"""A drive on an even clock: untouched where it is even, interpolated where it jitters, empty where it has a gap."""

import numpy as np
import pytest

from softsoil.recording.clock import is_even, on_even_clock
from softsoil.recording.drive import Recording


def drive(t):
    t = np.asarray(t, dtype=float)
    psi = np.angle(np.exp(1j * 3.0 * t))
    return Recording("d", {"t": t, "u": 2.0 * t + 1.0, "psi": psi}, truth={"true_a": t})


def test_even_drive_is_untouched():
    even = drive(np.arange(100) * 0.012 + 0.008)
    assert is_even(even) and on_even_clock(even) is even


def test_jitter_is_interpolated_and_heading_does_not_jump():
    rng = np.random.default_rng(1)
    jittered = drive(np.arange(300) * 0.01 + rng.uniform(-0.003, 0.003, 300))
    again = on_even_clock(jittered)
    steps = np.diff(again.t)
    assert np.ptp(steps) < 1e-12
    good = np.isfinite(again["u"])
    assert good.mean() > 0.95
    assert np.allclose(again["u"][good], 2.0 * again.t[good] + 1.0, atol=1e-9)
    away = again["psi"] - 3.0 * again.t
    assert np.nanmax(np.abs(away - np.nanmedian(away))) < 1e-9


def test_gap_stays_empty():
    t = np.arange(200) * 0.01
    again = on_even_clock(drive(np.delete(t, range(80, 120))))
    inside = (again.t > 0.8) & (again.t < 1.19)
    assert np.isnan(again["u"][inside]).all()
    assert np.isfinite(again["u"][~inside]).mean() > 0.98
    assert again.notes and len(again) == 200


def test_a_sensor_with_rows_of_its_own_keeps_all_of_its_samples():
    """Rows of 100 Hz, and between two of them, 3 ms after one, those of a sensor of 5 Hz."""
    t = np.arange(0.0, 20.0, 0.01)
    slow = t[5::20] + 0.003
    both = np.sort(np.concatenate([t, slow]))
    is_slow = np.isin(both, slow)
    channels = {"t": both, "u": np.where(is_slow, np.nan, 2.0), "x": np.where(is_slow, 3.0 * both, np.nan)}
    again = on_even_clock(Recording("d", channels))
    assert np.isfinite(again["u"]).sum() == len(t)
    good = np.isfinite(again["x"])
    assert good.sum() == len(slow), "each sample at one time, and none twice"
    assert np.allclose(again["x"][good], 3.0 * again.t[good])


def test_one_sample_stays_one():
    t = np.sort(np.concatenate([np.arange(0.0, 2.0, 0.01), [1.013]]))
    again = on_even_clock(Recording("d", {"t": t, "u": np.ones(len(t)), "x": np.where(t == 1.013, 4.0, np.nan)}))
    assert np.isfinite(again["x"]).sum() == 1 and np.nanmax(again["x"]) == 4.0


@pytest.mark.parametrize("lost", [0.2, 0.34, 0.5])
def test_no_sample_of_a_channel_that_lacks_rows_stands_at_two_times(lost):
    rng = np.random.default_rng(3)
    t = np.arange(2000) * 0.01 + rng.uniform(-0.003, 0.003, 2000)
    noise = np.where(rng.uniform(size=len(t)) < lost, np.nan, rng.normal(size=len(t)))
    again = on_even_clock(Recording("d", {"t": t, "u": np.ones(len(t)), "omega_z": noise}))["omega_z"]
    given, kept = np.isfinite(noise).sum(), np.isfinite(again).sum()
    assert 0.93 * given < kept <= given


def test_no_slope_is_that_of_a_line_across_a_gap():
    """A channel rises, is missing for two seconds, and falls: at the rim of the gap it rises and falls."""
    rng = np.random.default_rng(4)
    t = np.arange(1000) * 0.01 + rng.uniform(-0.003, 0.003, 1000)
    value = np.where(t < 5.0, 10.0 * t, 100.0 - 10.0 * t)
    gone = (t > 4.0) & (t < 6.0)
    rows = np.where(gone, np.nan, value - np.where(t > 5.0, 30.0, 0.0))
    again = on_even_clock(Recording("d", {"t": t, "u": np.ones(len(t)), "x": rows}))
    good = np.isfinite(again["x"])
    expected = np.where(again.t < 5.0, 10.0 * again.t, 70.0 - 10.0 * again.t)
    assert np.abs(again["x"] - expected)[good].max() < 1e-6
