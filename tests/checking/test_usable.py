"""What Python is handed is checked and completed as what a command reads: tables, drives and files alike."""

import re
import warnings as python_warnings
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import softsoil
from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.cross_check import check_channels
from softsoil.checking.usable import usable
from softsoil.commands.options import open_drive
from softsoil.declaration.late_steering import late_steering
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.drive import CHECKED, WHEEL_CHANNELS
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY

PARTS = ("estimate", "predict", "residual", "refine")


@pytest.fixture(scope="module")
def good():
    return read_drive(MULTI_LOG)


@pytest.fixture(scope="module")
def model():
    return bicycle(reference_vehicle(), CLAY)


def call(name, log, model):
    if name in ("estimate", "predict"):
        return getattr(softsoil, name)(log, model)
    declared = softsoil.Declaration(reference_vehicle(), CLAY)
    return softsoil.refine([log], declared) if name == "refine" else softsoil.residual(log, declared)


@pytest.mark.parametrize("names", [("psi",), ("x", "y"), ("v",)])
def test_a_channel_that_is_stated_once_is_absent_and_derived(names, good):
    """A heading, or a place, of the start alone."""
    once = good.with_channels(**{name: np.where(np.arange(len(good)) == 0, good[name], np.nan) for name in names})
    drive = usable(once, reference_vehicle())
    assert all(drive.state_of(name) == "derived" and np.isfinite(drive[name]).all() for name in names)
    assert any(note.startswith(", ".join(names)) and "say nothing of a course" in note for note in drive.notes)


def test_a_speed_that_is_stated_once_is_no_speed(good):
    once = good.with_channels(u=np.where(np.arange(len(good)) == 0, good["u"], np.nan))
    with pytest.raises(ValueError, match=r"u: expected a vehicle that moves|found no u"):
        usable(once, reference_vehicle())


@pytest.mark.parametrize("channel", ["v", "steer", "u", "omega_z"])
def test_a_channel_that_ends_in_the_start_up_is_named(channel, good, model):
    ends = good.between(0.0, 12.0)
    ends = ends.with_channels(**{channel: np.where(ends.t < ends.t[0] + 1.9, ends[channel], np.nan)})
    with pytest.raises(ValueError, match=f"channel {channel}: expected numbers after the start-up of 2 s, found none"):
        softsoil.estimate(ends, model)


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("channel", ["steer", "v", "omega_fl", "omega_z"])
def test_a_flipped_sign_is_refused_by_every_public_name(name, channel, good, model):
    with pytest.raises(ValueError, match=rf"expected .* found (?s:.*)sign = -1|column '{channel}'|column 'psi'"):
        call(name, good.with_channels(**{channel: -good[channel]}), model)


@pytest.mark.parametrize("name", PARTS)
def test_a_table_in_memory_is_checked_too(name, good, model):
    table = pd.DataFrame({**good.channels, "steer": -good["steer"]})
    with pytest.raises(ValueError, match=r"table: steer: expected a yaw rate that follows"):
        call(name, table, model)
    with pytest.raises(ValueError, match=r"table: .*'steer', row \d+: expected rad"):
        call(name, pd.DataFrame({**good.channels, "steer": np.rad2deg(good["steer"])}), model)
    with pytest.raises(ValueError, match=r"table: expected column 'omega_z'"):
        call(name, table.drop(columns="omega_z"), model)


def test_a_drive_made_by_hand_has_its_units_checked(good):
    by_hand = replace(good, name="mine", meta={}).with_channels(steer=np.rad2deg(good["steer"]))
    with pytest.raises(ValueError, match=r"mine: column 'steer'"):
        usable(by_hand, reference_vehicle())


def test_absent_channels_are_those_of_the_command(good, tmp_path):
    bare = replace(good, channels={k: v for k, v in good.channels.items() if k not in ("v", *WHEEL_CHANNELS)}, truth={})
    path = softsoil.write_drive(bare, tmp_path / "bare.parquet")
    of_command, _ = open_drive(path, None)
    table = pd.DataFrame(dict(bare.channels))
    for log in (path, bare, table):
        drive = usable(log, reference_vehicle())
        assert drive.state_of("v") == drive.state_of("omega_rr") == "derived"
        for name in ("v", *WHEEL_CHANNELS):
            assert np.array_equal(drive[name], of_command[name]), name


