"""Pressure along the contact line and the sinkage that carries the load, shared by the turn-slip laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from symbolic.smooth import Scalar, smooth_positive
from symbolic.soil import Soil
from symbolic.wheel import Wheel

LOAD_WIDTH = 0.1
"""N: loads below this are smoothed towards zero, so that a wheel in the air carries nothing instead of failing."""
DEEPEST = 0.9
"""Sinkage over radius at which the smooth cap bends; the contact line ends at the axle."""
SINKAGE_STEPS = 4
"""Newton steps in log(sinkage) on the quadrature: 0.01 % of h over the paper's Table 4."""


@dataclass(frozen=True)
class Node:
    """One quadrature node: x (m), weight (m), sigma (Pa), depth = sqrt(r^2 - x^2), of the rim below the axle (m)."""

    x: Scalar
    weight: Scalar
    sigma: Scalar
    depth: Scalar


@dataclass(frozen=True)
class ContactLine:
    """Nodes from front to rear, sinkage h, x_front and x_rear > 0: ends of the contact ahead and behind (m)."""

    nodes: Sequence[Node]
    sinkage: Scalar
    x_front: Scalar
    x_rear: Scalar


@lru_cache(maxsize=16)
def _front_rule(count: int) -> tuple[tuple[float, float, float], ...]:
    """(1 - xi^2, 2 xi w, log(1 - (1 - xi^2)^2)) at Gauss nodes xi of (0, 1): x/x_f, dx/x_f, log of parabolic depth/h.

    x = x_f (1 - xi^2) puts nodes where the pressure d^n has its root.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    xi = 0.5 * (1.0 + nodes)
    along = 1.0 - xi * xi
    return tuple(
        (float(a), float(w), math.log(1.0 - a * a)) for a, w in zip(along, xi * weights, strict=True)
    )


def tan_phi(phi: Scalar) -> Scalar:
    """tan(phi) by its Pade approximant (5/4): 1e-9 at 0.6 rad, and free of library calls in generated C."""
    if isinstance(phi, float | int):
        return math.tan(phi)
    q = phi * phi
    return phi * (945.0 - q * (105.0 - q)) / (945.0 - q * (420.0 - 15.0 * q))


def contact_line(
    soil: Soil, wheel: Wheel, load: Scalar, omega: Scalar, front_nodes: int, tail_nodes: int
) -> ContactLine:
    """Nodes, pressures and sinkage such that b int sigma dX = load.

    load: N; omega: spin, rad/s; front_nodes, tail_nodes: numbers of quadrature nodes.
    (d/h)^n = (1 - (X/x_f)^2)^n g^n with g = (2r - h)/(sqrt(r^2 - X^2) + r - h) near 1: the first factor does not depend
    on h, the second needs no logarithm, so that a step of the sinkage costs two exponentials.
    """
    rule = _front_rule(front_nodes)
    parabola = [ca.exp(soil.n * log_depth) for _, _, log_depth in rule]
    carried = smooth_positive(load, LOAD_WIDTH)
    shape = _Shape(soil, wheel, omega, rule, parabola)
    log_h = _first_guess(soil, wheel, carried)
    for _ in range(SINKAGE_STEPS):
        total, slope = shape.load(log_h)
        log_h = log_h - ca.log(total / carried) / slope
    return shape.line(log_h, tail_nodes)


def _first_guess(soil: Soil, wheel: Wheel, load: Scalar) -> Scalar:
    """log h from load = b k_eq sqrt(2r) beta h^(n + 1/2): pressure on a parabola alone."""
    beta = 1.0 / (1.0 + soil.n * (0.592 - 0.088 * soil.n))
    stiffness = soil.k_phi + soil.k_c * (1.0 / wheel.width + 2.5 / wheel.radius)
    return ca.log(load / (wheel.width * stiffness * ca.sqrt(2.0 * wheel.radius) * beta)) / (soil.n + 0.5)


@dataclass(frozen=True)
class _Shape:
    """Pressure along the line as a function of log h."""

    soil: Soil
    wheel: Wheel
    omega: Scalar
    rule: Sequence[tuple[float, float, float]]
    parabola: Sequence[Scalar]

    def _geometry(self, log_h: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """h (capped at the axle), x_f, sigma_m, x_r."""
        soil, r = self.soil, self.wheel.radius
        ratio = ca.exp(log_h) / (DEEPEST * r)
        capped = ratio / ca.sqrt(ca.sqrt(ca.sqrt(1.0 + ratio**8)))
        h = DEEPEST * r * capped
        x_front = ca.sqrt(h * (2.0 * r - h))
        sigma_m = (soil.k_phi + soil.k_c * (1.0 / self.wheel.width + 1.0 / x_front)) * ca.exp(soil.n * log_h)
        return h, x_front, sigma_m, ca.sqrt(2.0 * r * sigma_m / soil.K)

    def _front(self, h: Scalar, x_front: Scalar) -> list[tuple[Scalar, Scalar]]:
        """((d/h)^n, sqrt(r^2 - x^2)) at the front nodes."""
        r, out = self.wheel.radius, []
        for (along, _, _), shape in zip(self.rule, self.parabola, strict=True):
            depth = ca.sqrt(r * r - (along * along) * (x_front * x_front))
            excess = (r - depth) / (depth + r - h)
            z = excess / (2.0 + excess)
            y = self.soil.n * z * (2.0 + 0.6666666666666666 * z * z)
            out.append((shape * (1.0 + y * (1.0 + y * (0.5 + 0.16666666666666666 * y))), depth))
        return out

    def load(self, log_h: Scalar) -> tuple[Scalar, Scalar]:
        """Load carried (N) and d(log load)/d(log h), the latter from the powers of its three terms."""
        h, x_front, sigma_m, x_rear = self._geometry(log_h)
        area = sum(w * s for (_, w, _), (s, _) in zip(self.rule, self._front(h, x_front), strict=True))
        static = sigma_m * x_front * area
        damping = 0.5 * self.soil.R * self.omega * (x_front * x_front - x_rear * x_rear)
        tail = (2.0 / 3.0) * sigma_m * x_rear
        total = static + damping + tail
        n = self.soil.n
        return self.wheel.width * total, ((n + 0.5) * static + damping + 1.5 * n * tail) / total

    def line(self, log_h: Scalar, tail_nodes: int) -> ContactLine:
        """The nodes at the sinkage found."""
        h, x_front, sigma_m, x_rear = self._geometry(log_h)
        r, rate = self.wheel.radius, self.soil.R * self.omega
        nodes = []
        for (along, w, _), (shape, depth) in zip(self.rule, self._front(h, x_front), strict=True):
            x = along * x_front
            nodes.append(Node(x, w * x_front, sigma_m * shape + rate * x, depth))
        for position, w in zip(*np.polynomial.legendre.leggauss(tail_nodes), strict=True):
            part = 0.5 * (1.0 - position)
            x = -float(part) * x_rear
            sigma = smooth_positive(float(1.0 - part * part) * sigma_m + rate * x, 0.02 * sigma_m)
            nodes.append(Node(x, float(0.5 * w) * x_rear, sigma, r - 0.5 * x * x / r))
        return ContactLine(nodes, h, x_front, x_rear)
