"""Prediction windows and the residual: zero for the true model, and what was left out for another."""

from dataclasses import replace

import numpy as np
import pytest

from drives import clay_bicycle, clay_drive, reference_vehicle
from softsoil.codegen.predictor import Predictor
from softsoil.estimator.horizons import HORIZONS, Replay, predict
from softsoil.estimator.moving_horizon import estimate_horizon
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.derive import mark
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.noise import add_noise
from softsoil.refinement.residual import drive_residual, split_by_axle, unjudged
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.soil import CLAY

EXACT = 1e-7
"""Rounding, and the slope of five samples in the place of the steering rate."""


@pytest.fixture(scope="module")
def replay():
    return Replay(clay_drive(), clay_bicycle())


def test_windows_fill_the_log_and_say_what_they_leave_out(replay):
    for horizon in HORIZONS:
        windows = replay.windows(clay_bicycle().p.nominal, horizon)
        steps = windows.predicted.shape[1] - 1
        assert steps == round(horizon / replay.dt)
        assert replay.t[windows.rows[0]] == pytest.approx(2.0, abs=0.012)
        assert np.all(np.diff(windows.rows) == steps)
        assert windows.rows[-1] + steps + windows.left_out == len(replay.t) - 1
        assert 0 <= windows.left_out < steps
        assert np.array_equal(windows.predicted[:, 0], windows.recorded[:, 0])


def test_true_model_predicts_and_wrong_n_does_not(replay):
    model = clay_bicycle()
    right = replay.mse(model.p.nominal)
    wrong = replay.mse(model.p.pack(n_f=0.7, n_r=0.7))
    for horizon in ("0.5", "2.5", "5.0"):
        assert right[horizon]["v"] < 1e-3 * wrong[horizon]["v"]
        assert right[horizon]["u"] == pytest.approx(0.0, abs=EXACT)
    assert wrong["5.0"]["y"] > wrong["0.5"]["y"]


def test_error_of_heading_is_taken_on_the_circle(replay):
    windows = replay.windows(clay_bicycle().p.nominal, 0.5)
    turned = replace(windows, predicted=windows.predicted + 2 * np.pi * np.eye(6)[STATE_CHANNELS.index("psi")])
    assert np.allclose(turned.error, windows.error, atol=1e-9)


def test_missing_states_start_no_window_and_do_not_count():
    drive = clay_drive()
    v = drive["v"].copy()
    v[600:700] = np.nan
    model = clay_bicycle()
    whole = Replay(drive, model).windows(model.p.nominal, 0.5)
    holed = Replay(drive.with_channels(v=v), model).windows(model.p.nominal, 0.5)
    assert 0 < len(whole.rows) - len(holed.rows) <= 4
    assert not set(holed.rows) & set(range(600, 700))
    assert np.isfinite(list(holed.mse.values())).all()


def test_a_prediction_without_a_finite_value_is_no_good_one(replay):
    found = replay.windows(clay_bicycle().p.nominal, 0.5)
    found.predicted[0, 5:, 4] = np.nan
    assert found.mse["v"] == np.inf and np.isfinite(found.mse["u"])


@pytest.mark.parametrize("n", [float("nan"), 5.0, (0.5, -1.0)])
def test_no_n_that_no_soil_has_predicts(n):
    with pytest.raises(ValueError, match=r"n: expected a sinkage exponent in \[0\.2, 1\.6\], found"):
        predict(clay_drive(), clay_bicycle(), n)


def test_states_of_the_horizon_are_those_at_its_times():
    log = clay_drive()
    found = estimate_horizon(log, clay_bicycle(), 0.6, tied=True, start=2.0)
    at = np.searchsorted(log.t, found.t - 1e-6)
    assert np.abs(found.states[:, 0] - log["x"][at]).max() < 0.05 and np.abs(found.states[:, 3] - log["u"][at]).max() < 0.05


def test_horizon_shorter_than_a_step_is_named(replay):
    with pytest.raises(ValueError, match="expected at least one step"):
        replay.windows(clay_bicycle().p.nominal, 0.001)


