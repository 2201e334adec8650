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
