"""Windows with free initial states: derivatives, recovery from noise, standard errors, windows kept off steering steps."""

from dataclasses import replace

import numpy as np
import pytest

from drives import clay_bicycle, clay_drive, reference_vehicle
from softsoil.codegen.sampling import STEP
from softsoil.estimator.promote import tie_parameters
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.noise import TABLE5, add_noise
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SOIL_SIGNALS
from softsoil.windows.free_starts import SEEN
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive
from softsoil.windows.window_fit import Reduced, fit_windows, reduce_windows

SIGMA = np.array([TABLE5[name] for name in ("x", "y", "psi", "u", "v", "omega_z")])
TRUE_N = 0.5


@pytest.fixture(scope="module")
def compiled():
    return WindowModel(tie_parameters(clay_bicycle(), SOIL_SIGNALS["n"], "n_f", "n_r"), clay_drive().dt)


def windows(compiled, recording, horizon=1.0, fastest=np.inf):
    return FreeWindows(compiled, shooting_drive(recording, compiled.model, 1.0), horizon, SIGMA, fastest)


def sinkage_exponent(known=None):
    return Free("n", ("n",), 0.1, 0.2, 1.6, known=known)


def test_residuals_of_the_model_itself_vanish_at_its_own_states(compiled):
    mine = windows(compiled, clay_drive(12.0))
    fit = fit_windows([mine], [], np.zeros(0), compiled.model.p.nominal)
    assert fit.cost < 1e-4


def test_derivatives_agree_with_central_differences(compiled):
    mine = windows(compiled, add_noise(clay_drive(12.0), "table5", 1))
    p, x0, free = compiled.model.p.nominal, mine.first, [sinkage_exponent()]
    linear = mine.linearise(p, x0, free)
    at = compiled.model.p.index("n")
    for step, slope, moves_n in ((1e-5, linear.by_free[..., 0], True), (1e-5, linear.by_state[..., 4], False)):
        moved = []
        for sign in (1, -1):
            q, x = p.copy(), x0.copy()
            if moves_n:
                q[at] += sign * step
            else:
                x[:, 4] += sign * step
            moved.append(mine.residual(q, x))
        assert np.allclose((moved[0] - moved[1]) / (2 * step), slope, rtol=1e-3, atol=1e-3 * np.abs(slope).max())


def test_no_window_runs_across_a_gap(compiled):
    """Two rows at its ends leave a window's initial state open; slow sensors have few rows in every window, and keep them all."""
    clean = add_noise(clay_drive(12.0), "good", 1)
    whole = windows(compiled, clean)
    first, last = whole.rows[3] + 1, whole.rows[3] + whole.steps - 1
    gap = {k: v.copy() for k, v in clean.channels.items()}
    slow = {k: v.copy() for k, v in clean.channels.items()}
    for name in STATE_CHANNELS:
        gap[name][first:last] = np.nan
        slow[name][np.arange(len(clean)) % 16 > 0] = np.nan
    mine = FreeWindows(compiled, shooting_drive(replace(clean, channels=gap), compiled.model, 1.0), 1.0, SIGMA, seen=SEEN)
    assert list(mine.rows) == [row for row in whole.rows if row != whole.rows[3]]
    fit = fit_windows([mine], [sinkage_exponent()], np.array([0.8]), compiled.model.p.nominal)
    assert fit.value[0] == pytest.approx(TRUE_N, abs=0.05)
    few = FreeWindows(compiled, shooting_drive(replace(clean, channels=slow), compiled.model, 1.0), 1.0, SIGMA, seen=SEEN)
    assert list(few.rows) == list(whole.rows)


def test_a_window_whose_state_goes_astray_keeps_no_number_from_moving(compiled, monkeypatch):
    """Where the state of a window is nearly open, as by a gap in it, its linear step may lead anywhere; n moves all the same."""
    mine, states = windows(compiled, add_noise(clay_drive(12.0), "good", 1)), Reduced.states

    def astray(self, step):
        found = states(self, step)
        found[3, STATE_CHANNELS.index("v")] += 8.0
        return found

    monkeypatch.setattr(Reduced, "states", astray)
    fit = fit_windows([mine], [sinkage_exponent()], np.array([0.8]), compiled.model.p.nominal)
    assert fit.value[0] == pytest.approx(TRUE_N, abs=0.05)


@pytest.mark.parametrize("guess", [0.3, 0.8])
def test_n_is_recovered_from_noisy_drives_with_an_honest_standard_error(compiled, guess):
    errors = []
    for seed in range(6):
        mine = windows(compiled, add_noise(clay_drive(20.0), "table5", seed))
        fit = fit_windows([mine], [sinkage_exponent()], np.array([guess]), compiled.model.p.nominal)
        value, std = fit.named()["n"]
        errors.append((value - TRUE_N) / std)
    assert np.sqrt(np.mean(np.square(errors))) < 2.0
    assert abs(np.mean(errors)) < 1.5


