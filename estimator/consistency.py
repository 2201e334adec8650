"""Is the filter as sure as it should be: NIS and whiteness of innovations."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtrc, chdtri

Array = NDArray[np.float64]


def inside_band(values: ArrayLike, dof: ArrayLike, level: float = 0.95) -> float:
    """Share of chi-squared `values` (N,) with `dof` (N,) inside their two-sided band of the given level; NaN without any.

    Values with no degree of freedom do not count.
    """
    values, dof = np.asarray(values, dtype=float), np.asarray(dof)
    keep = dof > 0
    if not keep.any():
        return float("nan")
    lower, upper = chdtri(dof[keep], (1 + level) / 2), chdtri(dof[keep], (1 - level) / 2)
    return float(np.mean((values[keep] >= lower) & (values[keep] <= upper)))


def above_band(values: ArrayLike, dof: ArrayLike, level: float = 0.95) -> float:
    """Share of chi-squared `values` (N,) with `dof` (N,) above their two-sided band of the given level; NaN without any."""
    values, dof = np.asarray(values, dtype=float), np.asarray(dof)
    keep = dof > 0
    return float(np.mean(values[keep] > chdtri(dof[keep], (1 - level) / 2))) if keep.any() else float("nan")


def whiteness_p(series: ArrayLike, lags: int = 20) -> float:
    """p-value of the Ljung-Box test that `series` (N,) is white over `lags`; NaN where it is too short or constant."""
    z = np.asarray(series, dtype=float)
    z = z[np.isfinite(z)]
    n = len(z)
    lags = min(lags, n // 4)
    if lags < 1 or np.ptp(z) == 0:
        return float("nan")
    z = z - z.mean()
    power = float(z @ z)
    rho = np.array([z[k:] @ z[:-k] for k in range(1, lags + 1)]) / power
    statistic = n * (n + 2) * np.sum(rho**2 / (n - np.arange(1, lags + 1)))
    return float(chdtrc(lags, statistic))
