"""The Bekker-Wong law of the paper, equations (4)-(16): stresses over the angle of contact, Newton sinkage.

theta is measured from bottom dead centre, forward positive. What the printed equations leave open or have wrong:
- theta_r is -acos(1 - Lambda h/r): the rear of the contact lies behind the axle (printed with +);
- the Newton step is h - (F_z(h) - W)/F_z'(h) (printed without W), here a fixed number of safeguarded steps;
- 1 - s for s >= 0 and 1/(1 + s) for s < 0 are one quantity, v_x/(r omega): no branch is left, and j_y gets it too;
- j < 0 (braking) would make 1 - exp(-j/k) blow up: tau follows sign(j)(1 - exp(-|j|/k));
- tau and tau_y each by itself can exceed the Mohr-Coulomb limit together: one shear vector along (j, j_y), limited once;
- the integral of F_y lacks d(theta) and its sign: the force opposes v_y.
a_0, a_1 and Lambda are the literature's usual values; the paper does not give the ones it used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from softsoil.symbolic.smooth import Scalar, smooth_positive
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import DEEPEST, LOAD_WIDTH, Contact, Wheel, WheelForce


@dataclass(frozen=True)
class Rolling:
    """How a wheel rolls: inverse = v_x/(r omega), aside = v_y/omega/r (path per angle over radius), slip s (paper)."""

    inverse: Scalar
    aside: Scalar
    slip: Scalar


def rolling(contact: Contact, radius: Scalar, speed_floor: float, spin_floor: float) -> Rolling:
    """Rolling of the wheel of given radius (m) with spin kept above spin_floor v/r and v above speed_floor (m/s), smoothly.

    s = (r omega - v_x)/max(r omega, v_x): 1 - v_x/(r omega) when driving, r omega/v_x - 1 when braking.
    """
    v = ca.sqrt(contact.v_x * contact.v_x + speed_floor**2)
    rim = ca.sqrt((radius * contact.omega) ** 2 + (spin_floor * v) ** 2)
    faster = 0.5 * (rim + v + ca.sqrt((rim - v) ** 2 + (1e-3 * v) ** 2))
    return Rolling(v / rim, contact.v_y / rim, (rim - v) / faster)


@dataclass(frozen=True)
class Arc:
    """The arc of contact: h (m), angles theta_f > theta_m > theta_r (rad) and cos(theta_f)."""

    h: Scalar
    front: Scalar
    middle: Scalar
    rear: Scalar
    cos_front: Scalar

    @classmethod
    def of(cls, h: Scalar, radius: Scalar, peak: Scalar, rebound: float) -> Arc:
        """Arc at sinkage h (m) with theta_m = peak theta_f, equations (8), (9) and (11); h is capped short of the axle.

        radius: r (m); rebound: Lambda, sinkage ratio.
        """
        deepest = DEEPEST * radius
        ratio = h / deepest
        h = h / ca.sqrt(ca.sqrt(ca.sqrt(1.0 + ((ratio * ratio) ** 2) ** 2)))
        front = ca.acos(1.0 - h / radius)
        return cls(h, front, peak * front, -ca.acos(1.0 - rebound * h / radius), 1.0 - h / radius)

    def depth(self, theta: Scalar, radius: Scalar, ahead: bool) -> Scalar:
        """h(theta) (m), equations (7) and (10), at an angle ahead of theta_m or behind it; radius: r (m)."""
        if not ahead:
            theta = self.front - (theta - self.rear) * (self.front - self.middle) / (self.middle - self.rear)
        return radius * (ca.cos(theta) - self.cos_front)

    def integrals(self, stress: Callable[[Scalar, bool], Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """Integrals of q, q cos(theta), q sin(theta) over the arc, q a parabola on each side of theta_m.

        The quadratic approximation: each parabola passes through the stress at the ends and the middle of its side; its
        products with cos and sin are integrated in closed form, as series in the half width w (1e-6 at 0.5 rad).
        """
        plain: Scalar = 0.0
        with_cos: Scalar = 0.0
        with_sin: Scalar = 0.0
        for low, high, ahead in ((self.rear, self.middle, False), (self.middle, self.front, True)):
            centre, w = 0.5 * (low + high), 0.5 * (high - low)
            q_low, q_mid, q_high = stress(low, ahead), stress(centre, ahead), stress(high, ahead)
            slope, bend = 0.5 * (q_high - q_low), 0.5 * (q_high + q_low) - q_mid
            square = w * w
            even = 2.0 * w * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0)))
            odd = 2.0 * square * (1.0 / 3.0 - square * (1.0 / 30.0 - square / 840.0))
            bent = 2.0 * w * (1.0 / 3.0 - square * (1.0 / 10.0 - square * (1.0 / 168.0 - square / 6480.0)))
            along, across = q_mid * even + bend * bent, slope * odd
            cos, sin = ca.cos(centre), ca.sin(centre)
            plain += 2.0 * w * (q_mid + bend / 3.0)
            with_cos += cos * along - sin * across
            with_sin += sin * along + cos * across
        return plain, with_cos, with_sin


@dataclass(frozen=True)
class Bekker:
    """Equations (4)-(16) of the paper with the quadratic approximation of the stresses.

    a_0, a_1: theta_m = (a_0 + a_1 s) theta_f; rebound: Lambda, sinkage ratio; newton_steps: of the sinkage;
    speed_floor: m/s; spin_floor, slip_floor: least rim speed and least sliding speed over v_x.
    """

    a_0: float = 0.4
    a_1: float = 0.15
    rebound: float = 0.1
    newton_steps: int = 5
    speed_floor: float = 0.1
    spin_floor: float = 0.05
    slip_floor: float = 0.01

    @property
    def name(self) -> str:
        """bekker."""
        return "bekker"

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel; see the module for the equations and softsoil.symbolic.wheel for conventions."""
        roll = rolling(contact, wheel.radius, self.speed_floor, self.spin_floor)
        return self.forces(soil, wheel, contact, roll, self.sink(soil, wheel, contact, roll))

    def forces(self, soil: Soil, wheel: Wheel, contact: Contact, roll: Rolling, arc: Arc) -> WheelForce:
        """Forces over a given arc of contact, equation (15) and its longitudinal sister."""
        b_r, r = wheel.width * wheel.radius, wheel.radius
        _, _, s_sin = arc.integrals(lambda a, ahead: pressure(soil, wheel, arc, a, ahead))
        x_int, x_cos, _ = arc.integrals(lambda a, ahead: self.shear(soil, wheel, contact, roll, arc, a, ahead)[0])
        y_int, _, y_sin = arc.integrals(lambda a, ahead: self.shear(soil, wheel, contact, roll, arc, a, ahead)[1])
        _, _, exit_path = self.path(wheel, roll, arc, arc.rear)
        return WheelForce(
            f_x=b_r * (x_cos - s_sin),
            f_y=b_r * y_int,
            m_y=-b_r * r * x_int,
            m_z=b_r * r * y_sin,
            sinkage=arc.h,
            exit_path=exit_path,
        )

    def path(self, wheel: Wheel, roll: Rolling, arc: Arc, theta: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """j (12), j_y (17) and the length of their vector (m), the last never zero."""
        turned, sines = arc.front - theta, ca.sin(arc.front) - ca.sin(theta)
        along = wheel.radius * (turned - roll.inverse * sines)
        aside = wheel.radius * roll.aside * turned
        least = self.slip_floor * wheel.radius * turned
        return along, aside, ca.sqrt(along * along + aside * aside + least * least + 1e-18)

    def shear(
        self, soil: Soil, wheel: Wheel, contact: Contact, roll: Rolling, arc: Arc, theta: Scalar, ahead: bool
    ) -> tuple[Scalar, Scalar]:
        """tau, tau_y on the wheel (Pa), equations (5), (6) and (16) as one vector along (j, j_y); ahead: of theta_m."""
        along, aside, length = self.path(wheel, roll, arc, theta)
        fresh = 1.0 - contact.overlap * (1.0 - ca.exp(-contact.entry_path / soil.k))
        limit = soil.c + pressure(soil, wheel, arc, theta, ahead) * ca.tan(soil.phi)
        tau = limit * (1.0 - fresh * ca.exp(-length / soil.k)) / length
        return tau * along, -tau * aside

    def sink(self, soil: Soil, wheel: Wheel, contact: Contact, roll: Rolling) -> Arc:
        """The arc whose reaction, equation (14), equals the load: Newton from the static sinkage, equation (13).

        A step may change h by at most half, and the slope counts at least 0.2 F_z/h, so that no load can throw h out.
        """
        load = smooth_positive(contact.load, LOAD_WIDTH)
        peak = self.a_0 + self.a_1 * roll.slip
        h = ca.SX.sym("h")
        arc = Arc.of(h, wheel.radius, peak, self.rebound)
        _, s_cos, _ = arc.integrals(lambda a, ahead: pressure(soil, wheel, arc, a, ahead))
        _, _, t_sin = arc.integrals(lambda a, ahead: self.shear(soil, wheel, contact, roll, arc, a, ahead)[0])
        reaction = wheel.width * wheel.radius * (t_sin + s_cos)
        growth = h * ca.gradient(reaction, h) / load
        growth = 0.2 + smooth_positive(growth - 0.2, 0.05)
        step = (reaction / load - 1.0) / growth
        stepped = h * (1.0 - step / ca.sqrt(1.0 + 4.0 * step * step))
        stiffness = soil.k_c + wheel.width * soil.k_phi
        guess = ca.log(3.0 * load / ((3.0 - soil.n) * stiffness * ca.sqrt(2.0 * wheel.radius)))
        value = ca.exp(guess * (2.0 / (2.0 * soil.n + 1.0)))
        for _ in range(self.newton_steps):
            value = ca.substitute(ca.SX(stepped), h, ca.SX(value))
        return Arc.of(value, wheel.radius, peak, self.rebound)


def pressure(soil: Soil, wheel: Wheel, arc: Arc, theta: Scalar, ahead: bool) -> Scalar:
    """sigma(theta), equation (4) (Pa); ahead: of theta_m."""
    depth = arc.depth(theta, wheel.radius, ahead)
    positive = 0.5 * (depth + ca.sqrt(depth * depth + (1e-6 * wheel.radius) ** 2))
    return (soil.k_c / wheel.width + soil.k_phi) * ca.exp(soil.n * ca.log(positive))
