"""Covariance of estimates whose residuals are correlated inside clusters: the sandwich estimator."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def cluster_covariance(hessian: ArrayLike, scores: ArrayLike, known: ArrayLike = 0.0, rcond: float = 1e-10) -> Array:
    """(K, K) covariance H^-1 S H^-1 of least-squares estimates, independent between clusters only (Liang, Zeger 1986, eq. 8).

    hessian (K, K): sum of J'J; scores (C, K): J'r of each cluster, S their scatter times C/(C - K); known (K, K): information
    from elsewhere, inside the hessian already, that scatters as it is assumed to; rcond: eigenvalues of the hessian below this
    share of its largest say nothing.
    """
    hessian, scores = np.asarray(hessian, dtype=float), np.asarray(scores, dtype=float)
    inverse = np.linalg.pinv(hessian, rcond=rcond)
    count, size = scores.shape
    scatter = scores.T @ scores * count / max(count - size, 1) + np.asarray(known, dtype=float)
    return inverse @ scatter @ inverse


def jackknife_covariance(hessian: ArrayLike, scores: ArrayLike, hessians: ArrayLike, known: ArrayLike = 0.0) -> Array:
    """(K, K) covariance of the same by leaving out a cluster at a time: few clusters, or one that says most, whose residuals the
    fit has taken away (estimator CV3 of MacKinnon, Nielsen, Webb, J. Econometrics 232, 2023, after Bell, McCaffrey 2002).

    hessian (K, K), scores (C, K), known (K, K): as of `cluster_covariance`; hessians (C, K, K): of each cluster, J'J.
    """
    hessian, scores, hessians = (np.asarray(part, dtype=float) for part in (hessian, scores, hessians))
    rest = hessian - hessians
    size, axes = np.linalg.eigh(0.5 * (rest + rest.transpose(0, 2, 1)))
    # What one cluster alone determines is not known without it: very uncertain, and no division by 0.
    size = np.maximum(size, 1e-9 * np.abs(np.linalg.eigvalsh(hessian)[-1]))
    moved = np.einsum("cij,cj,ckj,ck->ci", axes, 1.0 / size, axes, scores)
    inverse, count = np.linalg.pinv(hessian), len(scores)
    elsewhere = np.asarray(known, dtype=float) + np.zeros_like(hessian)
    return (count - 1) / count * moved.T @ moved + inverse @ elsewhere @ inverse
