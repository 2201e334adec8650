"""A steering map from logs with command and angle: the curve, its error and the delay; logs that cannot give one."""

import numpy as np
import pytest
from scipy.signal import lfilter

from softsoil.commands.import_steering import fitted_map
from softsoil.importing.import_map import map_from_table
from softsoil.importing.sources import Series
from softsoil.importing.steering_fit import RULES, _knots, fit_steering_map

T = np.arange(0.0, 60.0, 0.02)
COMMAND = 0.8 * np.sin(0.9 * T) * np.sin(0.13 * T) + 0.15 * np.sin(2.3 * T)


def curve(command):
    return 0.02 + 0.44 * command - 0.03 * command**2 + 0.05 * command**3


def measured(delay=0.0, noise=0.004, seed=0):
    rng = np.random.default_rng(seed)
    return curve(np.interp(T - delay, T, COMMAND)) + noise * rng.standard_normal(len(T))


def test_the_curve_comes_back_within_its_standard_error_and_the_delay_with_it():
    fit = fit_steering_map(T, COMMAND, measured(delay=0.12))
    inside = np.linspace(COMMAND.min(), COMMAND.max(), 50)
    assert fit.degree >= 2 and fit.delay == pytest.approx(0.12, abs=0.01)
    assert np.abs(fit.map.angle_of(inside) - curve(inside)).max() < max(4 * fit.std, 0.002)
    assert fit.std < 0.003 and fit.residual == pytest.approx(0.004, rel=0.3)


@pytest.mark.parametrize("lag", [0.06, 0.1, 0.2])
def test_a_lag_of_the_wheels_does_not_flatten_the_curve(lag):
    """An actuator of the first order behind a delay: without its lag the curve would be too flat."""
    kept = np.exp(-0.02 / lag)
    reached = lfilter([1.0 - kept], [1.0, -kept], np.interp(T - 0.12, T, COMMAND))
    fit = fit_steering_map(T, COMMAND, curve(reached) + 0.004 * np.random.default_rng(2).standard_normal(len(T)))
    inside = np.linspace(reached.min(), reached.max(), 50)
    assert fit.lag == pytest.approx(lag, abs=0.02) and fit.lag + fit.delay == pytest.approx(0.12 + lag, abs=0.01)
    assert np.abs(fit.map.angle_of(inside) - curve(inside)).max() < max(4 * fit.std, 0.002)


def test_a_map_reaches_as_far_as_the_commands_where_the_wheels_did_not():
    """A lag keeps the wheels from the largest commands: the curve goes straight on to them."""
    kept = np.exp(-0.02 / 0.3)
    reached = lfilter([1.0 - kept], [1.0, -kept], COMMAND)
    fit = fit_steering_map(T, COMMAND, curve(reached) + 0.002 * np.random.default_rng(2).standard_normal(len(T)))
    assert np.abs(reached).max() < 0.95 * np.abs(COMMAND).max()
    assert fit.map.command[0] == pytest.approx(COMMAND.min()) and fit.map.command[-1] == pytest.approx(COMMAND.max())
    assert fit.map.angle_of(COMMAND.max()) == pytest.approx(curve(COMMAND.max()), abs=0.02)


def test_a_pure_delay_has_no_lag():
    assert fit_steering_map(T, COMMAND, measured(delay=0.12)).lag == 0.0


def test_what_no_polynomial_follows_is_in_the_error():
    """A dead band of 0.04 in the command: the curve misses it, and says by how much."""
    angle = 0.4 * np.sign(COMMAND) * np.maximum(np.abs(COMMAND) - 0.04, 0.0)
    fit = fit_steering_map(T, COMMAND, angle + 0.002 * np.random.default_rng(3).standard_normal(len(T)))
    inside = np.linspace(COMMAND.min(), COMMAND.max(), 50)
    missed = fit.map.angle_of(inside) - 0.4 * np.sign(inside) * np.maximum(np.abs(inside) - 0.04, 0.0)
    assert np.sqrt(np.mean(missed**2)) < 2.0 * fit.std


def test_what_the_map_says_is_late_is_no_delay_of_the_steering():
    """An angle 0.3 s late by its clock, whose wheels follow 0.1 s after the command."""
    series = {"/s": Series("/s", T, {"c": COMMAND, "angle": measured(delay=0.4)})}
    entries = {"u": "/s:c", "omega_z": "/s:c", "steer_command": {"source": "/s:c", "unit": ""}}
    plan = map_from_table({"channels": {**entries, "steer": {"source": "/s:angle", "late": 0.3}}}, "map")
    assert fitted_map(plan, series).delay == pytest.approx(0.1, abs=0.01)


def test_a_straight_map_stays_a_straight_line_of_two_knots():
    rng = np.random.default_rng(1)
    fit = fit_steering_map(T, 16.0 * COMMAND, 0.4 * COMMAND + 0.005 * rng.standard_normal(len(T)))
    assert fit.degree == 1 and len(fit.map.command) == 2
    assert fit.map.angle_of(8.0) == pytest.approx(0.2, abs=0.002)


def test_missing_angles_are_passed_over():
    angle = measured()
    angle[::7] = np.nan
    assert fit_steering_map(T, COMMAND, angle).map.angle_of(0.0) == pytest.approx(0.02, abs=0.002)


def test_a_log_that_hardly_steers_and_angles_that_follow_no_command_are_refused():
    with pytest.raises(ValueError, match=r"steer over 0\.05 rad"):
        fit_steering_map(T, 0.01 * COMMAND, 0.01 * measured(noise=0.0))
    with pytest.raises(ValueError, match="angles that follow the command"):
        fit_steering_map(T, COMMAND, 0.3 * np.sin(5.1 * T + 1.0))


@pytest.mark.parametrize("step", [0.01, 0.05, 0.1, 0.2])
def test_delay_and_lag_do_not_depend_on_the_rate_of_the_log(step):
    """Wheels that follow at once with a lag of 0.15 s, recorded fast or slowly."""
    fine = np.arange(0.0, 120.0, 0.002)
    command = 0.8 * np.sin(0.9 * fine) * np.sin(0.13 * fine) + 0.1 * np.sin(2.3 * fine)
    kept = np.exp(-0.002 / 0.15)
    angle = 0.5 * lfilter([1.0 - kept], [1.0, -kept], command)
    every = round(step / 0.002)
    fit = fit_steering_map(fine[::every], command[::every], angle[::every])
    assert fit.lag == pytest.approx(0.15, abs=0.012) and fit.delay == pytest.approx(0.0, abs=0.012)


def test_rounding_makes_no_second_knot():
    scaled = np.array([-1.0 + 2e-16, 0.0, 1.0 - 2e-16])
    knots = _knots(np.array([0.02, 0.5, 0.0]), scaled, RULES)
    assert np.all(np.diff(knots) > 1e-3)
