"""Modes of the horizon: the one that fits clearly worse is left out, whoever came first, and what does not separate stays."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.verdicts_fresh import draw
from drives import clay_bicycle, clay_drive
from softsoil.estimator.estimate import estimate
from softsoil.estimator.modes import Run, run_horizon, standing, worse
from softsoil.estimator.moving_horizon import HorizonRules, MovingHorizon, drive_windows, exponents
from softsoil.recording.noise import add_noise
from softsoil.symbolic.catalogue import bicycle

TRUE_N = 0.5
COST = 0.6 + 0.1 * np.random.default_rng(1).standard_normal(40)


def run(guess: float, n: float, cost: np.ndarray, since: int = 0) -> Run:
    """A run that ended at n with these costs of its windows."""
    return Run(guess, SimpleNamespace(since=since, share=0.5, n=np.array([n])), cost)  # type: ignore[arg-type]


def ends(runs: list[Run]) -> list[float]:
    """Initial guesses of runs."""
    return [one.guess for one in runs]


@pytest.mark.parametrize("first", [0, 1, 2])
def test_a_mode_that_fits_clearly_worse_is_left_out_wherever_it_stands(first):
    rng = np.random.default_rng(2)
    runs = [run(0.4, 0.5, COST), run(0.7, 0.51, COST + 0.001), run(1.1, 1.6, COST + 0.2 + 0.05 * rng.standard_normal(40))]
    stand, left_out = standing(runs[first:] + runs[:first])
    assert set(ends(stand)) == {0.4, 0.7} and ends(left_out) == [1.1]
    assert left_out[0].worse == pytest.approx(0.2 / 0.6, rel=0.2)
    assert stand[0].guess == (0.4 if first != 1 else 0.7), "the user's guess where it stands, else the one that fits best"


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (0.01 * np.ones(40), "a difference of 1.7 % may be any small fault of the model, however sure it is"),
        (np.r_[0.3 * np.ones(5), np.zeros(35)] * 0.6, "one of 4 % that few windows make"),
        (np.r_[8.0, np.zeros(39)], "one window decides nothing"),
        (0.2 * np.random.default_rng(3).standard_normal(40), "noise"),
    ],
)
def test_what_does_not_separate_stays(more, why):
    stand, left_out = standing([run(0.4, 0.9, COST + more), run(1.1, 0.5, COST)])
    assert ends(stand) == [0.4, 1.1] and not left_out, why


def test_many_windows_that_each_say_little_separate_modes():
    """Minutes of road: 3 % on the average, in most windows."""
    more = 0.02 + 0.03 * np.random.default_rng(5).standard_normal(300)
    cost = np.full(300, 0.6)
    stand, left_out = standing([run(0.4, 0.6, cost), run(1.1, 1.5, cost + more)])
    assert ends(stand) == [0.4] and ends(left_out) == [1.1]
    stand, left_out = standing([run(0.4, 0.6, cost[:20]), run(1.1, 1.5, (cost + more)[:20])])
    assert ends(stand) == [0.4, 1.1] and not left_out


def test_only_windows_of_the_present_soil_are_compared():
    """A run that has followed a change of soil fits the windows before it badly."""
    stand, _ = standing([run(0.4, 0.5, COST), run(1.1, 0.9, COST + np.r_[np.full(20, 5.0), np.zeros(20)], since=20)])
    assert ends(stand) == [0.4, 1.1]


def test_overlapping_windows_are_half_as_many():
    more = 0.1 + 0.1 * np.random.default_rng(4).standard_normal(40)
    share, sigmas = worse(COST + more, COST, 0.5)
    assert share == pytest.approx(more.mean() / COST.mean())
    assert sigmas == pytest.approx(worse(COST + more, COST, 1.0)[1] / np.sqrt(2.0))


def test_a_run_ends_where_all_its_windows_are_linearised():
    """Windows that no update has come back to lie where they were linearised; at the end of the drive all lie at the estimate."""
    rules = HorizonRules(again=0.0)
    windows = drive_windows(add_noise(clay_drive(25.0), "table5", 4), clay_bicycle(), 1.0, rules)
    before = MovingHorizon(windows, exponents(True), 1.1, rules)
    for k in range(len(windows.rows)):
        before.update(k)
    settled = run_horizon(windows, 1.1, True, rules)
    far = [float(np.max(np.abs(np.array(one.summary.at) - one.n))) for one in (before, settled)]
    assert far[0] > 0.1 and far[1] < 0.02
    near = run_horizon(windows, 0.55, True, rules)
    assert settled.n[0] == pytest.approx(near.n[0], abs=0.002)


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.parametrize("method", ["ukf", "horizon"])
def test_a_guess_that_leads_into_a_second_mode_does_not_win_because_it_is_the_users(method):
    """The drive of the plant on which n = 1.1 ends near 1.6 with windows that cost 39 % more."""
    case = draw("nominal", np.random.default_rng([10, 70]), 10070)
    found = estimate(case.drive, bicycle(case.vehicle, case.soil), 1.1, method=method)
    assert found.n_front[-1] == pytest.approx(case.n, rel=0.1)
    assert found.verdict is not None and found.verdict.word == "identified", found.verdict
    ends = re.search(r"1\.10 ends at ([\d.]+),", found.verdict.reason)
    assert ends and float(ends[1]) > 1.45, found.verdict.reason