def test_a_doubtful_channel_is_a_warning_and_a_note(good, model):
    early = good.with_channels(steer=np.interp(good.t + 0.3, good.t, good["steer"])).between(0.0, 20.0)
    with pytest.warns(UserWarning, match=r"steer: expected one clock .* 0\.\d+ ± .* early"):
        drive = usable(early, reference_vehicle())
    assert any(note.startswith("warning: steer") for note in drive.notes)
    owned = reference_vehicle().with_(effects={**reference_vehicle().effects, "steering_delay": {"steering_delay": 0.3}})
    assert late_steering(owned) == 0.3 and late_steering(reference_vehicle()) == 0.0
    with python_warnings.catch_warnings():
        python_warnings.simplefilter("error")
        usable(early, owned, late_steering(owned))
        softsoil.predict(early, bicycle(owned, CLAY))
    with pytest.warns(UserWarning, match=r"steer: .* where 0\.300 s early are declared"):
        usable(good, owned, late_steering(owned))
    late = good.with_channels(steer=np.interp(good.t - 0.3, good.t, good["steer"]))
    with pytest.raises(ValueError, match=r"steer: expected one clock .* late"):
        usable(late, owned, late_steering(owned))
    with pytest.warns(UserWarning, match="early"):
        softsoil.predict(early, model)


@pytest.mark.parametrize("late", [0.2, -0.2])
def test_the_cure_of_a_clock_shifts_no_lag_that_is_declared(late, good):
    """Road wheels 0.15 s behind `steer`, and its clock late or early besides: what is to be shifted is the clock alone."""
    shifted = good.with_channels(steer=np.interp(good.t + 0.15 - late, good.t, good["steer"]))
    (check,) = [c for c in check_channels(shifted, reference_vehicle(), 0.15) if c.name == "clock_steer"]
    assert float(check.cure.split("late = ")[1].split()[0]) == pytest.approx(late, abs=0.02)


@pytest.mark.parametrize("late", [0.3, 1.5, -1.5])
def test_refine_refuses_a_steering_clock_that_no_effect_explains_with_its_size_and_cure(late, good):
    shifted = good.with_channels(steer=np.interp(good.t - late, good.t, good["steer"]))
    with pytest.raises(ValueError, match="import shifts it: --align where") as fault:
        softsoil.refine([shifted], softsoil.Declaration(reference_vehicle(), CLAY))
    size, side = re.search(r"steer: expected one clock .*; found ([\d.]+) ± [\d.]+ s (late|early)", str(fault.value)).groups()
    assert float(size) == pytest.approx(abs(late), abs=0.02) and side == ("late" if late > 0 else "early")


def test_what_was_checked_is_not_checked_again_unless_it_changes(good, model):
    drive = usable(good, reference_vehicle())
    assert CHECKED in drive.meta and CHECKED in drive.between(0.0, 10.0).meta
    with python_warnings.catch_warnings():
        python_warnings.simplefilter("error")
        assert usable(drive, reference_vehicle()) is drive
    with pytest.raises(ValueError, match="sign = -1"):
        usable(drive.with_channels(v=-drive["v"]), reference_vehicle())


def test_a_model_of_ones_own_takes_a_drive_as_it_is(good):
    assert usable(good, None) is good


def test_the_models_own_drive_passes(model):
    made = synthetic_drive(model, reference_vehicle().radius, seconds=20.0, slip_rate=0.03)
    drive = add_noise(made, dict.fromkeys(WHEEL_CHANNELS, 1e-3), 1)  # four sensors
    with python_warnings.catch_warnings():
        python_warnings.simplefilter("error")
        usable(drive, reference_vehicle())


@pytest.mark.parametrize(
    ("number", "factor", "words"), [("l_f", 1.5, "expected the front axle"), ("radius", 0.8, "expected wheels of")]
)
def test_a_log_of_another_vehicle_is_a_warning(number, factor, words, good):
    vehicle = reference_vehicle()
    with pytest.warns(UserWarning, match=rf"{words} .*: another vehicle, or a sensor that is wrong"):
        usable(good, vehicle.with_(**{number: factor * getattr(vehicle, number)}))


def test_it_is_no_log_to_estimate_n_on(good):
    long = bicycle(reference_vehicle().with_(l_f=1.5 * reference_vehicle().l_f), CLAY)
    with (
        pytest.warns(UserWarning, match="another vehicle"),
        pytest.raises(ValueError, match=r"expected the front axle .*: another vehicle, or a sensor"),
    ):
        softsoil.estimate(good, long)
