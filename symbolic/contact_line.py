"""Pressure along the contact line and the sinkage that carries the load, shared by the turn-slip laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np

from softsoil.symbolic.smooth import Scalar, smooth_min, smooth_positive
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import DEEPEST, LOAD_WIDTH, Wheel

SINKAGE_STEPS = 1
"""Newton steps in log(sinkage) on the quadrature: 0.02 % of h in the median, 1 % at worst; the pressures are then
scaled to carry the load exactly."""


@dataclass(frozen=True)
class Node:
    """One quadrature node: x (m), weight (m), sigma (Pa), depth = sqrt(r^2 - x^2), of the rim below the axle (m); along: x over
    the front end of the contact, 0 behind the wheel centre."""

    x: Scalar
    weight: Scalar
    sigma: Scalar
    depth: Scalar
    along: float = 0.0


@dataclass(frozen=True)
class ContactLine:
    """Nodes from front to rear, sinkage h, x_front and x_rear > 0: ends of the contact ahead and behind (m); share: of the
    wheel's width that this line stands for."""

    nodes: Sequence[Node]
    sinkage: Scalar
    x_front: Scalar
    x_rear: Scalar
    share: Scalar = 1.0

    @property
    def load(self) -> Scalar:
        """int sigma dX (N per m of width)."""
        return sum(node.weight * node.sigma for node in self.nodes)

    def scaled(self, scale: Scalar, share: Scalar = 1.0) -> ContactLine:
        """The same line with all pressures times `scale`, for a share of the width."""
        nodes = [replace(node, sigma=scale * node.sigma) for node in self.nodes]
        return replace(self, nodes=nodes, share=share)


