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

from softsoil.symbolic import contact_line as fresh
from softsoil.symbolic.smooth import Scalar, smooth_min, smooth_norm, smooth_positive
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import LOAD_WIDTH, Contact, Wheel

RUT_NODES, BESIDE_NODES = 3, 4
"""Gauss nodes ahead of the wheel centre: in the rut, where the pressure has no root, and on the rest of the width."""
EDGE = 5e-4
"""m: how softly contact with the rut's floor begins."""
LEAST_BESIDE = 0.05
"""The least share of the width that counts as being beside a rut."""
NARROW = 0.005
"""How softly, in log(sinkage), the lesser of two sinkages is taken."""
SHALLOW = 0.35
"""Share of h_f, and of the width beside the rut, at which the pressure on the way from a shallower rut's floor is taken."""
LEAST_NEEDED = 1e-3
"""Share of the load that is carried above the rut's floor at least, where the steps start."""
LOWEST = 1e-6
"""m: what keeps roots and logarithms of nothing finite."""
SINKAGE_STEPS = 1
"""Newton steps on closed forms of both strips' loads; the pressures are then scaled to carry the load."""


def contact_lines(
    soil: Soil, wheel: Wheel, contact: Contact, front_nodes: int
) -> tuple[fresh.ContactLine, fresh.ContactLine | None]:
    """The line in fresh soil and, for a wheel that may meet a rut, the one in it; pressures such that both carry the load.

    contact: of the wheel, with the share of its width in the rut (overlap) and the rut's depth; front_nodes: ahead of the centre
    of a wheel that meets no rut.
    """
    if isinstance(contact.overlap, int | float) and contact.overlap == 0:
        return fresh.contact_line(soil, wheel, contact.load, contact.omega, front_nodes), None
    carried = smooth_positive(contact.load, LOAD_WIDTH)
    rut = _Rut(soil, wheel, contact.omega, contact.rut_depth)
    log_h = _sinkage(soil, wheel, contact, carried, rut)
    beside, inside = fresh.Shape.of(soil, wheel, contact.omega, BESIDE_NODES).line(log_h), rut.line(log_h)
    share = contact.overlap
    scale = carried / (wheel.width * ((1.0 - share) * beside.load + share * inside.load))
    return beside.scaled(scale, 1.0 - share), inside.scaled(scale, share)


def _sinkage(soil: Soil, wheel: Wheel, contact: Contact, carried: Scalar, rut: _Rut) -> Scalar:
    """log h of the wheel, by Newton steps in z = sqrt(height over the floor), in which the load grows evenly.

    They start where a quadratic in z carries what the soil at the floor does not: beside the rut the load grows with z^2, up to
    h_f, where the strip carries all; in the rut with z, by the pressure on the way. Where h_f does not reach the floor, it is the
    sinkage. One step from there leaves 0.3 % of h (rms).
    """
    beside, inside, r = _Beside(soil, wheel, contact.omega), contact.overlap, wheel.radius
    log_alone, deepest = fresh.sinkage_guess(soil, wheel, carried, contact.omega), ca.log(0.8 * r)
    left = smooth_norm(1.0 - inside, 0.0, LEAST_BESIDE)
    log_most = smooth_min(log_alone - ca.log(left) / (soil.n + 0.5), deepest, NARROW)
    most, sigma_most = ca.exp(log_most), rut.stiffness * ca.exp(soil.n * log_most)
    told, by_h = beside.load(most, sigma_most)
    line, near = carried / wheel.width, smooth_norm(rut.floor, 0.0, SHALLOW * left * most)
    sigma = rut.stiffness * ca.exp(soil.n * ca.log(near))
    tail = inside * _tail(sigma, soil, rut.rate, r)
    on_floor = left * told * (sigma / sigma_most) * ca.sqrt(rut.floor / most) * (rut.floor / near) + tail
    log_most = smooth_min(log_most - ca.log(left * told / line) * told / (most * by_h), deepest, NARROW)
    reach, needed = smooth_positive(ca.exp(log_most) - rut.floor, EDGE), smooth_positive(line - on_floor, LEAST_NEEDED * line)
    length = (line - 0.5 * tail) / sigma
    deeper = (rut.floor + length * length * reach / (length * length + 2.0 * r * reach)) / near - 1.0
    by_z = inside * sigma * (1.0 + 2.0 * soil.n * deeper / (3.0 + deeper)) * ca.sqrt(2.0 * r)
    z = 2.0 * needed / (by_z + ca.sqrt(by_z * by_z + 4.0 * needed * (needed / reach + inside * rut.rate * r)))
    for _ in range(SINKAGE_STEPS):
        h = rut.floor + z * z
        sigma_m = rut.stiffness * ca.exp(soil.n * ca.log(h))
        of_beside, by_h = beside.load(h, sigma_m)
        of_rut, by_z = rut.load(h, z, sigma_m)
        missing = carried / wheel.width - (1.0 - inside) * of_beside - inside * of_rut
        z = smooth_positive(z + missing / ((1.0 - inside) * by_h * 2.0 * z + inside * by_z), EDGE)
    return smooth_min(ca.log(rut.floor + z * z), log_most, NARROW)


