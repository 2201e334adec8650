"""The strain of numbers: 1 where the drives scatter as expected, whatever they see, and more where the numbers have moved."""

import numpy as np
import pytest

from softsoil.windows.strain import LEAST_SEEN, last_step, marginal, strain


def numbers(seed, size=6):
    """Covariance of what is known of numbers, and information of drives on them, both far from diagonal."""
    rng = np.random.default_rng(seed)
    known, seen = rng.standard_normal((size, size)), rng.standard_normal((size, size))
    return rng, known @ known.T + 0.1 * np.eye(size), 3.0 * seen @ seen.T


@pytest.mark.parametrize("noisier", [1.0, 3.0])
def test_numbers_of_the_vehicle_itself_are_strained_by_one_on_average(noisier):
    rng, covariance, information = numbers(3)
    information = information / noisier**2
    root = np.linalg.cholesky(np.linalg.inv(covariance)).T
    found = []
    for _ in range(4000):
        true = rng.multivariate_normal(np.zeros(len(root)), covariance)
        measured = information @ true + np.linalg.cholesky(information) @ rng.standard_normal(len(root))
        found.append(strain(root @ np.linalg.solve(information + root.T @ root, measured), information, root))
    assert np.mean(found) == pytest.approx(1.0, abs=0.05)
    assert np.quantile(found, 0.99) < 3.5


def test_a_number_that_has_moved_strains():
    _, covariance, information = numbers(4)
    root = np.linalg.cholesky(np.linalg.inv(covariance)).T
    moved = np.array([0.0, 8.0 * np.sqrt(covariance[1, 1]), 0.0, 0.0, 0.0, 0.0])
    shift = root @ np.linalg.solve(information + root.T @ root, information @ moved)
    assert strain(shift, information, root) > 3.5


def test_drives_that_see_next_to_nothing_count_as_one_direction():
    shift, root = np.array([0.5, 0.0]), np.eye(2)
    assert strain(shift, 1e-6 * np.eye(2), root) == pytest.approx(0.25 / LEAST_SEEN)


def test_what_is_unknown_besides_takes_its_information_away():
    _, _, information = numbers(5)
    kept = np.array([1, 4])
    assert np.linalg.inv(marginal(information, kept)) == pytest.approx(np.linalg.inv(information)[np.ix_(kept, kept)])
    nothing = np.zeros((3, 3))
    nothing[0, 0] = 2.0
    assert marginal(nothing, np.array([0])) == pytest.approx(np.array([[2.0]])), "others that nothing is known of"


def test_the_last_number_is_that_of_least_squares_in_any_units():
    rng = np.random.default_rng(3)
    slope, wanted = rng.normal(size=(40, 3)), rng.normal(size=40)
    best, covariance = np.linalg.lstsq(slope, wanted, rcond=None)[0], np.linalg.inv(slope.T @ slope)
    for unit in (1.0, 1e-4, 1e6):
        scaled = slope * [1.0, 1.0, unit]
        step, std = last_step(scaled.T @ scaled, -scaled.T @ wanted)
        assert step * unit == pytest.approx(best[-1]) and std * unit == pytest.approx(np.sqrt(covariance[-1, -1]))
