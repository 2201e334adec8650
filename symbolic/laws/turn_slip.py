"""The default force law: stresses on a contact line, with the wheel's own yaw in the sliding velocity; nothing fitted.

X is forward of the wheel centre, x_f where the soil enters, -x_r where it leaves, k_eq = k_phi + k_c/b:
  pressure   sigma = k_eq d(X)^n + R omega X,  d = sqrt(r^2 - X^2) - (r - h), for X >= 0,
             sigma = sigma_m (1 - (X/x_r)^2) + R omega X behind, sigma_m = k_eq h^n, x_r = sqrt(2 r sigma_m/K);
  sinkage    b int sigma dX = load;
  sliding    u_x = v_x - omega sqrt(r^2 - X^2), u_y = v_y + (yaw_rate + sweep) X;
  path       j(X) = int_X^x_f |u| dX'/v_x with the velocities that this soil met, u_y(X', t - (X' - X)/v_x);
  shear      tau = (c + sigma tan phi)(1 - exp(-j/k)), against u: force = -b int tau u/|u| dX, in ruts its mean over b.
Soil that entered through the side of the wheel has run part of the path only (`side_entry`); soil that another wheel
sheared before starts at `entry_path` in the fraction `overlap` of the width. The equations are those of the soil
contact model (paper, eqs. (1)-(3)) on a line; turn slip replaces the paper's two branches and correction factors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import casadi as ca

from softsoil.symbolic.contact_line import ContactLine, rim_depth, tan_phi
from softsoil.symbolic.rut_line import contact_lines, gauss_rule
from softsoil.symbolic.smooth import Scalar
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact, Wheel, WheelForce


@dataclass(frozen=True)
class Factors:
    """What a calibration may change, all neutral by default: width, path and turn multiply the wheel's width, the shear
    path and the yaw rate; entry_time (s) is spent at every node on top of half a contact step. Floats or CasADi scalars.
    """

    width: Scalar = 1.0
    path: Scalar = 1.0
    turn: Scalar = 1.0
    entry_time: Scalar = 0.0


@dataclass(frozen=True)
class TurnSlip:
    """The fit-free law, of a real soil by default.

    Where data come from a simulated soil: contact_step (s), its time step, of which its first contact counts a whole one of
    shear, half a step too much on average; contact_entry, the part of the contact over which soil that has just been touched is
    still met at the height where it entered; patch_length, length over radius of the patch that its contact search finds, which
    reaches above the soil: k_c then counts 1/b + 1/L, half the patch's perimeter over its area, instead of 1/b;
    speed_floor: m/s, v_x is used as sqrt(v_x^2 + speed_floor^2); slip_floor: pure number, sliding speeds are used as
    sqrt(|u|^2 + (slip_floor v_x)^2 + (yaw_rate b)^2/12), the last for the scrub over the width of a wheel that yaws (not
    of one that leans: its rim sweeps all of its width alike);
    front_nodes: Gauss nodes ahead of the wheel centre (one stands behind); factors: of a calibration.
    Raises ValueError unless contact_step and patch_length are >= 0 and the others positive.
    """

    contact_step: Scalar = 0.0
    speed_floor: float = 0.1
    slip_floor: float = 0.003
    front_nodes: int = 5
    factors: Factors = field(default_factory=Factors)
    contact_entry: float = 0.1
    patch_length: float = 0.0

    def __post_init__(self) -> None:
        for name in ("contact_step", "patch_length"):
            if isinstance(getattr(self, name), int | float) and not getattr(self, name) >= 0:
                raise ValueError(f"turn_slip: expected {name} >= 0, found {getattr(self, name)}")
        for name in ("speed_floor", "slip_floor", "front_nodes", "contact_entry"):
            if not getattr(self, name) > 0:
                raise ValueError(f"turn_slip: expected {name} > 0, found {getattr(self, name)}")

    @property
    def name(self) -> str:
        """turn_slip."""
        return "turn_slip"

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel; see the module for the equations and softsoil.symbolic.wheel for conventions."""
        wheel = replace(wheel, width=wheel.width * self.factors.width)
        if self.patch_length:
            soil = replace(soil, k_phi=soil.k_phi + soil.k_c * (1.0 / (self.patch_length * wheel.radius)))
        scrub = contact.yaw_rate * self.factors.turn * wheel.width
        contact = replace(contact, yaw_rate=(contact.yaw_rate + contact.sweep) * self.factors.turn)
        beside, inside = contact_lines(soil, wheel, contact, self.front_nodes)
        v = ca.sqrt(contact.v_x * contact.v_x + self.speed_floor**2)
        floor, spread = (self.slip_floor * v) ** 2, scrub * (1.0 / math.sqrt(12.0))
        extra, late = 0.5 * self.contact_step + self.factors.entry_time, self.contact_step * v
        late = 0.0 if isinstance(self.contact_step, float) and not self.contact_step else late
        motion = Sliding(contact, wheel.radius, 2.0 / v, floor, spread, extra, late, self.contact_entry)
        # Twice the reciprocals: CasADi would turn each product with a plain 1/x back into a division.
        per_k, aside = (2.0 / soil.k) * self.factors.path, 2.0 / (v * wheel.width)
        f_x, f_y, m_y, m_z = _strip(soil, wheel, motion, beside, None, per_k, aside)
        if inside is not None:
            entered = ca.exp(-contact.entry_path / soil.k)
            more = _strip(soil, wheel, motion, inside, entered, per_k, aside)
            f_x, f_y, m_y, m_z = f_x + more[0], f_y + more[1], m_y + more[2], m_z + more[3]
        rear, front = -beside.x_rear, beside.x_front
        drift = motion.mean_y(rear, front) * ((front - rear) / v)
        shift = -0.5 * drift * ((front + rear) / (front - rear))
        path = motion.left(rear, front) * self.factors.path
        return WheelForce(f_x, f_y, m_y, m_z, beside.sinkage, path, ca.sqrt(drift * drift + 1e-8), shift)


