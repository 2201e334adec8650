"""Soil maps: cells fused by information, and the soil of a drive of the model itself."""

import numpy as np
import pytest

from drives import clay_bicycle, clay_drive
from softsoil.estimator.tuning import ABSENT_WHEELS_ERROR
from softsoil.estimator.verdict import Verdict
from softsoil.mapping.soil_map import DriveSoil, drive_soil, fuse
from softsoil.recording.derive import mark
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.noise import add_noise


def drive(n, information, x=(1.0, 2.0), common=0.03):
    count = len(x)
    n, information = np.full(count, n), np.full(count, information)
    return DriveSoil("a", Verdict("identified", ""), np.array(x), np.zeros(count), n, information, common)


def test_drives_are_fused_by_information():
    (cell,) = fuse([drive(0.5, 300.0), drive(0.8, 100.0)], 5.0)
    assert cell.n == pytest.approx(0.575) and (cell.windows, cell.drives) == (4, 2)
    assert cell.std > np.sqrt(1 / 800)


def test_the_error_common_to_all_drives_stays_however_many_there_are():
    (one,), (many,) = fuse([drive(0.5, 1e8)], 5.0), fuse([drive(0.5, 1e8, common=0.04)] * 9, 5.0)
    assert one.std == pytest.approx(0.03 * 0.5, rel=1e-4) and many.std == pytest.approx(0.04 * 0.5, rel=1e-4)


def test_cells_are_told_by_place_and_need_two_windows():
    cells = fuse([drive(0.5, 100.0, (1.0, 2.0, 6.0, 7.0, 11.0))], 5.0)
    assert [(c.column, c.windows) for c in cells] == [(0, 2), (1, 2)]


def test_a_cell_needs_a_size():
    with pytest.raises(ValueError, match="expected a positive number of metres"):
        fuse([drive(0.5, 100.0)], 0.0)


def test_without_wheel_speeds_the_driveline_is_the_logs_and_the_error_wider():
    log = add_noise(clay_drive(25.0), "good", 2)
    measured = drive_soil(log, clay_bicycle(), 0.7, 1.0)
    derived = drive_soil(mark(log, "derived", *WHEEL_CHANNELS), clay_bicycle(), 0.7, 1.0)
    flat, with_absent = (one.common**2 - one.verdict.evidence.soil.more**2 for one in (measured, derived))
    assert with_absent == pytest.approx(flat + ABSENT_WHEELS_ERROR**2)
    assert "wheel speeds from the balance of forces" in derived.verdict.reason or not derived.verdict.usable


def test_the_soil_of_a_drive_is_that_of_its_model():
    soil = drive_soil(add_noise(clay_drive(25.0), "good", 2), clay_bicycle(), 0.7, 1.0)
    assert soil.verdict.word == "identified"
    cells = fuse([soil], 15.0)
    assert len(cells) > 3
    assert np.mean([abs(c.n - 0.5) / c.std for c in cells]) < 2.0
    assert np.mean([c.n for c in cells]) == pytest.approx(0.5, abs=0.05)
