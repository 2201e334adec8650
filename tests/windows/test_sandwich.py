"""The sandwich: the ordinary covariance where residuals are white, the scatter of estimates where they are not."""

import numpy as np
import pytest

from softsoil.windows.sandwich import cluster_covariance, jackknife_covariance

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


def test_few_clusters_of_which_one_says_most_are_as_uncertain_as_they_are():
    """Eight clusters that share a disturbance, one of them steep: the fit takes away its residuals, and with them the error."""
    rng, slopes = np.random.default_rng(5), np.array([0.2, -0.3, 0.1, 0.3, -0.1, 0.2, -0.2, 2.0])
    values, sandwich, jackknife = [], [], []
    for _ in range(400):
        design = np.repeat(slopes, 5)[:, None]
        y = 2.0 * design[:, 0] + rng.standard_normal(40) + np.repeat(rng.standard_normal(8), 5)
        hessian = design.T @ design
        value = np.linalg.solve(hessian, design.T @ y)
        scores = (design * (y - design @ value)[:, None]).reshape(8, 5, 1).sum(axis=1)
        each = 5.0 * slopes[:, None, None] ** 2
        values.append(value[0])
        sandwich.append(cluster_covariance(hessian, scores)[0, 0] ** 0.5)
        jackknife.append(jackknife_covariance(hessian, scores, each)[0, 0] ** 0.5)
    scatter = np.std(values)
    assert np.median(sandwich) < 0.5 * scatter < 0.8 * scatter < np.median(jackknife)


def test_with_many_clusters_leaving_one_out_changes_nothing():
    rng = np.random.default_rng(6)
    design = rng.standard_normal((400, 10, 2))
    noise = rng.standard_normal((400, 10))
    scores, each = np.einsum("cmk,cm->ck", design, noise), np.einsum("cmk,cml->ckl", design, design)
    hessian = each.sum(axis=0)
    assert jackknife_covariance(hessian, scores, each) == pytest.approx(cluster_covariance(hessian, scores), rel=0.05, abs=1e-6)


def test_what_one_cluster_alone_determines_is_not_known_without_it():
    each = np.zeros((4, 2, 2))
    each[:, 0, 0], each[0, 1, 1] = 1.0, 5.0
    scores = np.array([[0.1, 0.2], [-0.1, 0.0], [0.2, 0.0], [-0.2, 0.0]])
    covariance = jackknife_covariance(each.sum(axis=0), scores, each)
    assert covariance[1, 1] > 1e6 and covariance[0, 0] < 1.0
