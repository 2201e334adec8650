"""Innovations inside and above their band."""

import numpy as np
import pytest
from scipy.stats import chi2

from softsoil.estimator.consistency import above_band, inside_band


def test_of_right_innovations_a_fortieth_lies_above_and_as_many_below():
    values, dof = chi2(4).ppf(np.linspace(0.0005, 0.9995, 1000)), np.full(1000, 4)
    assert inside_band(values, dof) == pytest.approx(0.95, abs=0.002)
    assert above_band(values, dof) == pytest.approx(0.025, abs=0.002)


def test_of_a_filter_that_expects_too_much_noise_most_lie_below():
    values, dof = 0.05 * np.ones(10), np.full(10, 4)
    assert (inside_band(values, dof), above_band(values, dof)) == (0.0, 0.0)
    assert above_band([1.0, 50.0], [0, 2]) == 1.0 and np.isnan(above_band([1.0], [0]))
