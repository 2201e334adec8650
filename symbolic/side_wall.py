"""Soil pushed aside by the side wall of a wheel: passive earth pressure, shared by the single-wheel law and the vehicle.

A wheel that moves at the slip angle alpha ploughs: its side wall, a blade of depth h and of the chord that the sunken wheel
cuts out of the soil, drives soil up and aside until the soil fails in passive shear. Per wall, against v_y:
  F = [gamma/2 H^2 K_p + 2 c H sqrt(K_p)] (L + H/3) |v_y|/v
  H = h (1 + heap)       the soil that was pushed out stands on the wall as a heap, `heap` sinkages high;
  L = 2 sqrt(h (2r - h))  the chord, at most the diameter; H/3 more for the wedge that spreads to both sides (Blum 1932);
  |v_y|/v = sin(alpha)    what the wall shows to the direction of motion: the projected area h L sin(alpha);
  K_p(phi, d)             Lancellotta (2002), exact lower bound of plasticity for a rough wall, d the friction on the wall that
                          still holds the rising soil down: a wall that spins slides along its own rim, and friction
                          follows the sliding: d = wall_friction phi v/sqrt(v^2 + (r omega)^2).
Nothing here knows the wheel's size or the soil but by r, h, gamma, c, phi: grousers come in as a larger radius.
"""

from dataclasses import dataclass

import casadi as ca

from softsoil.symbolic.smooth import Scalar, held, smooth_norm
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact

WALL_FRICTION = 2.0 / 3.0
"""Friction angle of soil on the wall over phi: the usual value for steel on sand."""
HEAP = 0.7
"""Height of the heap over the sinkage: as fitted on the sand of `softsoil case cmu`, where held-out angles give 0.6 to 0.75."""
STANDSTILL = 0.05
"""m/s below which the wall of a vehicle's wheel stops pushing, smoothly."""


@dataclass(frozen=True)
class Wall:
    """What a side wall pushes against.

    unit_weight: gamma of the soil (N/m^3), 0: no such force; heap: its height over the sinkage (1);
    wall_friction: friction angle on the wall over phi (1, below 1); standstill: speed below which the force fades (m/s), to
    be set far below the speed of a slow laboratory wheel. Floats or CasADi scalars.
    """

    unit_weight: Scalar
    heap: Scalar = HEAP
    wall_friction: Scalar = WALL_FRICTION
    standstill: float = STANDSTILL


def passive_pressure(phi: Scalar, delta: Scalar) -> Scalar:
    """K_p, horizontal, of a rough vertical wall (Lancellotta 2002, eq. (15)); delta: wall friction (rad), |delta| < phi (rad).

    K_p = cos d/(1 - sin phi) (cos d + sqrt(sin^2 phi - sin^2 d)) exp(2 theta tan phi), 2 theta = asin(sin d/sin phi) + d;
    for a smooth wall Rankine's (1 + sin phi)/(1 - sin phi).
    """
    sin, sin_d, cos_d = ca.sin(phi) + 1e-9, ca.sin(delta), ca.cos(delta)
    twice_theta = ca.asin(sin_d / sin) + delta
    root = ca.sqrt(sin * sin - sin_d * sin_d)
    return cos_d / (1.0 - sin) * (cos_d + root) * ca.exp(twice_theta * ca.tan(phi))


def side_wall(wall: Wall, soil: Soil, radius: Scalar, contact: Contact, sinkage: Scalar) -> Scalar:
    """F_y of the soil on the side wall of a wheel (N), in the wheel frame; see the module for the equation.

    radius: of the wheel with its grousers (m); sinkage: h (m).
    """
    speed = smooth_norm(contact.v_x, contact.v_y, wall.standstill)
    share = speed / smooth_norm(speed, radius * contact.omega, wall.standstill)
    k_p = passive_pressure(soil.phi, wall.wall_friction * share * soil.phi)
    # No chord is longer than the diameter, no heap higher than the wheel.
    sunk = held(sinkage, radius)
    length = 2.0 * ca.sqrt(sunk * (2.0 * radius - sunk))
    height = held(sinkage * (1.0 + wall.heap), 2.0 * radius, 0.01)
    # Cohesion comes in with the weight: a wall against weightless soil is no wall, the effect is absent.
    present = wall.unit_weight / smooth_norm(wall.unit_weight, 0.0, 1e3)
    pressure = 0.5 * wall.unit_weight * height * height * k_p + 2.0 * present * soil.c * height * ca.sqrt(k_p)
    return -pressure * (length + height / 3.0) * contact.v_y / speed
