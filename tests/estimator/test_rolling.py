"""A vehicle that crawls or reverses: its place follows its wheels, its soil is held."""

import numpy as np
import pytest

from c_folders import declared
from softsoil.codegen.sampling import STEP
from softsoil.control.c_estimator import c_parts
from softsoil.estimator.rolling import Rolling
from softsoil.estimator.terrain_filter import TerrainFilter
from softsoil.estimator.tuning import Tuning

MODEL = c_parts(declared("plain")).model
STATES = MODEL.x.names[:6]


def inputs(steer: float, speed: float, a_x: float = 0.0):
    wheels = {f"omega_{wheel}": speed / MODEL.geometry.radius for wheel in ("fl", "fr", "rl", "rr")}
    return MODEL.external.pack(steer=steer, a_x=a_x, **wheels)


@pytest.mark.parametrize("speed", [0.3, -0.8])
def test_without_positions_a_slow_circle_is_followed(speed):
    """A circle of the rear axle about the point where both axles' normals meet, radius L / tan(steer)."""
    vehicle, steer, tuning = MODEL.geometry, 0.3, Tuning()
    length = vehicle.l_f + vehicle.l_r
    curvature = np.tan(steer) / length
    own = TerrainFilter(MODEL, STEP, tuning.sensor_floor)
    turn, v = speed * curvature, speed * curvature * vehicle.l_r
    own.start(MODEL.x.pack(u=speed, v=v, omega_z=turn, n_f=0.6, n_r=0.7), tuning.std0(MODEL.x, tuning.sensor_floor))
    rng, before = np.random.default_rng(0), own.n
    for k in range(1000):
        own.predict(inputs(steer, speed))
        if k % 2:
            seen = np.array([np.nan, np.nan, np.nan, speed, np.nan, np.nan])
            own.update(seen + 0.05 * rng.normal(size=6))
            assert own.status.standing
    psi = turn * 1000 * STEP
    rear = np.array([-length + np.sin(psi) / curvature, (1.0 - np.cos(psi)) / curvature])
    front = rear + length * np.array([np.cos(psi), np.sin(psi)])
    away = own.ukf.x[:2] - front
    assert np.abs(away).max() < 0.15 and np.abs(away).max() < 3.0 * np.sqrt(own.ukf.variance[:2].max())
    np.testing.assert_array_equal(own.n, before)


def test_derivatives_are_those_of_the_step():
    rolling = Rolling(MODEL, 0.1)
    x = MODEL.x.pack(x=1.0, y=-2.0, psi=0.7, u=0.4, v=0.05, omega_z=0.1, n_f=0.5, n_r=0.6)
    for turning in (True, False):
        after, share = rolling.step(x, inputs(0.2, 0.4, 0.3), STEP, turning)
        for i in range(len(x)):
            moved = x.copy()
            moved[i] += 1e-6
            found = (rolling.step(moved, inputs(0.2, 0.4, 0.3), STEP, turning)[0] - after) / 1e-6
            np.testing.assert_allclose(found, share[:, i], atol=1e-6)


def test_where_the_wheels_stand_the_place_is_held():
    x = MODEL.x.pack(x=1.0, y=-2.0, psi=0.7, u=0.4, v=0.05, omega_z=0.1)
    after, _ = Rolling(MODEL, 0.1).step(x, inputs(0.2, 0.0), STEP, False)
    np.testing.assert_array_equal(after[:3], x[:3])
    assert np.all(np.abs(after[3:6]) < np.abs(x[3:6]))


def test_one_outlier_of_the_speed_is_no_reversing():
    """The estimate goes on at its own speed; a second and a third are believed."""
    tuning = Tuning()
    own = TerrainFilter(MODEL, STEP, tuning.sensor_floor)
    own.start(MODEL.x.pack(u=6.0, n_f=0.5, n_r=0.5), tuning.std0(MODEL.x, tuning.sensor_floor))
    wrong = np.array([np.nan, np.nan, np.nan, -9.0, np.nan, np.nan])
    own.predict(inputs(0.0, 6.0))
    own.update(wrong)
    assert own.status.standing and own.ukf["u"] > 5.5
    for _ in range(tuning.patience_rates):
        own.predict(inputs(0.0, 6.0))
        own.update(wrong)
    assert own.ukf["u"] < -5.0
