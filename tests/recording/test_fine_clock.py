"""A log of 10 Hz or less runs on a finer clock: inputs between samples, nothing measured between them."""

from dataclasses import replace

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.estimator.terrain import estimate_terrain
from softsoil.recording.clock import on_fine_clock
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY


def slow(hertz):
    log = read_drive(MULTI_LOG)
    t = np.arange(log.t[0], log.t[-1], 1.0 / hertz)
    channels = {k: t if k == "t" else np.interp(t, log.t, np.unwrap(v) if k == "psi" else v) for k, v in log.channels.items()}
    return replace(log, channels=channels, truth={})


def test_states_stand_at_their_own_samples_only():
    log = slow(10.0)
    fine = on_fine_clock(log)
    times = round(log.dt / fine.dt)
    assert times % 2 == 0 and fine.dt <= 0.0126
    assert np.array_equal(fine["v"][::times], log["v"]) and np.isfinite(fine["v"]).sum() == len(log)
    assert np.isfinite(fine["steer"]).all() and np.allclose(fine["steer"][::times], log["steer"], atol=1e-12)


def test_inputs_stay_beside_their_states_in_a_long_log_of_no_round_interval():
    """The interval of a log is rounded; a clock made of it would run away from the samples, and the inputs with it."""
    t = 0.040015 * np.arange(8000)
    log = Recording("long", {"t": t, "v": np.sin(t), "steer": np.sin(t)})
    fine = on_fine_clock(log)
    seen = np.isfinite(fine["v"])
    assert log.dt == 0.04 and seen.sum() == len(log) and np.abs(fine.t[seen] - t).max() < 1e-9
    assert np.abs(fine["steer"][seen] - fine["v"][seen]).max() < 1e-9


def test_a_fast_log_is_left_as_it_is():
    log = read_drive(MULTI_LOG)
    assert on_fine_clock(log) is log


@pytest.mark.study
@pytest.mark.parametrize(("hertz", "within"), [(10.0, 0.04), (5.0, 0.1)])
def test_n_of_a_slow_log_is_that_of_the_fast_one(hertz, within):
    model = bicycle(reference_vehicle(), CLAY)
    fast = estimate_terrain(read_drive(MULTI_LOG), model, 0.7, tied=True, start=2.0).n_front[-1]
    n = estimate_terrain(slow(hertz), model, 0.7, tied=True, start=2.0).n_front[-1]
    assert n == pytest.approx(fast, rel=within)