def test_what_is_known_counts_as_one_observation(compiled):
    mine = windows(compiled, add_noise(clay_drive(20.0), "table5", 0))
    tight = fit_windows([mine], [sinkage_exponent((0.7, 1e-4))], np.array([0.6]), compiled.model.p.nominal)
    loose = fit_windows([mine], [sinkage_exponent((0.7, 10.0))], np.array([0.6]), compiled.model.p.nominal)
    assert tight.value[0] == pytest.approx(0.7, abs=1e-3)
    assert loose.value[0] == pytest.approx(TRUE_N, abs=0.05)


def test_a_missing_channel_weighs_nothing(compiled):
    drive = add_noise(clay_drive(20.0), "table5", 3)
    mine = windows(compiled, drive.with_channels(x=np.where(drive.t > 5.0, np.nan, drive["x"])))
    fit = fit_windows([mine], [sinkage_exponent()], np.array([0.6]), compiled.model.p.nominal)
    assert fit.value[0] == pytest.approx(TRUE_N, abs=0.05)


def test_a_window_that_the_model_cannot_run_says_nothing(compiled):
    mine = windows(compiled, add_noise(clay_drive(20.0), "table5", 0))
    x0, p, free = mine.first, compiled.model.p.nominal, [sinkage_exponent()]
    x0[3] = np.nan
    linear = mine.linearise(p, x0, free)
    assert list(np.flatnonzero(~np.isfinite(linear.path).all(axis=(1, 2)))) == [3]
    assert not linear.residual[3].any() and not linear.by_state[3].any() and not linear.by_free[3].any()
    reduced = reduce_windows(linear)
    assert np.isfinite(reduced.hessian).all() and np.isfinite(reduced.gradient).all() and reduced.hessian[3].max() == 0.0


def test_no_window_runs_across_a_steering_faster_than_its_actuator(compiled):
    drive = clay_drive(12.0)
    steer = drive["steer"] + 0.1 * (drive.t > 6.0)
    mine = windows(compiled, drive.with_channels(steer=steer), fastest=1.5)
    step = int(np.searchsorted(drive.t, 6.0))
    assert all(row > step or row + mine.steps < step for row in mine.rows)


@pytest.mark.study
def test_between_windows_histories_run_along_the_motion_and_not_along_noise():
    """Steps of the steering leave gaps between windows; what the rear wheels run in there was made by the vehicle's motion."""
    t = STEP * np.arange(round(20.0 / STEP) + 1)
    steer = 0.3 * np.sign(np.sin(2 * np.pi * t / 4.8)) * (1 + 0.3 * np.sin(t))
    model = tie_parameters(bicycle(reference_vehicle(), CLAY), SOIL_SIGNALS["n"], "n_f", "n_r")
    clean = synthetic_drive(model, reference_vehicle().radius, seconds=20.0, steer=steer)
    mine = windows(WindowModel(model, STEP), add_noise(clean, "table5", 2), fastest=1.5)
    between = np.concatenate([np.arange(a + mine.steps, b) for a, b in zip(mine.rows[:-1], mine.rows[1:], strict=True)])
    assert len(between) > 200
    slips = [STATE_CHANNELS.index(name) for name in ("u", "v")]
    true = np.column_stack([clean["u"], clean["v"]])[between]
    recorded = np.std(mine.along(between)[:, slips] - true, axis=0)
    fit_windows([mine], [sinkage_exponent()], np.array([0.6]), model.p.nominal)
    assert np.all(np.std(mine.along(between)[:, slips] - true, axis=0) < 0.3 * recorded)


def test_a_gap_that_the_model_cannot_bridge_stays_as_recorded(compiled):
    drive = clay_drive(12.0)
    steer = drive["steer"] + 0.1 * (drive.t > 6.0)
    mine = windows(compiled, drive.with_channels(steer=steer), fastest=1.5)
    before = mine.along(np.arange(len(mine.drive.t)))
    mine.bridge(np.full_like(compiled.model.p.nominal, np.nan))
    assert np.array_equal(mine.along(np.arange(len(mine.drive.t))), before)


def test_a_bound_holds_and_is_reported(compiled):
    mine = windows(compiled, clay_drive(12.0))
    fit = fit_windows([mine], [Free("n", ("n",), 0.1, 0.6, 1.6)], np.array([0.9]), compiled.model.p.nominal)
    assert fit.value[0] == 0.6 and fit.at_bound == ("n",)


def test_too_short_a_drive_is_refused(compiled):
    with pytest.raises(ValueError, match="expected at least 2 windows of 8 s"):
        windows(compiled, clay_drive(12.0), horizon=8.0)
