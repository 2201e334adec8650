"""Time offsets where records are joined: a few jumps neither make an offset nor hide one."""

from dataclasses import replace

import numpy as np
import pytest

import softsoil
from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.clocks import clock_checks
from softsoil.checking.offsets import Offset, best_offset, time_offsets
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Sine, Speed
from softsoil.plant.sensors import Sensors
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY

NAMES = ("u", "v", "omega_z", "steer", "a_x_imu", "a_y_imu")


def joined(drive, times=4, late=0.0):
    """The drive several times over on one clock, its speed u `late` seconds late."""
    channels = {name: np.tile(drive[name], times) for name in NAMES}
    channels["t"] = np.arange(times * len(drive)) * drive.dt
    channels["u"] = np.interp(channels["t"] - late, channels["t"], channels["u"])
    return replace(drive, channels=channels, truth={})


@pytest.mark.parametrize("noise", [None, "good"])
@pytest.mark.parametrize("late", [0.0, 0.3])
def test_records_joined_in_one_show_the_offset_that_is_there(late, noise):
    drive = read_drive(MULTI_LOG)
    found = time_offsets(joined(drive if noise is None else add_noise(drive, noise, 1), late=late), reference_vehicle())
    assert {offset.group: offset.late_s for offset in found}["u"] == pytest.approx(late, abs=0.03)


def test_outliers_of_a_speed_make_no_offset():
    drive = read_drive(MULTI_LOG)
    u = drive["u"].copy()
    u[::400] += 3.0
    found = {offset.group: offset for offset in time_offsets(drive.with_channels(u=u), reference_vehicle())}
    assert found["u"].late_s == pytest.approx(0.0, abs=0.03) and found["u"].before > 0.99


def test_a_manoeuvre_that_repeats_itself_is_not_shifted_by_a_period():
    """A period away less of a gust lies inside what is compared: that leaves a little less, but not clearly less."""
    dt, period = 0.02, 1.5
    t = dt * np.arange(601)
    wave = np.sin(2 * np.pi * t / period)
    gust = np.random.default_rng(2).normal(size=len(t)) * np.where((t > 2.0) & (t < 2.0 + period), 0.65, 0.5)
    found = best_offset("position", "heading", wave + gust, np.zeros_like(t), [wave], dt)
    assert found is not None and found.late_s == pytest.approx(0.0, abs=0.03)
    late = best_offset("position", "heading", np.roll(wave + gust, round(0.2 / dt)), np.zeros_like(t), [wave], dt)
    assert late is not None and late.late_s == pytest.approx(0.2, abs=0.03)


def test_the_noise_of_a_short_piece_shifts_it_by_no_period():
    """Over 10 s correlated noise may leave a third less a period away; an offset that is there is found all the same."""
    dt, period = 0.02, 1.5
    t = dt * np.arange(501)
    wave = np.sin(2 * np.pi * t / period)
    for seed in range(20):
        noise = np.convolve(np.random.default_rng(seed).normal(size=len(t)), np.full(15, 15**-0.5), "same")
        for late in (0.0, 0.2):
            there = np.roll(wave + 0.3 * noise, round(late / dt))
            found = best_offset("position", "heading", there, np.zeros_like(t), [wave], dt)
            assert found is not None and found.late_s == pytest.approx(late, abs=0.1), seed


def test_an_outlier_that_a_shift_leaves_out_explains_nothing():
    """A course turned by noise of a position, at the edge of what is compared: without it less is left, but nothing explained."""
    dt = 0.02
    t = dt * np.arange(501)
    rng = np.random.default_rng(4)
    course, turning = 0.05 * rng.normal(size=len(t)), np.sin(2 * np.pi * t / 1.5)
    assert best_offset("position", "heading", course, np.zeros_like(t), [turning], dt) is None
    course[round(3.0 / dt)] = 60.0
    assert best_offset("position", "heading", course, np.zeros_like(t), [turning], dt) is None


@pytest.mark.parametrize("period", [3.0, 4.0])
def test_a_steady_slalom_has_no_late_wheels_by_half_a_period(period):
    """The wheels' difference is slip as well: on clay with n = 0.8 it fits turned over, 0.67 or 1.5 s later."""
    angle, speed = (0.3, 5.5) if period == 4.0 else (0.2, 4.0)
    driver = Manoeuvre("slalom", Sine(angle, period), Speed(speed))
    soil = softsoil.load_soil("clay").with_(n=0.8)
    drive = softsoil.simulate(driver, soil, 30.0, sensors=Sensors("good"), seed=3)
    checks = {check.name: check for check in clock_checks(drive, softsoil.load_vehicle("plant"))}
    assert "clock_wheels" not in checks or checks["clock_wheels"].passed


def test_noise_of_both_sides_makes_an_offset_no_surer():
    """A slow motion under noise whose slope is many times its own: as far off as the standard error says, not farther."""
    dt, rng, errors = 0.02, np.random.default_rng(4), []
    t = dt * np.arange(1200)
    wave = np.sin(0.9 * t) + 0.5 * np.sin(0.37 * t + 1.0)
    for _ in range(40):
        channel, feature = (wave + np.convolve(0.8 * rng.standard_normal(len(t)), np.ones(7) / 7, mode="same") for _ in range(2))
        found = best_offset("u", "accelerometer", channel, np.zeros_like(t), [feature], dt)
        if found is not None:
            errors.append(found.late_s / found.std)
    assert len(errors) > 30 and np.std(errors) < 1.3


def test_a_slope_of_the_ground_refuses_no_log():
    """Gravity along the way looks like a clock of the speed, and leaves nearly as much with it as without."""
    bank = bicycle(reference_vehicle(), CLAY, effects={"bank": {"bank": 0.04}})
    steer = MultiSine(0.35, seed=4)(0.012 * np.arange(round(26.0 / 0.012) + 1))
    drive = synthetic_drive(bank, reference_vehicle().radius, seconds=26.0, speed=5.5, steer=steer)
    for seed in range(6):
        assert not [c for c in clock_checks(add_noise(drive, "good", seed), reference_vehicle()) if c.beyond_doubt]


@pytest.mark.parametrize(
    ("before", "after", "passes"), ((0.819, 0.823, True), (0.819, 0.95, False), (0.990, 0.9925, False))
)
def test_positions_are_late_only_where_a_shift_takes_something_away(monkeypatch, before, after, passes):
    """On circles the slip angle is told from a clock by next to nothing: shifts of 0.2 s of either sign fit a little better."""
    offset = Offset("position", "heading", -0.18, 0.04, before, after)
    monkeypatch.setattr("softsoil.checking.clocks.time_offsets", lambda *_: (offset,))
    (check,) = clock_checks(read_drive(MULTI_LOG), reference_vehicle())
    assert check.passed == passes


def test_positions_that_begin_after_the_heading_ended_are_compared_with_nothing():
    drive = read_drive(MULTI_LOG).between(0.0, 20.0)
    rows = np.arange(len(drive)) / len(drive)
    channels = {"psi": np.where(rows < 0.5, drive["psi"], np.nan)}
    channels |= {name: np.where(rows > 0.5, drive[name], np.nan) for name in ("x", "y")}
    found = time_offsets(drive.with_channels(**channels), reference_vehicle())
    assert "position" not in {offset.group for offset in found}
