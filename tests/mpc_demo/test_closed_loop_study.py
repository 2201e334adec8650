"""What knowing n is worth, and how much of it is recovered, told from drives with the same seeds."""

import re
from dataclasses import replace

import numpy as np
import pytest

from softsoil.control.courses import WARM_UP
from softsoil.figures.closed_loop_study import draw_study, recovered_words, recovery_words, rows_of, say_study
from softsoil.mpc_demo.closed_loop_study import LEAST_WORTH, STUDY, Run, paired, pooled_share, worth_of

RUN = Run("lane 6 m/s", "true", 0, 0.2, 0.4, None, 0, 0, 0, 0, True, 0.5, 0.5, [1.0, 1.2])
SEEDS = 10


def runs(guess: float, true: float, found: float, scatter: float = 0.01) -> list[Run]:
    """Three controllers whose tracking shares the seeds' scatter and has a little of its own."""
    rng = np.random.default_rng(1)
    shared, own = scatter * rng.standard_normal(SEEDS), 0.1 * scatter * rng.standard_normal((3, SEEDS))
    return [
        replace(RUN, told=told, seed=seed, tracking_rms=value + shared[seed] + own[i, seed])
        for i, (told, value) in enumerate((("low", guess), ("true", true), ("est_low", found)))
        for seed in range(SEEDS)
    ]


def test_the_share_is_that_of_the_means_and_its_spread_holds_it():
    (_, side, words, means, worth) = rows_of(runs(0.30, 0.20, 0.21))[0]
    assert (side, words) == ("low", "tracking rms") and len(means) == 3
    assert worth.matters and worth.share == pytest.approx(0.9, abs=0.03)
    assert worth.share_low < worth.share < worth.share_high


@pytest.mark.parametrize("guess", (0.20, 0.20 + 0.5 * LEAST_WORTH, 0.15))
def test_where_knowing_is_worth_nothing_no_share_is_given(guess):
    worth = rows_of(runs(guess, 0.20, 0.20))[0][4]
    assert not worth.matters and "does not matter" in recovered_words(worth)


def test_a_difference_within_its_scatter_is_none():
    rng = np.random.default_rng(2)
    true = rng.normal(0.2, 0.1, SEEDS)
    assert not worth_of(true + rng.normal(0.03, 0.1, SEEDS), true, true).matters


def test_clearance_is_better_when_larger():
    mine = [replace(RUN, told=t, seed=s, clearance=c) for t, c in (("low", 0.1), ("true", 0.3)) for s in (1, 0)]
    assert (paired(mine, RUN.case, "low", "need") > paired(mine, RUN.case, "true", "need")).all()


def test_seeds_that_not_all_have_driven_are_left_out():
    some = [run for run in runs(0.3, 0.2, 0.2) if not (run.told == "est_low" and run.seed > 6)]
    assert rows_of(some)[0][4].worth == pytest.approx(0.1, abs=0.01)


def test_unequal_numbers_are_refused():
    with pytest.raises(ValueError, match="the same seeds"):
        worth_of(np.zeros(3), np.zeros(2), np.zeros(3))


def test_a_run_comes_back_from_json():
    assert Run(**RUN.as_json()) == RUN


def test_the_study_is_named_without_doubles_and_covers_both_soils():
    names = [case.name for case in STUDY]
    assert len(set(names)) == len(names)
    for course in ("lane_change", "obstacles", "slalom"):
        for soil in ("clay", "sandy_loam"):
            speeds = [case.speed for case in STUDY if case.course == f"{course}_{soil}"]
            assert speeds and all(4 <= speed <= 8 for speed in speeds)
    low, high = (STUDY[0].scenario(side).n_guess for side in STUDY[0].sides)
    assert low < STUDY[0].scenario("low").n_true(0.0) < high


def test_a_larger_vehicle_has_larger_courses_speeds_and_times():
    case = STUDY[-1].enlarged(1.44)
    assert case.speed == pytest.approx(1.2 * STUDY[-1].speed) and case.scenario("low").speed == case.speed
    assert case.faults.dropout == pytest.approx(tuple(1.2 * t for t in STUDY[-1].faults.dropout))
    assert case.faults.burst == pytest.approx(tuple(1.2 * t for t in STUDY[-1].faults.burst))


def test_the_share_over_courses_comes_with_its_error():
    rng = np.random.default_rng(3)
    worth = rng.uniform(0.01, 0.1, 400)
    guess, true = 0.3 + worth, np.full(400, 0.3)
    share, error = pooled_share(guess, true, guess - 0.9 * worth + 0.01 * rng.standard_normal(400))
    assert error == pytest.approx(0.01 / (np.sqrt(400) * worth.mean()), rel=0.1)
    assert abs(share - 0.9) < 4 * error
    with pytest.raises(ValueError, match="positive worth"):
        pooled_share(true, guess, true)
    said = re.search(r": (\S+) % \(standard error (\S+)\)", recovery_words(runs(0.30, 0.20, 0.21)))
    assert abs(float(said.group(1)) - 90.0) < 4 * float(said.group(2)) + 0.1
    assert "no course" in recovery_words(runs(0.2, 0.2, 0.2))


def test_both_guesses_on_one_course_are_one_course_and_its_drives_count_once():
    low = runs(0.30, 0.20, 0.21)
    sides = {"low": "high", "est_low": "est_high"}
    both = low + [replace(run, told=sides[run.told]) for run in low if run.told in sides]
    told = r"in (\d+) comparisons on (\d+) courses .* error (\S+)\)"
    one, two = (re.search(told, recovery_words(some)) for some in (low, both))
    assert (one[1], one[2], two[1], two[2]) == ("1", "1", "2", "1")
    assert one[3] == two[3], "the other guess has the same drives with the true n, and here all the others' too"


def test_report_and_figure_are_made(tmp_path, capsys):
    say_study(runs(0.3, 0.2, 0.21))
    assert "recovered" in capsys.readouterr().out
    assert draw_study(runs(0.3, 0.2, 0.21), tmp_path / "a.png").stat().st_size > 1e4


def test_a_longer_weave_moves_manoeuvre_and_faults():
    """Three times the weave: the course begins as before, its judged part and its faults come so much later."""
    case = next(case for case in STUDY if case.faults.dropout)
    later = case.enlarged(1.5).after(3 * WARM_UP)
    course, longer = case.enlarged(1.5).scenario("low"), later.scenario("low")
    assert longer.warm_up == course.warm_up + 3.0 * WARM_UP
    np.testing.assert_allclose(longer.path.points[:100], course.path.points[:100])
    np.testing.assert_allclose(longer.path.points[-20:] - course.path.points[-20:], [[3.0 * WARM_UP, 0.0]] * 20, atol=1e-9)
    wait = 3.0 * WARM_UP / later.speed
    np.testing.assert_allclose(later.faults.dropout, np.array(case.enlarged(1.5).faults.dropout) + wait)
