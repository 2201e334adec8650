"""The second look at a jump of n: the likelihood ratio against a textbook's, and what counts again."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from softsoil.estimator.soil_trial import DETERMINED, SoilTrial
from softsoil.estimator.tuning import Tuning

JUMP, ERROR = Tuning().change_std, Tuning().change_error
OLD, KNOWN, SEEN = 0.6, 0.02, 0.04
"""n before the jump, and its standard deviation; standard deviation by the seconds after it."""


def trial(jumped=(True, False), walk: float = 0.0) -> SoilTrial:
    own = SoilTrial(Tuning(), np.full(2, walk))
    own.begin(10.0, np.full(2, OLD), np.full(2, KNOWN**2), np.array(jumped))
    return own


def judged(own: SoilTrial, away: float, std: float = SEEN, t: float = 12.0) -> np.ndarray:
    return own.judge(t, np.full(2, OLD + away), np.full(2, std**2))


def test_a_jump_is_revoked_where_none_is_likelier():
    v = KNOWN**2 + SEEN**2 + ERROR**2
    ratio = lambda away: norm.logpdf(away, scale=np.sqrt(v + JUMP**2)) - norm.logpdf(away, scale=np.sqrt(v))  # noqa: E731
    away = np.linspace(0.0, 0.3, 301)
    limit = float(away[np.argmax(ratio(away) > 0)])
    assert 0.05 < limit < 0.15
    for side in (1, -1):
        own = trial()
        np.testing.assert_array_equal(judged(own, side * (limit - 2e-3)), [KNOWN**2, 0.0])
        assert own.over and not own.stands
        own = trial()
        np.testing.assert_array_equal(judged(own, side * (limit + 2e-3)), 0.0)
        assert own.over and own.stands


def test_the_trial_waits_until_n_is_determined():
    own = trial()
    assert not judged(own, 0.0, 1.01 * DETERMINED * JUMP).any() and not own.over
    assert judged(own, 0.0, 0.99 * DETERMINED * JUMP).any() and own.over
    assert not judged(own, 0.0).any()


def test_what_was_known_has_walked_since():
    assert judged(trial(walk=1e-5), 0.0, t=15.0)[0] == pytest.approx(KNOWN**2 + 5e-5)


def test_each_n_has_its_own_trial():
    own = trial((True, True))
    found = own.judge(12.0, OLD + np.array([0.0, 0.3]), np.full(2, SEEN**2))
    assert found[0] > 0 and found[1] == 0 and own.over and own.stands


def test_a_new_jump_ends_the_trial_of_the_last():
    own = trial()
    own.begin(16.0, np.full(2, 0.8), np.full(2, KNOWN**2), np.array([False, True]))
    assert own.t == 16.0
    np.testing.assert_array_equal(own.judge(18.0, np.full(2, 0.8), np.full(2, SEEN**2)) > 0, [False, True])


def test_nothing_is_on_trial_at_first_or_where_jumps_are_not_told():
    assert SoilTrial(Tuning(), np.zeros(1)).over
    own = SoilTrial(replace(Tuning(), change_std=0.0), np.zeros(1))
    own.begin(0.0, np.array([OLD]), np.array([KNOWN**2]), np.array([True]))
    assert not own.judge(1.0, np.array([OLD]), np.array([0.01])).any()