class _Beside:
    """The strip in fresh soil, in closed form."""

    def __init__(self, soil: Soil, wheel: Wheel, omega: Scalar) -> None:
        self.soil, self.wheel, self.rate = soil, wheel, soil.R * omega
        self.area = fresh.parabola_area(soil.n)

    def load(self, h: Scalar, sigma_m: Scalar) -> tuple[Scalar, Scalar]:
        """int sigma dX (N/m) at sinkage h (m) with sigma_m = k_eq h^n (Pa), and its derivative to h."""
        n, r = self.soil.n, self.wheel.radius
        square, tail = h * _above(h, r), _tail(sigma_m, self.soil, self.rate, r)
        static, damping = sigma_m * ca.sqrt(square) * self.area, 0.5 * self.rate * square
        longer = (r - h) / _above(h, r)
        return static + damping + tail, ((n + longer) * static + 2.0 * longer * damping + 1.5 * n * tail) / h


def _above(height: Scalar, radius: Scalar) -> Scalar:
    """2 r - height (m), never below r: a wheel sinks no deeper than its axle."""
    return ca.fmax(2.0 * radius - height, radius)


def _tail(sigma_m: Scalar, soil: Soil, rate: Scalar, radius: Scalar) -> Scalar:
    """Load per width behind the wheel centre (N/m)."""
    x_rear = ca.sqrt(2.0 * radius * sigma_m / soil.K)
    return fresh.tail_pressure(sigma_m, x_rear, rate) * x_rear


class _Rut:
    """The strip in the rut."""

    def __init__(self, soil: Soil, wheel: Wheel, omega: Scalar, depth: Scalar) -> None:
        self.soil, self.wheel, self.rate = soil, wheel, soil.R * omega
        self.stiffness = fresh.bulk_modulus(soil, wheel)
        pressed = ca.fmax(depth, 0.0) + LOWEST
        yielded = self.stiffness * ca.exp(soil.n * ca.log(pressed))
        # Half the elastic rise, softly less than the rut's depth however soft the soil.
        self.floor = pressed * pressed / (pressed + yielded * (0.5 / soil.K))

    def load(self, h: Scalar, z: Scalar, sigma_m: Scalar) -> tuple[Scalar, Scalar]:
        """int sigma dX (N/m) at sinkage h = floor + z^2, by the closed form of int (1 - q t^2)^n dt, q = z^2/h, and its
        derivative to z."""
        n, r = self.soil.n, self.wheel.radius
        height = z * z
        x_front, q = z * ca.sqrt(_above(height, r)), height / h
        area = 1.0 - n * q * (1.0 / 3.0) * (1.0 + (1.0 - n) * q * 0.3 * (1.0 + (2.0 - n) * q * (5.0 / 21.0)))
        static, damping = sigma_m * area * x_front, 0.5 * self.rate * x_front * x_front
        tail = _tail(sigma_m, self.soil, self.rate, r)
        longer = 2.0 * (r - height) / _above(height, r)
        by_h = 2.0 * height / h
        by_z = (longer + n * by_h) * static + 2.0 * longer * damping + 1.5 * n * by_h * tail
        return static + damping + tail, by_z / z

    def line(self, log_h: Scalar) -> fresh.ContactLine:
        """The nodes at a sinkage; none press where the wheel does not reach the floor."""
        soil, r = self.soil, self.wheel.radius
        h = fresh.capped(log_h, r)[0]
        over = h - self.floor
        height = 0.5 * (over + ca.sqrt(over * over + EDGE * EDGE))
        square = height * height
        sigma_m = self.stiffness * ca.exp(soil.n * log_h) * square / (square + EDGE * EDGE)
        x_front, nodes = ca.sqrt(height * (2.0 * r - height)), []
        x_rear = ca.sqrt(2.0 * r * sigma_m / soil.K + LOWEST * LOWEST)
        for along, weight in gauss_rule(RUT_NODES):
            x = along * x_front
            depth = fresh.rim_depth(x * x, r)
            sunk = ca.fmax(1.0 - (r - depth) / h, 1e-6)
            sigma = sigma_m * ca.exp(soil.n * ca.log(sunk)) + self.rate * x
            nodes.append(fresh.Node(x, weight * x_front, sigma, depth, along))
        nodes.append(fresh.tail_node(r, x_rear, fresh.tail_pressure(sigma_m, x_rear, self.rate)))
        return fresh.ContactLine(nodes, h, x_front, x_rear)


@lru_cache(maxsize=16)
def gauss_rule(count: int) -> tuple[tuple[float, float], ...]:
    """`count` Gauss nodes of (0, 1) from front to rear, and their weights: of a contact, X/x_f and dX/x_f."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple((float(0.5 + 0.5 * a), float(0.5 * w)) for a, w in zip(nodes[::-1], weights[::-1], strict=True))
