"""A single number that cannot be, and a speed so noisy that its rows say nothing: the log is used, and what was left out said."""

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.geometry_check import beyond_doubt
from softsoil.checking.usable import usable
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.outliers import without_absurd
from softsoil.recording.read import read_drive


@pytest.fixture(scope="module")
def good():
    return read_drive(MULTI_LOG)


@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e9])
@pytest.mark.parametrize("channel", ["x", "psi", "u", "v", "omega_z", "steer", "omega_fl", "a_y_imu"])
def test_one_such_number_is_left_out_and_said(good, channel, value):
    values = good[channel].copy()
    values[1500] = value
    drive = usable(good.with_channels(**{channel: values}), reference_vehicle())
    assert f"numbers that cannot be are left out: {channel} 1" in drive.notes
    assert not np.isfinite(drive[channel][1500])
    kept = np.delete(drive[channel], 1500)
    np.testing.assert_array_equal(kept, np.delete(good[channel], 1500))


def test_a_channel_full_of_them_is_in_another_unit_and_stays(good):
    far = good.with_channels(u=good["u"] * 1e6)
    assert without_absurd(far) is far


def test_the_radius_of_a_crawling_drive_is_no_choice_of_noisy_rows(good):
    """At 0.8 m/s with Table 5's noise of 0.25 m/s, the rows above 1 m/s are those whose noise is high."""
    share = 0.8 / float(np.median(good["u"]))
    rng = np.random.default_rng(1)
    spins = {name: share * good[name] for name in WHEEL_CHANNELS}
    slow = good.with_channels(u=share * good["u"] + 0.25 * rng.standard_normal(len(good)), **spins)
    alone = slow.with_channels(x=np.full(len(good), np.nan))
    assert beyond_doubt(alone, reference_vehicle()) == ""