@lru_cache(maxsize=16)
def _front_rule(count: int) -> tuple[tuple[float, float, float], ...]:
    """(1 - xi^2, 2 xi w, log(1 - (1 - xi^2)^2)) at Gauss nodes xi of (0, 1): x/x_f, dx/x_f, log of parabolic depth/h.

    x = x_f (1 - xi^2) puts nodes where the pressure d^n has its root.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    xi = 0.5 * (1.0 + nodes)
    along = 1.0 - xi * xi
    return tuple((float(a), float(w), math.log(1.0 - a * a)) for a, w in zip(along, xi * weights, strict=True))


def tan_phi(phi: Scalar) -> Scalar:
    """tan(phi) by its Pade approximant (5/4): 1e-9 at 0.6 rad, and free of library calls in generated C."""
    if isinstance(phi, float | int):
        return math.tan(phi)
    q = phi * phi
    return phi * (945.0 - q * (105.0 - q)) / (945.0 - q * (420.0 - 15.0 * q))


def rim_depth(square: Scalar, radius: Scalar) -> Scalar:
    """sqrt(r^2 - x^2) (m) from square = x^2 (m^2), radius r (m): its series to x^10, 2e-5 r at x = r/2, without a root."""
    s = square * (1.0 / (radius * radius))
    return radius * (1.0 - s * (0.5 + s * (0.125 + s * (0.0625 + s * (0.0390625 + 0.02734375 * s)))))


def bulk_modulus(soil: Soil, wheel: Wheel) -> Scalar:
    """k_eq = k_phi + k_c/b, N/m^(n+2) (paper, eq. (1))."""
    return soil.k_phi + soil.k_c * (1.0 / wheel.width)


def contact_line(soil: Soil, wheel: Wheel, load: Scalar, omega: Scalar, front_nodes: int) -> ContactLine:
    """Nodes, pressures and sinkage such that b int sigma dX = load.

    load: N; omega: spin, rad/s; front_nodes: number of quadrature nodes ahead of the wheel centre; one stands behind.
    (d/h)^n = (1 - (X/x_f)^2)^n g^n with g = (2r - h)/(sqrt(r^2 - X^2) + r - h) near 1: the first factor does not depend
    on h, the second needs no logarithm, so that a step of the sinkage costs two exponentials and one logarithm.
    """
    carried = smooth_positive(load, LOAD_WIDTH)
    shape = Shape.of(soil, wheel, omega, front_nodes)
    log_h = sinkage_guess(soil, wheel, carried, omega)
    for _ in range(SINKAGE_STEPS):
        total, slope = shape.load(log_h)
        log_h = log_h - ca.log(total / carried) / slope
    line = shape.line(log_h)
    return line.scaled(carried / (wheel.width * line.load))


def parabola_area(n: Scalar) -> Scalar:
    """int_0^1 (1 - xi^2)^n dxi = sqrt(pi) Gamma(n + 1)/(2 Gamma(n + 3/2)), within 3e-3 for n up to 1.4: mean over greatest
    pressure ahead of the wheel centre."""
    return 1.0 / (1.0 + n * (0.592 - 0.088 * n))


def sinkage_guess(soil: Soil, wheel: Wheel, load: Scalar, omega: Scalar) -> Scalar:
    """log h from load = A h^p, p = n + 1/2, A = b k_eq sqrt(2r) parabola_area(n): pressure on a parabola alone, then one step for
    the damping B h, B = b R omega r, and the tail T h^(1.5 n), T = (2/3) b k_eq sqrt(2 r k_eq/K).
    """
    b, r, n = wheel.width, wheel.radius, soil.n
    stiffness = bulk_modulus(soil, wheel)
    log_h = ca.log(load / (b * stiffness * ca.sqrt(2.0 * r) * parabola_area(n))) / (n + 0.5)
    sigma_m = stiffness * ca.exp(n * log_h)
    more = b * (soil.R * omega * r * ca.exp(log_h) + (2.0 / 3.0) * sigma_m * ca.sqrt(sigma_m * (2.0 * r / soil.K)))
    return log_h - ca.log(1.0 + more / load) / (0.5 + 0.5 * smooth_min(n + 0.5, 1.0, 0.1))


@dataclass(frozen=True)
class Shape:
    """Pressure along the line as a function of log h."""

    soil: Soil
    wheel: Wheel
    omega: Scalar
    rule: Sequence[tuple[float, float, float]]
    parabola: Sequence[Scalar]
    stiffness: Scalar

    @classmethod
    def of(cls, soil: Soil, wheel: Wheel, omega: Scalar, front_nodes: int) -> Shape:
        """The shape for a soil, a wheel and its spin `omega` (rad/s), with `front_nodes` quadrature nodes ahead of the centre."""
        rule = _front_rule(front_nodes)
        parabola = [ca.exp(soil.n * log_depth) for _, _, log_depth in rule]
        return cls(soil, wheel, omega, rule, parabola, bulk_modulus(soil, wheel))

    def _geometry(self, log_h: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar, Scalar]:
        """h (capped at the axle), x_f, sigma_m, x_r, d(log x_f)/d(log h)."""
        soil, r = self.soil, self.wheel.radius
        h, bend = capped(log_h, r)
        x_front = ca.sqrt(h * (2.0 * r - h))
        sigma_m = self.stiffness * ca.exp(soil.n * log_h)
        return h, x_front, sigma_m, ca.sqrt(2.0 * r * sigma_m / soil.K), (r - h) / ((2.0 * r - h) * bend)

    def _front(self, h: Scalar, x_front: Scalar) -> list[tuple[Scalar, Scalar]]:
        """((d/h)^n, sqrt(r^2 - x^2)) at the front nodes; log g = -log(1 - (r - depth)/(2r - h)) by its series."""
        r, out = self.wheel.radius, []
        longest, twice = x_front * x_front, 2.0 / (2.0 * r - h)  # 2/., since CasADi turns a factor 1/. into a division
        for (along, _, _), shape in zip(self.rule, self.parabola, strict=True):
            depth = rim_depth(along * along * longest, r)
            q = (r - depth) * twice
            y = self.soil.n * (q * (0.5 + q * (0.125 + q * (0.041666666666666664 + 0.015625 * q))))
            out.append((shape * (1.0 + y * (1.0 + y * (0.5 + 0.16666666666666666 * y))), depth))
        return out

    def load(self, log_h: Scalar) -> tuple[Scalar, Scalar]:
        """Load carried (N) and d(log load)/d(log h), the latter from the powers of its three terms."""
        h, x_front, sigma_m, x_rear, growth = self._geometry(log_h)
        total, static, damping, tail = self._terms(self._front(h, x_front), x_front, sigma_m, x_rear)
        n = self.soil.n
        return self.wheel.width * total, ((n + growth) * static + 2.0 * growth * damping + 1.5 * n * tail) / total

    def _terms(
        self, front: list[tuple[Scalar, Scalar]], x_front: Scalar, sigma_m: Scalar, x_rear: Scalar
    ) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """Load per width (N/m): the sum, and its parts from pressure ahead, damping and tail."""
        area = sum(w * s for (_, w, _), (s, _) in zip(self.rule, front, strict=True))
        static = sigma_m * x_front * area
        damping = 0.5 * self.soil.R * self.omega * x_front * x_front
        tail = tail_pressure(sigma_m, x_rear, self.soil.R * self.omega) * x_rear
        return static + damping + tail, static, damping, tail

    def line(self, log_h: Scalar) -> ContactLine:
        """The nodes at a sinkage."""
        h, x_front, sigma_m, x_rear, _ = self._geometry(log_h)
        r, rate, nodes = self.wheel.radius, self.soil.R * self.omega, []
        for (along, w, _), (shape, depth) in zip(self.rule, self._front(h, x_front), strict=True):
            x = along * x_front
            nodes.append(Node(x, w * x_front, sigma_m * shape + rate * x, depth, along))
        return ContactLine([*nodes, tail_node(r, x_rear, tail_pressure(sigma_m, x_rear, rate))], h, x_front, x_rear)


def capped(log_h: Scalar, radius: Scalar) -> tuple[Scalar, Scalar]:
    """h (m) from log_h, capped at the axle of a wheel of radius (m), and h d(log h)/dh of the cap's inverse, 1 without a bend."""
    uncapped = ca.exp(log_h)
    ratio = uncapped * (1.0 / (DEEPEST * radius))
    bend = 1.0 + (ratio * ratio) ** 2
    return uncapped / ca.sqrt(ca.sqrt(bend)), bend


def tail_pressure(sigma_m: Scalar, x_rear: Scalar, rate: Scalar) -> Scalar:
    """Mean pressure behind the wheel centre (Pa): (2/3) sigma_m - rate x_rear/2 to first order, never negative.

    sigma_m: under the centre (Pa); x_rear: how far the contact reaches behind it (m); rate: R omega (Pa/m).
    """
    static = (2.0 / 3.0) * sigma_m
    return static * static / (static + 0.5 * rate * x_rear)


def tail_node(radius: Scalar, x_rear: Scalar, sigma: Scalar) -> Node:
    """The one node behind the centre of a wheel of a radius (m), at the middle of the load of the x_rear (m) there; sigma: Pa."""
    x = -0.375 * x_rear
    return Node(x, x_rear, sigma, radius - (0.5 / radius) * x * x)
