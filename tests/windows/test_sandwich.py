"""The sandwich: the ordinary covariance where residuals are white, the scatter of estimates where they are not."""

import numpy as np
import pytest

from softsoil.windows.sandwich import cluster_covariance

TRUE = np.array([2.0, -1.0])


def estimated(rng, clusters: int, size: int, shared: float):
    """Least-squares estimate, sandwich and ordinary standard errors on data whose clusters share a disturbance and a slope."""
    slope = np.repeat(rng.standard_normal(clusters), size)
    design = np.column_stack([np.ones(clusters * size), slope])
    noise = rng.standard_normal(clusters * size) + shared * np.repeat(rng.standard_normal(clusters), size)
    y = design @ TRUE + noise
    hessian = design.T @ design
    value = np.linalg.solve(hessian, design.T @ y)
    left = y - design @ value
    scores = (design * left[:, None]).reshape(clusters, size, 2).sum(axis=1)
    ordinary = np.sqrt(np.diag(np.linalg.inv(hessian)) * left.var())
    return value, np.sqrt(np.diag(cluster_covariance(hessian, scores))), ordinary


@pytest.mark.parametrize("shared", [0.0, 1.0])
def test_standard_errors_are_the_scatter_of_the_estimates(shared):
    rng = np.random.default_rng(3)
    values, stds, ordinary = map(np.array, zip(*[estimated(rng, 60, 8, shared) for _ in range(300)], strict=True))
    scatter = values.std(axis=0)
    assert np.allclose(stds.mean(axis=0), scatter, rtol=0.12)
    assert (np.allclose(ordinary.mean(axis=0), scatter, rtol=0.12)) == (shared == 0.0)


def test_what_is_known_from_elsewhere_counts_once():
    known = np.array([[4.0]])
    assert cluster_covariance(known, np.zeros((5, 1)), known) == pytest.approx(np.array([[0.25]]))
