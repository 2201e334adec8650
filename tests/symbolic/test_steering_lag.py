"""A steering lag follows lines exactly, and below zero is an angle that is recorded late."""

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.symbolic.catalogue import catalogue

EFFECT = catalogue(reference_vehicle())["steering_lag"]


def wheels(steer, rate, lag, dt):
    """(K,) angle of the road wheels along steer (K,) with its rate (K,)."""
    (memory,) = EFFECT.memories
    angles, cells = [], None
    for angle, speed in zip(steer, rate, strict=True):
        q = {"steer": float(angle), "steer_rate": float(speed), "steering_lag": lag, "dt": dt}
        cells = memory.start(q) if cells is None else cells
        angles.append(float(angle) + float(memory.read({**q, "memory": cells})["lagged_angle"]))
        cells = memory.advance({**q, "memory": cells})
    return np.array(angles)


@pytest.mark.parametrize("dt", (0.002, 0.012, 0.05))
@pytest.mark.parametrize("lag", (0.004, 0.03, 0.2))
def test_it_is_the_first_order_lag_of_a_line(lag, dt):
    t = dt * np.arange(40)
    later = np.maximum(t - 10 * dt, 0.0)
    found = wheels(0.2 * later, np.where(t > 10 * dt, 0.2, 0.0), lag, dt)
    np.testing.assert_allclose(found, 0.2 * (later - lag + lag * np.exp(-later / lag)), atol=2e-5)


@pytest.mark.parametrize("lag", (-0.04, -0.004, 0.0, 0.004))
def test_it_goes_on_below_zero(lag):
    """A sine that is recorded late is where the wheels are; a lag shorter than the rows is a delay."""
    t = 0.012 * np.arange(400)
    now, rate = 0.3 * np.sin(2.0 * t), 0.6 * np.cos(2.0 * t)
    assert np.abs(wheels(now, rate, lag, 0.012) - 0.3 * np.sin(2.0 * (t - lag))).max() < 0.003 * (lag != 0.0) + 1e-12


def test_nearby_lags_are_nearby_angles():
    """No step and no kink at zero, where a fit starts."""
    t = 0.012 * np.arange(100)
    by_lag = [wheels(0.3 * np.sin(2.0 * t), 0.6 * np.cos(2.0 * t), lag, 0.012) for lag in (-1e-3, 0.0, 1e-3)]
    forward, back = by_lag[2] - by_lag[1], by_lag[1] - by_lag[0]
    np.testing.assert_allclose(forward, back, atol=1e-3 * np.abs(back).max())
    assert np.abs(back).max() == pytest.approx(0.6e-3, rel=0.01)