def _strip(
    soil: Soil, wheel: Wheel, motion: Sliding, line: ContactLine, sheared: Scalar | None, per_k: Scalar, aside: Scalar
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """f_x, f_y (N), m_y, m_z (N m) of one strip of the width; sheared: exp(-j/k) of its soil's path before, None in fresh soil.

    per_k: 2/k times the path's factor (1/m); aside: 2/(v_x b) (s/m^2).
    """
    tan, width, entered = tan_phi(soil.phi), wheel.width * line.share, 1.0 if sheared is None else sheared
    f_x = f_y = m_y = m_z = 0.0
    for node in line.nodes:
        u_x, u_y, length = motion.at(node.x, node.depth, node.along)
        path = motion.path(node.x, line.x_front, length, node.along) * 0.5 * per_k
        drift = motion.mean_y(node.x, line.x_front) * (0.5 * (line.x_front - node.x)) * aside
        tau = (soil.c + node.sigma * tan) * (1.0 - entered * side_entry(path, drift))
        along, across = (u_x, u_y) if sheared is None else motion.direction(u_x, u_y)
        force = -width * node.weight * tau / (length if sheared is None else 1.0)
        f_x += force * along
        f_y += force * across
        m_y -= node.depth * force * along + width * node.weight * node.sigma * node.x
        m_z += node.x * force * across
    return f_x, f_y, m_y, m_z


@dataclass(frozen=True)
class Sliding:
    """Sliding velocities of the wheel's body over the soil (m/s), and the shear path they leave (m).

    twice_per_v: 2/v_x (s/m); floor: square of the least sliding speed (m^2/s^2); spread: standard deviation of u_x over the width
    of a wheel that yaws (m/s); extra: time that a path counts beyond its own (s); late: way (m) by which a simulated soil's
    surface lags behind the rim: it meets the wheel with the height of one step before, where the rim moves more slowly backward,
    over the part `entry` of the contact.
    """

    contact: Contact
    radius: Scalar
    twice_per_v: Scalar
    floor: Scalar
    spread: Scalar
    extra: Scalar
    late: Scalar = 0.0
    entry: float = 0.1

    def at(self, x: Scalar, depth: Scalar, along: float = 0.0) -> tuple[Scalar, Scalar, Scalar]:
        """u_x, u_y and the smooth |u| at x (m), with `depth` = sqrt(r^2 - x^2); along: x over the front end of the contact."""
        u_x = self.contact.v_x - self.contact.omega * self._met(x, depth, along)
        u_y = self.contact.v_y + self.contact.yaw_rate * x
        return u_x, u_y, self._length(u_x, u_y)

    def _met(self, x: Scalar, depth: Scalar, along: float) -> Scalar:
        """Depth below the axle (m) at which soil at x (m) is met: of the rim `late` further forward, less where it enters."""
        if isinstance(self.late, float) and self.late == 0.0:
            return depth
        ahead = self.late * (1.0 - math.exp(-(1.0 - along) / self.entry))
        return depth - ahead * (x + 0.5 * ahead) * (1.0 / self.radius)

    def _length(self, u_x: Scalar, u_y: Scalar) -> Scalar:
        return ca.sqrt(u_x * u_x + u_y * u_y + self.spread * self.spread + self.floor)

    def direction(self, u_x: Scalar, u_y: Scalar) -> tuple[Scalar, Scalar]:
        """Means over the width of u_x/|u| and u_y/|u|, by two Gauss points. Shear in soil that is sheared already follows these;
        in fresh soil the side that slides faster has also mobilised more, and |u| of the mean velocities is right."""
        along = across = 0.0
        for u in (u_x - self.spread, u_x + self.spread):
            share = 0.5 / ca.sqrt(u * u + u_y * u_y + self.floor)
            along, across = along + share * u, across + share * u_y
        return along, across

    def mean_y(self, x: Scalar, x_front: Scalar) -> Scalar:
        """Mean lateral sliding velocity of the soil now at x since it entered at x_front (m/s)."""
        ago = 0.5 * (x_front - x)
        return self.contact.v_y + self.contact.yaw_rate * (x + ago) - self._change * (0.5 * ago)

    def path(self, x: Scalar, x_front: Scalar, length: Scalar, along: float = 0.0) -> Scalar:
        """Shear path (m) of the soil now at x, which entered at x_front (m), by two Radau points.

        along: x over x_front; length: |u| at x, which is the first of the points (weight 1/4); the other (3/4) lies two thirds of
        the way to x_front, where the soil met the velocity of its time.
        """
        there = x + (2.0 / 3.0) * (x_front - x)
        mean = 0.25 * length + 0.75 * self._met_at(there, x, along + (2.0 / 3.0) * (1.0 - along))
        return mean * ((0.5 * (x_front - x)) * self.twice_per_v + self.extra)

    def left(self, rear: Scalar, front: Scalar) -> Scalar:
        """Shear path (m) of the soil that leaves at `rear` (m) and entered at `front` (m), by three Gauss points: |u| has a kink
        where the rim of a driven wheel moves with the soil."""
        way = front - rear
        mean = sum(share * self._met_at(rear + place * way, rear, max(2.0 * place - 1.0, 0.0)) for place, share in gauss_rule(3))
        return mean * (0.5 * way * self.twice_per_v + self.extra)

    def _met_at(self, x: Scalar, now: Scalar, along: float) -> Scalar:
        """|u| that the soil now at `now` (m) met at x (m)."""
        u_x = self.contact.v_x - self.contact.omega * self._met(x, rim_depth(x * x, self.radius), along)
        return self._length(u_x, self.contact.v_y + self.contact.yaw_rate * x - self._change * (0.5 * (x - now)))

    @property
    def _change(self) -> Scalar:
        """2 dv_y/v_x: twice the change of lateral velocity per length of path (1/s)."""
        return self.contact.dv_y * self.twice_per_v


def side_entry(path: Scalar, drift: Scalar) -> Scalar:
    """Mean of exp(-j/k) over the width, where part of the soil came in through the wheel's side.

    rho = |drift| is how far the wheel moved sideways, over its width, since this line entered; the share f = min(1, rho)
    of the width then holds soil whose path grows linearly from 0: (1 - f) exp(-J) + f (1 - exp(-J2))/J2 with
    J2 = J min(1, 1/rho). Smoothly, min(1, 1/rho) = q/(q + rho^3) with q = 1 + rho + rho^2, 1 % low at rho = 0.25.
    path: J, path over shear modulus; drift: sideways motion over width (1).
    """
    rho = ca.sqrt(drift * drift + 1e-12)
    q = 1.0 + rho * (1.0 + rho)
    ratio = q / (q + rho * rho * rho)
    return (1.0 - rho * ratio) * ca.exp(-path) + rho * (1.0 - ca.exp(-path * ratio)) / path
