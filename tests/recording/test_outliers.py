"""Samples that stand out from their neighbours are left out, the vehicle's own motion is not."""

import numpy as np
import pytest

from drives import CLAY_LOG, LOAM_LOG, MULTI_LOG
from softsoil.cases.hostile import variant
from softsoil.recording.noise import add_noise
from softsoil.recording.outliers import FEW, LEAST, outliers, without_outliers
from softsoil.recording.read import read_drive, write_drive

T = np.arange(0.0, 20.0, 0.01)


def wrong_rows(share, seed=1):
    return np.random.default_rng(seed).random(len(T)) < share


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_wrong_samples_are_found_and_the_rest_is_not(noise):
    rng, wrong = np.random.default_rng(2), wrong_rows(0.02)
    right = 0.4 * np.sin(2.0 * T) + noise * rng.standard_normal(len(T))
    found = outliers("omega_z", right + 2.0 * wrong)
    assert found[wrong].mean() > 0.95 and found[~wrong].mean() < 0.001
    assert not outliers("omega_z", right).any()


def test_a_step_and_a_peak_of_the_motion_stay():
    steps = 0.3 * np.sign(np.sin(3.0 * T))
    peaks = np.maximum(0.0, 1.0 - np.abs(np.mod(T, 0.2) - 0.1) / 0.02)  # five times a second up and down within 0.04 s
    assert not outliers("steer", steps).any() and not outliers("omega_z", peaks).any()


def test_few_are_left_to_robust_fits_and_many_are_no_outliers():
    for share in (0.3 * FEW, 0.3):
        assert not outliers("omega_z", 0.4 * np.sin(2.0 * T) + 2.0 * wrong_rows(share)).any()


def test_a_heading_that_wraps_is_none():
    assert not outliers("psi", np.angle(np.exp(1j * T))).any()


@pytest.mark.parametrize("log", [MULTI_LOG, CLAY_LOG, LOAM_LOG])
def test_right_drives_have_none(log):
    for drive in (read_drive(log), add_noise(read_drive(log), "table5", 1)):
        assert without_outliers(drive) is drive


def test_a_file_is_read_without_them_and_says_so(tmp_path):
    clean = read_drive(MULTI_LOG)
    path = write_drive(variant("2 % of samples wrong").of(clean), tmp_path / "log.parquet")
    drive = read_drive(path)
    (note,) = drive.notes
    assert note.startswith("samples that stand out from their neighbours are left out: u ")
    good = np.isfinite(drive["omega_z"])
    assert 0.01 < 1.0 - good.mean() < 0.03 and np.abs(drive["omega_z"] - clean["omega_z"])[good].max() < LEAST["omega_z"]
