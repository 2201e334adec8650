"""A very fast log runs on a coarser clock: medians of blocks of rows, no more believed for its rate."""

from dataclasses import replace

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.usable import mark_checked, usable
from softsoil.estimator.estimate import estimate
from softsoil.recording.clock import on_coarse_clock
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY


def fast(hertz, seconds=np.inf):
    log = read_drive(MULTI_LOG).between(0.0, seconds)
    t = np.arange(log.t[0], log.t[-1], 1.0 / hertz)
    channels = {k: t if k == "t" else np.interp(t, log.t, np.unwrap(v) if k == "psi" else v) for k, v in log.channels.items()}
    return replace(log, channels=channels, truth={})


@pytest.mark.parametrize(("hertz", "rows"), [(1000.0, 12), (400.0, 5), (200.0, 2)])
def test_rows_become_blocks_of_a_clock_near_the_model_s(hertz, rows):
    log = fast(hertz, 20.0)
    coarse = on_coarse_clock(log)
    assert coarse.dt == pytest.approx(rows / hertz) and len(coarse) == len(log) // rows
    assert coarse.t[0] == pytest.approx(log.t[:rows].mean())
    assert coarse["steer"][7] == pytest.approx(np.median(log["steer"][7 * rows : 8 * rows]))
    assert f"{rows} rows" in coarse.notes[-1]


def test_no_slower_log_is_touched():
    for log in (read_drive(MULTI_LOG), fast(100.0, 20.0), fast(50.0, 20.0)):
        assert on_coarse_clock(log) is log


def test_a_block_has_the_median_of_its_numbers_across_a_turn_of_the_heading():
    t = 0.001 * np.arange(48)
    psi = np.angle(np.exp(1j * (np.pi + 0.01 * (np.arange(48) - 18))))
    v = np.where(np.arange(48) < 24, np.nan, 1.0)
    v[30], v[13] = 99.0, 2.0
    coarse = on_coarse_clock(Recording("fast", {"t": t, "psi": psi, "v": v}))
    assert np.allclose(np.diff(coarse["psi"]), 0.12)
    assert np.isnan(coarse["v"][0]) and coarse["v"][1:].tolist() == [2.0, 1.0, 1.0]


@pytest.mark.study
def test_commands_run_on_the_coarse_clock_and_believe_the_rate_no_more():
    log, model = read_drive(MULTI_LOG).between(0.0, 15.0), bicycle(reference_vehicle(), CLAY)
    again = fast(1000.0, 15.0)
    assert usable(again, reference_vehicle()).dt == usable(mark_checked(again), reference_vehicle()).dt == pytest.approx(0.012)
    slow, quick = estimate(log, model, 0.7), estimate(again, model, 0.7)
    assert quick.verdict.word == slow.verdict.word == "identified"
    assert quick.n_front[-1] == pytest.approx(slow.n_front[-1], rel=0.03)
    assert quick.n_front_std[-1] == pytest.approx(slow.n_front_std[-1], rel=0.3)
