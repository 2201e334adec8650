"""A rubber wheel on hard ground behind the same interface as the soil laws: friction and a tread that shears before it slides.

A brush of contact length l on ground with friction mu = tan(phi): the tread carries mu sigma (1 - exp(-j/k)) along its way
j = x |v_y|/v_x, sigma even over the length (Janosi's law with the tread in place of the soil; smooth as Fiala's is not):
  F_y = -mu F_z [1 - (1 - exp(-J))/J] v_y/|v_y|,  J = l |v_y|/(k v_x);
cornering stiffness mu F_z l/(2 k), saturating at mu F_z. Of the soil, phi and k are used; nothing sinks, n has no meaning,
and wheel speed does not matter: longitudinal slip takes no share of the friction.
"""

from dataclasses import dataclass

import casadi as ca

from softsoil.symbolic.smooth import smooth_norm, smooth_positive
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import LOAD_WIDTH, Contact, Wheel, WheelForce

SLIP_WIDTH = 1e-3
"""Tangent of the slip angle below which the force is a straight line, smoothly."""


@dataclass(frozen=True)
class HardGround:
    """length_share: contact length over the wheel's radius (1); speed_floor: v_x is used as sqrt(v_x^2 + speed_floor^2) (m/s).

    Raises ValueError unless both are positive.
    """

    length_share: float = 0.5
    speed_floor: float = 0.1

    def __post_init__(self) -> None:
        for name in ("length_share", "speed_floor"):
            if not getattr(self, name) > 0:
                raise ValueError(f"hard_ground: expected {name} > 0, found {getattr(self, name)}")

    @property
    def name(self) -> str:
        """hard_ground."""
        return "hard_ground"

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel; see the module for the equation and softsoil.symbolic.wheel for conventions."""
        slip = contact.v_y / smooth_norm(contact.v_x, self.speed_floor, 0.0)
        size = smooth_norm(slip, 0.0, SLIP_WIDTH)
        length = self.length_share * wheel.radius
        sheared = length * size / soil.k
        share = 1.0 - (1.0 - ca.exp(-sheared)) / sheared
        load = smooth_positive(contact.load, LOAD_WIDTH)
        f_y = -ca.tan(soil.phi) * load * share * slip / size
        return WheelForce(f_x=0.0, f_y=f_y, m_y=0.0, m_z=0.0, sinkage=0.0, exit_path=0.0)
