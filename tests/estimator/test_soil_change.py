"""The test for another soil: the likelihood ratio against a textbook's, and the filter on drives with a change and without."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from drives import clay_bicycle, clay_drive
from softsoil.estimator.estimate import run_method
from softsoil.estimator.soil_change import CHANGE_CLIP, CHANGE_SAMPLES, CHANGE_YOUNGEST, SoilChange, evidence
from softsoil.estimator.tuning import Tuning
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine
from softsoil.plant.simulate import simulate
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle

STEP = 0.024
OLD, NEW, BORDER = 0.5, 0.75, 75.0


def sums(jump: float, at: float, seconds: float = 20.0, seed: int = 0, tuning: Tuning | None = None) -> tuple[float, float]:
    """Time and size of the first jump said of white innovations whose mean becomes 0.1 `jump` at a time; NaN: none."""
    rng, change = np.random.default_rng(seed), SoilChange(tuning or Tuning(), 1)
    share, variance = np.array([[0.1]]), np.array([1e-4])
    for k in range(round(seconds / STEP)):
        t = k * STEP
        innovation = 0.01 * rng.normal(size=1) + 0.1 * jump * (t >= at)
        found = change.see(t, *evidence(innovation, variance, share))
        if found[0]:
            return t, float(found[0])
    return np.nan, np.nan


NOTHING = np.zeros(1), np.zeros(1)


def heard(change: SoilChange, score: float, information: float, at: float = 0.0) -> float:
    """Jump that is said once the sums which a score and an information at a time belong to are old enough to decide."""
    every = Tuning().change_after / CHANGE_SAMPLES
    assert change.see(at, np.array([score]), np.array([information]))[0] == 0.0
    for k in range(1, CHANGE_YOUNGEST):
        assert change.see(at + k * every, *NOTHING)[0] == 0.0
    return float(change.see(at + CHANGE_YOUNGEST * every, *NOTHING)[0])


def test_the_statistic_is_the_likelihood_ratio_of_a_jump():
    """T^2 = 2 log of the ratio of D's densities with a jump and without, plus the log of the variances' ratio."""
    tuning = Tuning()
    d, e, m, estimate = tuning.change_std, tuning.change_error, 900.0, 0.13
    v = 1 / m + e**2
    ratio = norm.logpdf(estimate, scale=np.sqrt(v + d**2)) - norm.logpdf(estimate, scale=np.sqrt(v))
    statistic = np.sqrt(2 * ratio + np.log((v + d**2) / v))
    for limit, said in ((0.999 * statistic, True), (1.001 * statistic, False)):
        change = SoilChange(replace(tuning, change_sigmas=limit), 1)
        found = heard(change, estimate * m, m)
        assert bool(found) is said
        if said:
            assert found == pytest.approx(estimate * d**2 / (d**2 + v), rel=1e-12)


@pytest.mark.parametrize("jump", [0.2, -0.2])
def test_a_jump_is_said_soon_and_measured(jump):
    for seed in range(5):
        t, size = sums(jump, 10.0, seed=seed)
        assert 10.0 <= t < 12.0
        assert size == pytest.approx(jump, rel=0.5)


def test_white_innovations_are_no_jump():
    assert all(np.isnan(sums(0.0, 0.0, 60.0, seed)[0]) for seed in range(5))


def test_what_is_forgotten_begins_anew():
    change = SoilChange(Tuning(), 1)
    strong = 2000.0, 1e4
    assert heard(change, *strong) > 0.1
    change.forget(2.0)
    assert change.see(1.9, np.array([strong[0]]), np.array([strong[1]]))[0] == 0.0
    assert heard(change, *strong, at=2.0) > 0.1


def test_old_evidence_leaves_the_window():
    """A jump in the evidence of more than `change_after` ago says nothing of the last seconds."""
    tuning = Tuning()
    change = SoilChange(tuning, 1)
    weak = np.array([0.9 * tuning.change_sigmas * np.sqrt(50.0)]), np.array([50.0])
    assert change.see(0.0, *weak)[0] == 0.0
    for k in range(1, CHANGE_SAMPLES + 2):
        change.see(k * tuning.change_after / CHANGE_SAMPLES, *NOTHING)
    assert heard(change, float(weak[0][0]), float(weak[1][0]), tuning.change_after + 1.0) == 0.0


def test_an_outlier_counts_as_a_rare_innovation_at_most():
    share, variance = np.array([[0.1, 0.2]]), np.array([1e-4, 4e-4])
    score, information = evidence(np.array([1.0, 0.0]), variance, share)
    assert score[0] == pytest.approx(0.1 * CHANGE_CLIP * 0.01 / 1e-4)
    assert information[0] == pytest.approx(0.1**2 / 1e-4 + 0.2**2 / 4e-4)


@pytest.fixture(scope="module")
def crossing() -> Recording:
    """A drive of the plant that comes from n = OLD to NEW at x = BORDER."""
    ground = SoilField.change_at(CLAY.with_(n=OLD), CLAY.with_(n=NEW), BORDER)
    return simulate(Manoeuvre("crossing", MultiSine(seed=3)), ground, 24.0, seed=3, start=Start(u=5.0))


@pytest.mark.parametrize("seed", [0, 1])
def test_the_filter_follows_a_new_soil_within_three_seconds(crossing, seed):
    model, noisy = bicycle(load_vehicle(PLANT_VEHICLE), CLAY), add_noise(crossing, "good", seed)
    border = float(crossing.t[np.argmax(crossing["x"] > BORDER)])
    found = run_method(noisy, model, 0.6, "ukf", start=1.0)
    assert border < found.changes[0] < border + 3.0
    soon = (found.t > border) & (found.t < border + 3.0)
    assert (np.abs(found.n_front - NEW) < 0.1 * NEW)[soon].any()
    blind = run_method(noisy, model, 0.6, "ukf", start=1.0, tuning=replace(Tuning(), change_sigmas=np.inf))
    assert blind.changes == ()
    assert not (np.abs(blind.n_front - NEW) < 0.1 * NEW)[soon].any()


@pytest.mark.parametrize("noise", ["good", "table5"])
def test_a_clean_drive_has_no_change(noise):
    found = run_method(add_noise(clay_drive(25.0), noise, 4), clay_bicycle(), 0.6, "ukf", start=1.0)
    assert found.changes == ()
