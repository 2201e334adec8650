"""Standard errors of identified numbers, what an error of each costs n, and which given ones the logs contradict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.files.joint_error import JointError, joint_error_of
from softsoil.windows.window_fit import WindowFit

Array = NDArray[np.float64]

BLOCKS_PER_DRIVE = 6
"""Stretches of a drive that are left out in turn."""
LEAST_INFORMATION = 0.05
"""Share of a number's precision that the logs have at least brought, for them to say anything of it."""


@dataclass(frozen=True)
class Errors:
    """covariance (K, K) of a fit's numbers; white (K,): their variances where residuals are white; prior (K,): precision of what
    is known of each beforehand; alone (K,): share of its standard error that a number keeps with all others as they are."""

    names: tuple[str, ...]
    value: Array
    covariance: Array
    white: Array
    prior: Array
    alone: Array

    @property
    def std(self) -> dict[str, float]:
        """Name -> standard error."""
        return dict(zip(self.names, map(float, np.sqrt(np.maximum(np.diag(self.covariance), 0.0))), strict=True))

    def correlation(self, one: str, other: str) -> float:
        """Correlation of two numbers' errors."""
        i, k = self.names.index(one), self.names.index(other)
        return float(self.covariance[i, k] / max(np.sqrt(self.covariance[i, i] * self.covariance[k, k]), 1e-300))


def errors_of(fit: WindowFit) -> Errors:
    """Standard errors by stretches of the drives left out in turn (jackknife, one Gauss-Newton step each), or those of white
    residuals where they are larger."""
    prior = np.array([0.0 if f.known is None else f.known[1] ** -2 for f in fit.free])
    scale = np.array([f.scale for f in fit.free])
    hessian = fit.hessians.sum(axis=0) + np.diag(prior)
    inverse = _inverse(hessian, scale)
    shifts = []
    blocks = _blocks(fit)
    for block in np.unique(blocks):
        inside = blocks == block
        rest = hessian - fit.hessians[inside].sum(axis=0)
        shifts.append(_inverse(rest, scale) @ fit.scores[inside].sum(axis=0))
    moved = np.array(shifts)
    count = len(moved)
    jackknife = (count - 1) / count * (moved - moved.mean(axis=0)).T @ (moved - moved.mean(axis=0))
    # The jackknife moves the logs only; what a number owes to its prior is as uncertain as that.
    jackknife = jackknife + inverse @ np.diag(prior) @ inverse
    ratio = np.sqrt(np.maximum(np.diag(inverse) / np.maximum(np.diag(jackknife), 1e-300), 1.0))
    alone = 1.0 / np.sqrt(np.maximum(np.diag(hessian) * np.diag(inverse), 1.0))
    covariance = jackknife * np.outer(ratio, ratio)
    return Errors(tuple(f.name for f in fit.free), fit.value, covariance, np.diag(inverse), prior, alone)


def joint_error(errors: Errors, names: Sequence[str], model_error: float) -> JointError:
    """Joint error of the numbers `names`, each drive's n unknown.

    errors: of a fit with all of them free; model_error: standard errors of the logs that are taken as one standard deviation,
    since what the force law misses moves numbers, too; what is known beforehand is taken as it is.
    """
    chosen = [errors.names.index(name) for name in names]
    prior = errors.prior[chosen]
    scale = np.sqrt(np.diag(errors.covariance)[chosen])
    both = np.linalg.pinv(errors.covariance[np.ix_(chosen, chosen)] / np.outer(scale, scale), rcond=1e-10, hermitian=True)
    known = np.diag(prior * scale**2)
    size, axes = np.linalg.eigh(both - known)
    logs = (axes * np.maximum(size, 0.0)) @ axes.T
    covariance = np.linalg.inv(logs / model_error**2 + known)
    return joint_error_of(tuple(names), covariance * np.outer(scale, scale))


def _blocks(fit: WindowFit) -> NDArray[np.int_]:
    drive, t = fit.places[:, 0].astype(int), fit.places[:, 1]
    block = np.zeros(len(t), dtype=int)
    for d in np.unique(drive):
        mine = drive == d
        first, last = t[mine].min(), t[mine].max()
        share = (t[mine] - first) / max(last - first, 1e-9)
        block[mine] = d * BLOCKS_PER_DRIVE + np.minimum((share * BLOCKS_PER_DRIVE).astype(int), BLOCKS_PER_DRIVE - 1)
    return block


def _inverse(hessian: Array, scale: Array) -> Array:
    scaled = hessian * np.outer(scale, scale)
    return np.linalg.pinv(scaled, rcond=1e-12, hermitian=True) * np.outer(scale, scale)


def n_costs(fit: WindowFit, stds: Mapping[str, float]) -> dict[str, float]:
    """Number -> change of n (%) that an error of one standard deviation of it makes with all others as they are: the largest over
    the drives, dn = -H_nk/H_nn std_k.

    fit: with every number free; stds: standard deviation of each.
    """
    names = [f.name for f in fit.free]
    hessian = fit.hessians.sum(axis=0)
    drives = [i for i, f in enumerate(fit.free) if f.drive is not None]
    costs = {}
    for name, std in stds.items():
        if name not in names:
            continue
        k = names.index(name)
        shares = [-hessian[i, k] / max(hessian[i, i], 1e-300) * std / fit.value[i] for i in drives]
        costs[name] = 100.0 * float(max(shares, key=abs)) if shares else 0.0
    return costs


def departures(fit: WindowFit, errors: Errors, bent: Mapping[str, float]) -> dict[str, tuple[float, float, float]]:
    """Given number -> (value, standard error) that the logs alone say, all else known as it is, and by how many standard
    deviations, of the logs and of measuring together, it departs from what is given.

    bent: number -> share of it by which the force law's own errors move it, part of its standard error. The equations are those
    of a posterior N(m, V) with the prior N(g, 1/w) taken out: precision 1/V - w, mean (m/V - g w) over it.
    """
    table = {}
    variance = np.diag(errors.covariance)
    for k, free in enumerate(fit.free):
        if free.known is None:
            continue
        given, std = free.known
        precision = 1.0 / max(errors.white[k], 1e-300)
        left = precision - errors.prior[k]
        if left <= LEAST_INFORMATION * precision:
            continue
        alone = (fit.value[k] * precision - given * errors.prior[k]) / left
        own = np.hypot(np.sqrt(max(variance[k] * precision, 1.0) / left), bent.get(free.name, 0.0) * given)
        table[free.name] = (float(alone), float(own), float(abs(alone - given) / np.hypot(own, std)))
    return table
