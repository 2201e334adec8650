"""Noise of channels, white or as a filter leaves it, is told from motion, and n does not suffer from it."""

import re
import warnings

import numpy as np
import pytest
from scipy.signal import filtfilt, lfilter

from drives import MULTI_LOG
from softsoil.cases.hostile import variant
from softsoil.checking.clocks import filter_checks
from softsoil.checking.usable import checked
from softsoil.estimator.estimate import estimate
from softsoil.recording.noise import add_noise, low_pass
from softsoil.recording.noise_level import noise_level
from softsoil.recording.read import read_drive
from softsoil.recording.states import sensor_std
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle

VEHICLE = load_vehicle("reference")
STATES = ("u", "v", "omega_z")


@pytest.fixture(scope="module")
def clean():
    return read_drive(MULTI_LOG)


@pytest.fixture(scope="module")
def noisy(clean):
    return add_noise(clean, "table5", 3)


def white(dt, seed):
    return np.random.default_rng(seed).standard_normal(round(60.0 / dt))


@pytest.mark.parametrize("dt", [0.005, 0.01, 0.02, 0.1])
def test_white_noise_is_what_it_is(dt):
    level = noise_level(white(dt, 1), dt)
    assert level.std == level.white == level.rough == pytest.approx(1.0, rel=0.1)
    assert level.late == 0.0


@pytest.mark.parametrize("dt", [0.005, 0.01, 0.02])
@pytest.mark.parametrize("seconds", [0.02, 0.04])
@pytest.mark.parametrize("twice", [False, True])
def test_noise_of_a_low_pass_counts_as_the_white_noise_before_it(dt, seconds, twice):
    kept = np.exp(-dt / seconds)
    found = []
    for seed in range(10):
        run = filtfilt if twice else lfilter
        noise = run([1.0 - kept], [1.0, -kept], white(dt, seed))
        level = noise_level(noise, dt)
        found.append((level.std / noise.std(), level.white, level.late))
        assert level.rough < 0.9 * noise.std()
    std, as_white, late = np.mean(found, axis=0)
    assert std == pytest.approx(1.0, abs=0.05) and as_white == pytest.approx(1.0, abs=0.12)
    assert late == pytest.approx(0.0 if twice else dt * kept / (1.0 - kept), abs=0.25 * seconds)


@pytest.mark.parametrize("rows", [2000, 4000, 12000])
def test_a_pause_makes_no_low_pass_slower(rows):
    """The time between samples was that of the whole log over their number: a pause made a filter later, or hid it."""
    dt, kept = 0.012, np.exp(-0.012 / 0.02)
    noise = lfilter([1.0 - kept], [1.0, -kept], white(dt, 4))
    paused = np.concatenate([noise[:2500], np.full(rows, np.nan), noise[2500:]])
    late = noise_level(noise, dt).late
    assert late > 0.01 and noise_level(paused, dt).late == pytest.approx(late, rel=0.1)


def test_motion_is_no_low_pass_of_a_slow_log():
    """Third differences at two distances do not tell white noise and a fast slalom from filtered noise."""
    dt = 0.048
    t = dt * np.arange(1000)
    for seed in range(20):
        values = 0.4 * np.sin(2.0 * np.pi * 0.5 * t) + 0.01 * np.random.default_rng(seed).standard_normal(len(t))
        assert noise_level(values, dt).late == 0.0


def test_a_slow_channel_has_its_own_samples():
    values = np.full(6000, np.nan)
    values[::5] = white(0.05, 2)[:1200]
    assert noise_level(values, 0.01).white == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("fastest", [0.5, 1.0, 2.0, 4.0])
def test_motion_is_no_noise(fastest):
    """Sines of random phase up to `fastest` Hz, with as little noise as no sensor has."""
    t, rng = np.arange(0.0, 60.0, 0.01), np.random.default_rng(3)
    sines = [np.sin(2 * np.pi * (f * t + rng.uniform())) for f in np.linspace(0.1, fastest, 12)]
    motion = sum(sines) + 1e-3 * rng.standard_normal(len(t))
    level = noise_level(motion, 0.01)
    assert level.white == level.rough


def test_a_clean_drive_and_one_with_white_noise_have_white_noise(clean, noisy):
    for drive in (clean, noisy):
        for name in STATES:
            level = noise_level(drive[name], drive.dt)
            assert level.white == level.rough


def test_too_few_values_and_a_constant_have_no_noise():
    assert noise_level(np.full(100, np.nan), 0.01).white == 0.0
    assert noise_level(np.zeros(100), 0.01).white == 0.0
    assert noise_level(np.array([1.0, np.nan, 2.0, 1.0]), 0.01).std == 0.0


def test_windows_weigh_a_filtered_channel_as_the_raw_one(clean):
    smoothed = variant("u, v, omega_z smoothed both ways").of(clean)
    raw, found = (sensor_std(d, np.zeros(6))[3:] for d in (add_noise(clean, "table5", 5), smoothed))
    assert np.all(np.abs(found / raw - 1.0) < 0.4)


def test_a_noisy_v_of_a_filter_is_no_v_of_a_wrong_scale(clean):
    """Errors that are not white draw the regression of the accelerometer on the rate of v towards zero."""
    for seed in (1, 2):
        drive = variant("v through a low-pass of 0.05 s").of(add_noise(clean, "good", seed))
        assert checked(drive, VEHICLE)[1] == ()
    with pytest.raises(ValueError, match="sign = -1 for v"):
        checked(drive.with_channels(v=-drive["v"]), VEHICLE)
    with pytest.raises(ValueError, match=r"found a scale of 0\.2.*km/h"):
        checked(drive.with_channels(v=3.6 * drive["v"]), VEHICLE)


def test_a_filtered_yaw_rate_is_warned_of(clean, noisy):
    assert filter_checks(clean) == [] and filter_checks(noisy) == []
    late = variant("omega_z through a low-pass of 0.05 s").of(clean)
    assert re.search(r"found noise that a low-pass of 0\.0[4-7]", " ".join(checked(late, VEHICLE)[1]))


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.parametrize("name", ["v through a low-pass of 0.05 s", "u, v, omega_z smoothed both ways"])
def test_n_is_identified_from_filtered_channels(clean, name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = estimate(variant(name).of(clean), bicycle(VEHICLE, CLAY), 0.7, method="horizon")
    assert found.verdict.word == "identified" and abs(found.n_front[-1] / 0.5 - 1.0) < 0.06


@pytest.mark.study
def test_no_n_is_identified_with_a_filtered_yaw_rate(noisy):
    late = noisy.with_channels(omega_z=low_pass(noisy["omega_z"], noisy.dt, 0.02))
    with pytest.warns(UserWarning, match="log it unfiltered"):
        found = estimate(late, bicycle(VEHICLE, CLAY), 0.7, method="horizon")
    assert found.verdict.word == "inconsistent" and "late and n too low" in found.verdict.reason


def test_no_difference_spans_a_gap():
    """Motion and filtered noise in pieces: the joints of the pieces were taken for noise that grows, or hid a low-pass."""
    dt, kept = 0.012, np.exp(-0.012 / 0.02)
    t = dt * np.arange(5000)
    values = 0.4 * np.sin(2.0 * np.pi * 0.3 * t) + 0.02 * lfilter([1.0 - kept], [1.0, -kept], white(dt, 4))[: len(t)]
    pieces = np.where(t % 2.6 < 1.0, np.nan, values)
    whole, cut = noise_level(values, dt), noise_level(pieces, dt)
    assert whole.late > 0.01 and cut.late == pytest.approx(whole.late, rel=0.2) and cut.std == pytest.approx(whole.std, rel=0.1)
