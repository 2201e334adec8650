"""The driver: its parts, a drive of a small vehicle, and what it does when measurements or plans are missing."""

import numpy as np
import pytest

from nmpc_problem import small_ocp
from softsoil.control.follower import PlanFollower
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.pedals import Pedals


def test_the_estimator_begins_each_drive_anew():
    estimator = LiveEstimator(small_ocp().model, np.full(6, 0.1))
    inputs = {signal.name: signal.nominal for signal in small_ocp().model.external}
    x0 = np.array([0.0, 0.0, 0.0, 5.0, 0.0, 0.0])
    found = []
    for _ in range(2):
        estimator.start(x0, 0.7, True)
        for k in range(50):
            estimator.tick(inputs, x0 + [0.06 * (k + 1), 0.0, 0.0, 0.0, 0.0, 0.0])
        found.append((estimator.filter.x, estimator.n_std))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert found[0][1] == found[1][1]


def test_a_filter_that_broke_down_starts_again_where_it_is_measured():
    estimator = LiveEstimator(small_ocp().model, np.full(6, 0.1))
    inputs = {signal.name: signal.nominal for signal in small_ocp().model.external}
    x0 = np.array([1.0, 2.0, 0.0, 5.0, 0.0, 0.0])
    estimator.start(x0, 0.7, True)
    estimator.filter.x = np.full(7, np.nan)
    for _ in range(4):
        estimator.tick(inputs, x0)
    assert np.isfinite(estimator.filter.x).all() and estimator.n == pytest.approx(0.7, abs=0.05)
    np.testing.assert_allclose(estimator.states[:2], x0[:2], atol=0.5)


def test_without_a_plan_the_vehicle_straightens_and_brakes():
    follower = PlanFollower(0.1)
    follower.take(0.0, np.full(11, 0.2), np.full(11, 5.0), np.zeros(10))
    assert follower.command(0.5, 0.2) == pytest.approx((0.2, 5.0, 0.0))
    steer, _, a_x = follower.command(1.5, 0.2)
    assert 0.0 < steer < 0.2 and a_x < 0
    throttle, brake = Pedals()(-2.0, 0.0, 5.0)
    assert throttle == 0.0 and brake > 0
