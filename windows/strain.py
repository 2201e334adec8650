"""The strain of a vehicle's numbers: how far drives move what was identified together, against how far they should.

With numbers theta ~ N(theta_0, C), C^-1 = R'R, and drives of information A on them (all else that is unknown eliminated), the
estimate lies s = R (theta - theta_0) off, whose covariance is J (I + J)^-1 with J = R^-T A R^-1. So s's is expected to be
nu = tr J (I + J)^-1, the number of directions that the drives see, and the strain s's/nu to be 1 for the vehicle that was
identified, however noisy the sensors. A load strains the numbers before it shows in what the model leaves: n takes it up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_SEEN = 1.0
"""Directions below which drives say too little of the numbers to scatter as expected."""


def strain(shift: Array, information: Array, root: Array) -> float:
    """Squares of a shift (K,) of the numbers, in standard deviations of what is known of them, over what is expected.

    information (K, K): of the drives alone on the numbers, in their units; root (K, K): R.
    """
    inverse = np.linalg.pinv(root)
    seen = np.maximum(np.linalg.eigvalsh(inverse.T @ information @ inverse), 0.0)
    return float(shift @ shift) / max(float(np.sum(seen / (1.0 + seen))), LEAST_SEEN)


def last_step(hessian: Array, gradient: Array) -> tuple[float, float]:
    """Step of the last of K numbers, all others free, and its standard error.

    hessian (K, K), gradient (K,): of half the squares, with what is known beforehand.
    """
    unit = np.sqrt(np.maximum(np.diag(hessian), 1e-12))
    inverse = np.linalg.pinv(hessian / np.outer(unit, unit), hermitian=True)[-1] / (unit * unit[-1])
    return -float(inverse @ gradient), float(np.sqrt(max(inverse[-1], 0.0)))


def marginal(information: Array, kept: NDArray[np.int_]) -> Array:
    """Information (K, K) on the numbers `kept` where the others are unknown: the Schur complement in (L, L)."""
    others = np.setdiff1d(np.arange(len(information)), kept)
    own, cross = information[np.ix_(kept, kept)], information[np.ix_(kept, others)]
    return own - cross @ np.linalg.pinv(information[np.ix_(others, others)]) @ cross.T
