"""A drive on an even clock: untouched where it is even, interpolated where it jitters, empty where it has a gap."""

import numpy as np

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
