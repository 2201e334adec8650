"""A change of soil that only the whole drive shows: found where it is, and only there."""

import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.estimator.estimate import _with_trial, estimate
from softsoil.estimator.late_change import later_soil, parts_of
from softsoil.estimator.modes import run_horizon
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.summary import Summary
from softsoil.estimator.terrain import estimate_terrain
from softsoil.estimator.verdict import Verdict
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Speed
from softsoil.plant.simulate import simulate
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SOILS
from softsoil.symbolic.vehicle import load_vehicle

SOIL = np.array([True])
SHARE = 0.5


def quadratics(n: np.ndarray, curvature: float = 400.0, scatter: float = 0.02, seed: int = 1) -> Summary:
    """Windows whose own minima are n (W,) and a scatter, all linearised at 0.5."""
    rng = np.random.default_rng(seed)
    own = n + scatter * rng.standard_normal(len(n))
    return Summary(
        at=[np.array([0.5])] * len(n), hessian=[np.array([[curvature]])] * len(n),
        gradient=[np.array([curvature * (0.5 - value)]) for value in own], states=[np.zeros(6)] * len(n), cost=[1.0] * len(n),
    )  # fmt: skip


@pytest.mark.parametrize("border", [12, 25, 40])
def test_the_border_is_where_two_values_fit_best(border):
    summary = quadratics(np.where(np.arange(60) < border, 0.6, 0.5))
    found = later_soil(summary, 0, SHARE, SOIL, 2)
    assert found is not None
    since, n = found
    assert abs(since - border - 2) <= 2 and n[0] == pytest.approx(0.5, abs=0.015)


@pytest.mark.parametrize("seed", range(10))
def test_one_soil_has_no_border(seed):
    assert later_soil(quadratics(np.full(60, 0.6), seed=seed), 0, SHARE, SOIL, 2) is None


def test_a_small_difference_is_none_however_sure():
    summary = quadratics(np.where(np.arange(60) < 30, 0.60, 0.56), curvature=4000.0)
    assert parts_of(summary, 0, SHARE, 59)[1] > 2.5
    assert later_soil(summary, 0, SHARE, SOIL, 2) is None


def test_what_no_soil_has_moved_is_no_soil():
    summary = quadratics(np.where(np.arange(60) < 30, 0.6, 0.5))
    assert later_soil(summary, 0, SHARE, ~SOIL, 2) is None


def test_windows_before_the_present_soil_and_too_few_ones_do_not_count():
    summary = quadratics(np.where(np.arange(60) < 30, 0.6, 0.5))
    assert later_soil(summary, 34, SHARE, SOIL, 2) is None
    assert later_soil(quadratics(np.array([0.6] * 4 + [0.5] * 4)), 0, SHARE, SOIL, 2) is None


@pytest.fixture(scope="module")
def two_soils():
    """A drive of the plant from n of 0.8 to 0.65 after 60 m, with the paper's noise."""
    soil = SOILS["sandy_loam"].with_(n=0.8)
    ground = SoilField.change_at(soil, soil.with_(n=0.65), 60.0)
    manoeuvre = Manoeuvre("border", MultiSine(seed=77), Speed(5.5, 1.2, 11.0))
    return add_noise(simulate(manoeuvre, ground, 30.0, seed=77, start=Start(u=5.0)), "table5", 3)


@pytest.mark.study
def test_the_last_soil_of_a_drive_is_estimated_from_its_own_windows(two_soils):
    model = bicycle(load_vehicle(PLANT_VEHICLE), SOILS["sandy_loam"].with_(n=0.8))
    rules = HorizonRules()
    windows = drive_windows(two_soils, model, 1.0, rules)
    horizon = run_horizon(windows, 0.9, True, rules)
    crossed = two_soils.t[np.argmax(two_soils["x"] > 60.0)]
    assert len(horizon.changes) == 1 and abs(two_soils.t[horizon.changes[0]] - crossed) < 3.0
    assert horizon.n[0] == pytest.approx(0.65, rel=0.06)
    found = estimate(two_soils, model, 0.9, method="horizon")
    assert found.verdict.word == "identified", found.verdict.reason
    assert f"changes at {found.changes[0]:.1f} s: n is that of what follows" in found.verdict.reason
    assert found.n_front[-1] == pytest.approx(0.65, rel=0.06)


def test_a_jump_that_the_log_ends_too_soon_to_bear_out_is_said():
    """Of a gyro that reads a fifth too much in the last second and a half: the filter's n is open there, not to be used."""
    log = add_noise(read_drive(MULTI_LOG).between(0.0, 22.0), "good", 1)
    late = log.with_channels(omega_z=np.where(log.t > log.t[-1] - 1.5, 1.2 * log["omega_z"], log["omega_z"]))
    model = bicycle(reference_vehicle(), CLAY)
    found, right = (estimate_terrain(drive, model, 0.6, tied=True, start=2.0) for drive in (late, log))
    assert right.on_trial is None and found.on_trial is not None
    t, before = found.on_trial
    assert t == found.changes[-1] and before == pytest.approx(0.5, rel=0.05) and found.n_front[-1] > 0.6
    said = _with_trial(Verdict("inconsistent", "the estimator ends elsewhere"), found.on_trial)
    assert f"n jumps at {t:.1f} s from {before:.2f}, and the log ends too soon to bear that out" in said.reason
    kept = Verdict("identified", "all is well")
    assert _with_trial(kept, found.on_trial) is kept and _with_trial(said, None) is said