def test_shapes_of_a_rollout():
    model = clay_bicycle()
    predictor = Predictor(model, 0.012)
    states = predictor.rollout(model.x.nominal, np.tile([0.1, 0, 0, 15, 15, 15, 15], (10, 1)), model.p.nominal)
    assert states.shape == (11, 6)
    with pytest.raises(ValueError, match=r"u_future: expected shape \(N, 7\)"):
        predictor.rollout(model.x.nominal, np.zeros(7), model.p.nominal)


def test_residual_of_the_true_model_is_nothing():
    found = drive_residual(clay_drive(), clay_bicycle(), reference_vehicle())
    assert found.axles["front"]["rms"] < 20 and found.axles["rear"]["rms"] < 20  # N, of several kN
    assert found.channels["v"]["rms"] < 0.01


def test_missing_yaw_moment_shows_on_both_axles_with_opposite_signs():
    """A constant moment that the model does not have: dF_f = -dF_r = M_z/L, whatever the noise."""
    moment, vehicle = 300.0, reference_vehicle()
    true = nominal_bicycle(vehicle, CLAY).correct("balance", lambda q: {"moment_z": q["moment_z"] + moment})
    drive = synthetic_drive(true, vehicle.radius, steer=0.1 * np.sin(np.arange(2751) * 0.012))
    for noise in ("none", "good"):
        found = drive_residual(add_noise(drive, noise, 1), clay_bicycle(), vehicle)
        assert np.median(found.force_f) == pytest.approx(moment / vehicle.wheelbase, rel=0.1)
        assert np.median(found.force_r) == pytest.approx(-moment / vehicle.wheelbase, rel=0.1)


def test_split_by_axle_puts_force_and_moment_back():
    vehicle = reference_vehicle()
    front, rear = split_by_axle(np.array([0.3]), np.array([-0.2]), vehicle)
    assert front + rear == pytest.approx(vehicle.mass * 0.3)
    assert front * vehicle.l_f - rear * vehicle.l_r == pytest.approx(vehicle.yaw_inertia * -0.2)


def test_log_too_short_for_a_window_is_named():
    with pytest.raises(ValueError, match=r"expected more than 2.5 s"):
        drive_residual(clay_drive(2.0), clay_bicycle(), reference_vehicle())


@pytest.mark.parametrize("first", (0.0, 0.3))
def test_windows_begin_at_fixes_of_a_slow_receiver(first):
    """x and y once a second: windows side by side that met no fix were left out, all of them."""
    drive = clay_drive()
    seen = np.abs((drive.t - first + 0.5) % 1.0 - 0.5) < 0.5 * drive.dt
    slow = drive.with_channels(**{name: np.where(seen, drive[name], np.nan) for name in ("x", "y")})
    windows = Replay(slow, clay_bicycle()).windows(clay_bicycle().p.nominal, 2.5)
    assert len(windows.rows) > 7 and np.isfinite(list(windows.mse.values())).all()
    assert np.isfinite(windows.recorded[:, 0]).all() and windows.mse["y"] < 1e-4
    assert np.isfinite(drive_residual(slow, clay_bicycle(), reference_vehicle()).rate_v).any()


def test_windows_begin_where_slow_sensors_do_not_meet():
    """x and y once a second, u and v twice, of another phase: no row has them all."""
    drive = clay_drive()

    def at(hertz, first):
        return np.abs((drive.t - first + 0.5 / hertz) % (1.0 / hertz) - 0.5 / hertz) < 0.5 * drive.dt

    seen = {"x": at(1.0, 0.3), "y": at(1.0, 0.3), "u": at(2.0, 0.13), "v": at(2.0, 0.13)}
    slow = drive.with_channels(**{name: np.where(there, drive[name], np.nan) for name, there in seen.items()})
    windows = Replay(slow, clay_bicycle()).windows(clay_bicycle().p.nominal, 2.5)
    assert len(windows.rows) > 7 and windows.mse["omega_z"] < 1e-3


def test_it_is_said_why_axle_forces_are_not_judged():
    drive = clay_drive()
    slow = drive.with_channels(v=np.where(np.arange(len(drive)) % 17 == 0, drive["v"], np.nan))
    assert unjudged(slow) == "v is measured at 4.9 Hz, fewer than 4 times in 0.5 s"
    assert unjudged(mark(drive, "derived", "v", "omega_z")) == "v and omega_z are not measured"
