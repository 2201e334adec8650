"""Effects of sensors: with its parameter the model says what the sensor says."""

import numpy as np

from drives import reference_vehicle
from softsoil.codegen.predictor import Predictor
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import add_effect
from softsoil.symbolic.soil import CLAY

X0 = np.array([0.0, 0.0, 0.4, 5.0, 0.1, 0.3])
INPUTS = np.tile([0.15, 0.0, 0.3, 15.6, 16.2, 15.6, 16.3], (20, 1))


def rolled(inputs, name=None, **values):
    model = nominal_bicycle(reference_vehicle().with_(effects={}), CLAY)
    if name is not None:
        model = add_effect(model, catalogue(reference_vehicle())[name], values)
    states = Predictor(model, 0.01).rollout(X0, inputs, model.p.nominal)
    return states, np.array([np.ravel(model.measurement()(x, inputs[-1], model.p.nominal)) for x in states])


def test_a_biased_accelerometer_is_its_bias_taken_off():
    biased = INPUTS + np.array([0, 0, 0.5, 0, 0, 0, 0])
    states, _ = rolled(biased, "accelerometer_bias", accelerometer_bias=0.5)
    assert np.allclose(states, rolled(INPUTS)[0], atol=1e-12)
    assert not np.allclose(states, rolled(biased)[0], atol=1e-3)


def test_wheel_speeds_of_a_wrong_scale_are_brought_back():
    scaled = INPUTS * np.array([1, 1, 1, 1.1, 1.1, 1.1, 1.1])
    states, _ = rolled(scaled, "wheel_speed_scale", wheel_speed_scale=1.1)
    assert np.allclose(states, rolled(INPUTS)[0], atol=1e-10)
    assert not np.allclose(states, rolled(scaled)[0], atol=1e-4)


def test_a_turned_unit_measures_another_heading_and_the_same_path():
    states, outputs = rolled(INPUTS, "heading_offset", heading_offset=0.08)
    assert np.allclose(states, rolled(INPUTS)[0], atol=1e-12)
    assert np.allclose(outputs[:, 2] - states[:, 2], 0.08)
    assert np.allclose(outputs[:, [0, 1, 3, 4, 5]], states[:, [0, 1, 3, 4, 5]])
