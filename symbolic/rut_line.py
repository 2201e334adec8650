"""The contact of a wheel that runs partly in a rut: two strips of its width, in the rut and beside it, at one sinkage.

In the rut the soil has carried a wheel of sinkage h_1 before. It has yielded at sigma_1 = k_eq h_1^n and sprung back by
sigma_1/K; pressed again it is stiff up to sigma_1 and follows the virgin curve from there. So contact begins near the rut's floor
f = h_1 - sigma_1/(2K), half way through the elastic rise, with sigma = k_eq d^n at once, d the depth below the undisturbed
surface: shorter and, for the same load, deeper than in fresh soil. The soil contact model's own memory of plastic sinkage and
yield, on a line.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from symbolic.contact_line import (
    DEEPEST,
    LOAD_WIDTH,
    ContactLine,
    Node,
    Shape,
    bulk_modulus,
    contact_line,
    rim_depth,
    sinkage_guess,
    tail_node,
    tail_pressure,
)
from symbolic.smooth import Scalar, smooth_positive
from symbolic.soil import Soil
from symbolic.wheel import Contact, Wheel

RUT_NODES = 3
"""Gauss nodes ahead of the wheel centre in the rut, where the pressure has no root."""
EDGE = 5e-4
"""m: how softly contact with the rut's floor begins."""
SINKAGE_STEPS = 2
"""Newton steps in log(sinkage) on closed forms of both strips' loads; the pressures are then scaled to carry the load."""


def contact_lines(soil: Soil, wheel: Wheel, contact: Contact, front_nodes: int) -> tuple[ContactLine, ContactLine | None]:
    """The line in fresh soil and, for a wheel that may meet a rut, the one in it; pressures such that both carry the load."""
    if isinstance(contact.overlap, int | float) and contact.overlap == 0:
        return contact_line(soil, wheel, contact.load, contact.omega, front_nodes), None
    carried = smooth_positive(contact.load, LOAD_WIDTH)
    rut = _Rut(soil, wheel, contact.omega, contact.rut_depth)
    log_h = _sinkage(soil, wheel, contact, carried, rut)
    beside, inside, share = Shape.of(soil, wheel, contact.omega, front_nodes).line(log_h), rut.line(log_h), contact.overlap
    scale = carried / (wheel.width * ((1.0 - share) * beside.load + share * inside.load))
    return beside.scaled(scale, 1.0 - share), inside.scaled(scale, share)


def _sinkage(soil: Soil, wheel: Wheel, contact: Contact, carried: Scalar, rut: _Rut) -> Scalar:
    """log h of the wheel, between what fresh soil and what the rut alone would give."""
    alone = ca.exp(sinkage_guess(soil, wheel, carried, contact.omega))
    log_h = ca.log(alone * rut.deeper(alone, carried, contact.overlap))
    flat = _Rut(soil, wheel, contact.omega, 0.0)
    for _ in range(SINKAGE_STEPS):
        load = slope = 0.0
        for strip, share in ((flat, 1.0 - contact.overlap), (rut, contact.overlap)):
            part, growth = strip.load(log_h)
            load, slope = load + share * part, slope + share * growth
        log_h = log_h - ca.log(wheel.width * load / carried) * load / slope
    return log_h


class _Rut:
    """The strip in the rut, as a function of log h."""

    def __init__(self, soil: Soil, wheel: Wheel, omega: Scalar, depth: Scalar) -> None:
        self.soil, self.wheel, self.rate = soil, wheel, soil.R * omega
        self.stiffness = bulk_modulus(soil, wheel)
        self.fresh = isinstance(depth, int | float) and depth == 0
        if self.fresh:
            self.floor = 0.0
            return
        pressed = ca.fmax(depth, 0.0) + 1e-6
        yielded = self.stiffness * ca.exp(soil.n * ca.log(pressed))
        # Half the elastic rise, softly less than the rut's depth however soft the soil.
        self.floor = pressed * pressed / (pressed + yielded * (0.5 / soil.K))

    def deeper(self, alone: Scalar, carried: Scalar, share: Scalar) -> Scalar:
        """First guess of h over `alone`, the sinkage in fresh soil: harmonic mean, by share, of both strips' own."""
        r = self.wheel.radius
        sigma = self.stiffness * ca.exp(self.soil.n * ca.log(0.5 * (alone + self.floor)))
        most = carried / (self.wheel.width * sigma)
        rise = most * most / (2.0 * r)
        own = self.floor + rise * alone / ca.sqrt(rise * rise + alone * alone)
        return 1.0 / (1.0 - share + share * alone / (alone + smooth_positive(own - alone, EDGE)))

    def _geometry(self, log_h: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar, Scalar]:
        """h (capped at the axle), height e over the floor and de/d(log h), sigma_m, x_r."""
        soil, r = self.soil, self.wheel.radius
        uncapped = ca.exp(log_h)
        ratio = uncapped * (1.0 / (DEEPEST * r))
        bend = 1.0 + (ratio * ratio) ** 2
        h = uncapped / ca.sqrt(ca.sqrt(bend))
        sigma_m = self.stiffness * ca.exp(soil.n * log_h)
        x_rear = ca.sqrt(2.0 * r * sigma_m / soil.K)
        if self.fresh:
            return h, h, h / bend, sigma_m, x_rear
        over = h - self.floor
        root = ca.sqrt(over * over + EDGE * EDGE)
        height = 0.5 * (over + root)
        return h, height, h * height / (root * bend), sigma_m, x_rear

    def load(self, log_h: Scalar) -> tuple[Scalar, Scalar]:
        """int sigma dX (N/m) and its derivative to log h, by the closed form of int (1 - q t^2)^n dt, q = e/h."""
        n, r = self.soil.n, self.wheel.radius
        h, height, growth, sigma_m, x_rear = self._geometry(log_h)
        x_front = ca.sqrt(height * (2.0 * r - height))
        longer = growth * (r - height) / (height * (2.0 * r - height))
        if self.fresh:
            area = 1.0 / (1.0 + n * (0.592 - 0.088 * n))
        else:
            q = height / h
            area = 1.0 - n * q * (1.0 / 3.0) * (1.0 + (1.0 - n) * q * 0.3 * (1.0 + (2.0 - n) * q * (5.0 / 21.0)))
        static, damping = sigma_m * x_front * area, 0.5 * self.rate * x_front * x_front
        tail = tail_pressure(sigma_m, x_rear, self.rate) * x_rear
        return static + damping + tail, (n + longer) * static + 2.0 * longer * damping + 1.5 * n * tail

    def line(self, log_h: Scalar) -> ContactLine:
        """The nodes at a sinkage."""
        n, r = self.soil.n, self.wheel.radius
        h, height, _, sigma_m, x_rear = self._geometry(log_h)
        x_front, nodes = ca.sqrt(height * (2.0 * r - height)), []
        for along, weight in _rule(RUT_NODES):
            x = along * x_front
            depth = rim_depth(x * x, r)
            sunk = ca.fmax(1.0 - (r - depth) / h, 1e-6)
            nodes.append(Node(x, weight * x_front, sigma_m * ca.exp(n * ca.log(sunk)) + self.rate * x, depth))
        return ContactLine([*nodes, tail_node(r, x_rear, tail_pressure(sigma_m, x_rear, self.rate))], h, x_front, x_rear)


@lru_cache(maxsize=16)
def _rule(count: int) -> tuple[tuple[float, float], ...]:
    """(x/x_f, dx/x_f) from front to rear: Gauss nodes of (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple((float(0.5 + 0.5 * a), float(0.5 * w)) for a, w in zip(nodes[::-1], weights[::-1], strict=True))
