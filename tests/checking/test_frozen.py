"""Sensors that stop: a value that stays while the motion says that it cannot have."""

import numpy as np
import pytest

from drives import MULTI_LOG
from softsoil.checking.single import single_checks
from softsoil.recording.evidence import Motion
from softsoil.recording.read import read_drive


@pytest.fixture(scope="module")
def log():
    return read_drive(MULTI_LOG).between(0.0, 20.0)


def frozen(recording):
    return {check.channel: check.beyond_doubt for check in single_checks(Motion.of(recording)) if check.name.startswith("frozen")}


def held(values, t, start, end):
    out = values.copy()
    inside = (t >= start) & (t < end)
    out[inside] = out[int(np.argmax(inside))]
    return out


@pytest.mark.parametrize("name", ["steer", "omega_z", "v", "omega_fl", "a_y_imu"])
def test_a_sensor_that_stops_in_a_slalom_is_said(name, log):
    assert frozen(log) == {}
    stops = log.with_channels(**{name: held(log[name], log.t, log.t[0] + 6.0, log.t[0] + 11.0)})
    assert frozen(stops) == {name: False}
    for_good = log.with_channels(**{name: held(log[name], log.t, log.t[0] + 4.0, log.t[-1] + 1.0)})
    assert frozen(for_good) == {name: True}


@pytest.mark.parametrize("step", [0.1, 1.0 / 3.6])
def test_a_speed_in_coarse_steps_is_not_frozen_and_one_that_stops_is(step, log):
    """A vehicle at its cruise, its speed in steps of 0.1 m/s or 1 km/h; and a sensor that stops there."""
    t = log.t - log.t[0]
    u = 5.6 + 0.05 * np.sin(0.8 * t) + 0.6 * (t < 3.0) * (1.0 - t / 3.0)
    x = np.cumsum(u) * log.dt
    cruise = log.with_channels(x=x, y=0.0 * x, psi=0.0 * x, v=0.0 * x, u=np.round(u / step) * step)
    assert "u" not in frozen(cruise)
    assert frozen(cruise.with_channels(u=held(u, log.t, log.t[0] + 4.0, log.t[-1] + 1.0)))["u"]


def test_what_a_drive_needs_is_not_to_be_left_out(log):
    stops = log.with_channels(omega_z=held(log["omega_z"], log.t, log.t[0] + 4.0, log.t[-1] + 1.0))
    (check,) = [c for c in single_checks(Motion.of(stops)) if c.name == "frozen_omega_z"]
    assert check.cure.startswith("another source of omega_z")


@pytest.mark.parametrize("seconds", (2.02, 2.5))
def test_a_steering_angle_that_is_held_between_steps_is_not_frozen(log, seconds):
    """A simulator's angle is exactly the same for seconds, and a gyro's noise is no turning."""
    t = log.t - log.t[0]
    steps = 0.2 * (np.floor(t / seconds) % 3 - 1.0)
    behind = np.zeros_like(steps)
    for i in range(1, len(t)):
        behind[i] = behind[i - 1] + (t[i] - t[i - 1]) / 0.15 * (3.0 * steps[i] - behind[i - 1])
    noise = 0.04 * np.random.default_rng(2).standard_normal(len(t))
    assert frozen(log.with_channels(steer=steps, omega_z=behind + noise)) == {}


def test_a_steering_that_is_held_while_the_speed_changes_is_not_frozen(log):
    """A curve driven faster and slower: yaw rate and curvature change with it, at one angle."""
    t = log.t - log.t[0]
    u = 6.0 + 3.5 * np.sin(0.6 * t)
    curve = log.with_channels(u=u, steer=np.full(len(t), 0.2), omega_z=0.08 * u / (1.0 + 0.02 * u**2))
    assert frozen(curve) == {}
