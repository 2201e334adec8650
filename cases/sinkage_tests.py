"""Sinkage exponent and modulus from penetration tests, with standard errors over the tests.

A circular plate gives sigma = k h^n, one n and k per test (least squares of log sigma over log h); n is their mean. A wheel
that does not roll is in contact on both sides of its lowest point: F = b k int [sqrt(r^2 - X^2) - (r - h)]^n dX, with n of the
plates; k is the mean of those tests, and stands for a body as wide as this wheel. Bearing pressure in dry sand grows with
the width of the body (k ~ width^m, m near 1: weight and friction carry, not cohesion), so that plates of other sizes have
another k: they check the wheel's by the plate whose area is that of the footprint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.cases.cmu_data import SinkageTest

Array = NDArray[np.float64]

DEPTHS = (0.003, 0.03)
"""m: from where the plate lies evenly to where the shallowest test of a small plate ends, in even steps of log h."""
WHEEL_DEPTHS = (0.005, 0.04)
STEPS = 24
LEAST_TESTS = 3


@dataclass(frozen=True)
class Bearing:
    """n, k_wheel (N/m^(n+2)) with standard errors over tests; scatter_n: standard deviation of n from test to test;
    width_exponent m and its error; k_plates: modulus that the plates give for the footprint of the wheel at `load` (the
    check); tests: plates and wheels used.
    """

    n: float
    n_std: float
    scatter_n: float
    k_wheel: float
    k_wheel_std: float
    width_exponent: float
    width_exponent_std: float
    k_plates: float
    tests: tuple[int, int]


def fit_bearing(tests: Sequence[SinkageTest], radius: float, width: float, load: float, body: str) -> Bearing:
    """Bearing parameters of the wheel called `body` (radius, width, m) at a load (N), from plates and from itself.

    Raises ValueError where there are fewer than three tests of either kind.
    """
    plates, wheels = [t for t in tests if t.body == "plate"], [t for t in tests if t.body == body]
    for kind, found in (("plate", plates), (body, wheels)):
        if len(found) < LEAST_TESTS:
            raise ValueError(f"sinkage tests: expected {LEAST_TESTS} or more of {kind}, found {len(found)}")
    lines = np.array([_power_law(*_sampled(t, DEPTHS), area=np.pi / 4 * t.diameter**2) for t in plates])
    n, scatter = float(lines[:, 0].mean()), float(lines[:, 0].std(ddof=1))
    k_wheel, k_wheel_std = _mean([_wheel_modulus(t, n, radius, width) for t in wheels])
    # The pressure of each plate in the middle of the depths, against its width.
    middle = np.sqrt(DEPTHS[0] * DEPTHS[1])
    log_sigma, log_d = lines[:, 1] + lines[:, 0] * np.log(middle), np.log([t.diameter for t in plates])
    design = np.column_stack([np.ones(len(plates)), log_d])
    (level, m), left = _least_squares(design, log_sigma)
    footprint = 2 * np.sqrt(width * _chord(load, k_wheel, n, radius, width) / np.pi)
    k_plates = float(np.exp(level + m * np.log(footprint)) / middle**n)
    m_std = float(left / np.sqrt(np.sum((log_d - log_d.mean()) ** 2)))
    counts = (len(plates), len(wheels))
    return Bearing(n, scatter / np.sqrt(len(plates)), scatter, k_wheel, k_wheel_std, float(m), m_std, k_plates, counts)


def standing_force(h: Array, k: float, n: float, radius: float, width: float) -> Array:
    """(N,) force (N) that carries a wheel which does not roll at sinkages h (m); modulus k (N/m^(n+2)), radius, width (m)."""
    unit, weight = np.polynomial.legendre.leggauss(32)
    h = np.asarray(h, dtype=float)[:, None]
    reach = np.sqrt(np.minimum(h, radius) * (2 * radius - np.minimum(h, radius)))
    x = reach * unit
    depth = np.maximum(np.sqrt(radius**2 - x**2) - (radius - h), 0.0)
    return width * k * (depth**n * weight * reach).sum(axis=1)


def _sampled(test: SinkageTest, depths: tuple[float, float]) -> tuple[Array, Array]:
    """Sinkages evenly spaced in their logarithm, and forces there (N)."""
    deepest = np.maximum.accumulate(test.sinkage)
    h = np.geomspace(depths[0], min(depths[1], deepest[-1]), STEPS)
    return h, np.interp(h, deepest, test.force)


def _power_law(h: Array, force: Array, area: float) -> tuple[float, float]:
    """n and log k of sigma = k h^n."""
    slope, level = np.polyfit(np.log(h), np.log(force / area), 1)
    return float(slope), float(level)


def _wheel_modulus(test: SinkageTest, n: float, radius: float, width: float) -> float:
    h, force = _sampled(test, WHEEL_DEPTHS)
    return float(np.exp(np.mean(np.log(force / standing_force(h, 1.0, n, radius, width)))))


def _chord(load: float, k: float, n: float, radius: float, width: float) -> float:
    h = np.linspace(1e-4, radius, 400)
    at = float(np.interp(load, standing_force(h, k, n, radius, width), h))
    return float(2 * np.sqrt(at * (2 * radius - at)))


def _mean(values: Sequence[float]) -> tuple[float, float]:
    return float(np.mean(values)), float(np.std(values, ddof=1) / np.sqrt(len(values)))


def _least_squares(design: Array, values: Array) -> tuple[Array, float]:
    found, *_ = np.linalg.lstsq(design, values, rcond=None)
    left = values - design @ found
    return np.asarray(found, dtype=float), float(np.sqrt(left @ left / (len(values) - design.shape[1])))
