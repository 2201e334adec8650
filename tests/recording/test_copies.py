"""A log counts once: as it is, in part, and whatever else is in it."""

from dataclasses import replace

import numpy as np
import pytest

from drives import CLAY_LOG, MULTI_LOG
from softsoil.recording.copies import copies, refuse_copies
from softsoil.recording.read import read_drive


@pytest.fixture(scope="module")
def drive():
    return read_drive(MULTI_LOG)


@pytest.mark.parametrize(("begin", "end"), [(0.0, 44.9), (10.0, 28.0), (-1.0, 1e3)])
def test_a_part_of_a_log_is_that_log(drive, begin, end):
    part = replace(drive.between(begin, end), name="part")
    assert copies([drive, part]) == ["", drive.name] and copies([part, drive]) == ["", "part"]
    with pytest.raises(ValueError, match=r"part: expected drives that differ, found the rows of multi_clay_n0\.50 again"):
        refuse_copies([drive, part])


def test_parts_that_follow_each_other_are_two_drives(drive):
    first, second = drive.between(0.0, 20.0), replace(drive.between(19.0, 44.0), name="second")
    assert copies([first, second, read_drive(CLAY_LOG)]) == ["", "", ""]


def test_vehicles_that_stand_are_no_copies_of_each_other(drive):
    still = {name: np.concatenate([np.zeros(len(drive)), drive[name]]) for name in ("x", "y", "u", "omega_z")}
    one = replace(drive, channels={"t": 0.012 * np.arange(2 * len(drive)), **still}, truth={})
    other = replace(one, channels={**one.channels, "y": one["y"] + 1.0 * (one["u"] != 0.0)}, name="other")
    assert copies([one, other]) == ["", ""]


def test_drives_whose_rows_mostly_hold_a_coarse_yaw_rate_are_no_copies_of_each_other(drive):
    """The clock is a gyro's of 0.06 deg/s, positions and speeds come at one row in eight: half the rows recurred anywhere."""

    def recorded(source, name):
        seldom = np.arange(len(source)) % 8 != 0
        channels = {key: np.where(seldom, np.nan, source[key]) for key in ("x", "y", "u")}
        step = np.deg2rad(0.061)
        return replace(source.with_channels(**channels, omega_z=step * np.round(source["omega_z"] / step)), name=name)

    one, other = recorded(drive, "one"), recorded(read_drive(CLAY_LOG), "other")
    assert copies([one, other]) == ["", ""]
    assert copies([one, replace(one.between(5.0, 20.0), name="part")]) == ["", "one"]


@pytest.mark.parametrize("every", (2, 5))
def test_a_log_thinned_is_that_log(drive, every):
    thin = replace(drive, channels={name: values[::every] for name, values in drive.channels.items()}, truth={}, name="thin")
    assert copies([drive, thin]) == ["", drive.name]


def test_logs_without_what_is_compared_are_no_copies(drive):
    empty = drive.with_channels(**{name: np.full(len(drive), np.nan) for name in ("x", "y", "u", "omega_z")})
    assert copies([empty, replace(empty, name="other")]) == ["", ""]


def test_without_positions_runs_of_rows_are_compared(drive):
    def blind(source, name):
        gone = {key: np.full(len(source), np.nan) for key in ("x", "y")}
        coarse = {"omega_z": np.round(source["omega_z"], 2), "u": np.round(source["u"], 1)}
        return replace(source.with_channels(**gone, **coarse), name=name)

    one, other = blind(drive, "one"), blind(read_drive(CLAY_LOG), "other")
    assert copies([one, other, replace(one.between(5.0, 20.0), name="part")]) == ["", "", "one"]
