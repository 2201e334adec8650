"""A force law refined for wheels that slide and plough: any law, the side wall's bulldozing, and sinkage that grows with sliding.

A wheel that slides sinks deeper than one that rolls (Vasilev; Lyasko 2010 give factors in the slip alone). Two mechanisms,
with v the speed of the wheel centre, u the sliding velocity of the rim's lowest point, r omega the rim speed:
  h = h_0 (1 + shear q)(1 + push p^power)
  q = |u|/(|u| + v)                          share of the rim's motion that shears the soil and carries it off;
  p = 1 - (v_x/v) min(r omega, v)/v          share of the way that the wheel does not roll over: soil there is pushed
                                            ahead instead of being pressed down, and carries nothing.
p is 0 for a wheel that rolls straight on, 1 for one that is locked or driven sideways. h_0 is the base law's sinkage. The
friction below the wheel stays the base law's: it carries the load at any sinkage.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import casadi as ca

from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.side_wall import STANDSTILL, Wall, side_wall
from softsoil.symbolic.smooth import Scalar, smooth_min, smooth_norm, smooth_positive
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact, ForceLaw, Wheel, WheelForce


@dataclass(frozen=True)
class Digging:
    """How sliding deepens the sinkage: shear, push, power (1) as in the module, push = shear = 0: not at all;
    standstill: speed below which it fades (m/s), as of softsoil.symbolic.side_wall.Wall.
    """

    shear: Scalar = 0.0
    push: Scalar = 0.0
    power: Scalar = 2.0
    standstill: float = STANDSTILL

    def factor(self, wheel: Wheel, contact: Contact) -> Scalar:
        """h/h_0."""
        speed = smooth_norm(contact.v_x, contact.v_y, self.standstill)
        rim = wheel.radius * contact.omega
        sliding = smooth_norm(contact.v_x - rim, contact.v_y, 1e-3 * self.standstill)
        sheared = sliding / (sliding + speed)
        rolled = smooth_min(rim, speed, 1e-2 * self.standstill) / speed
        pushed = smooth_positive(1.0 - contact.v_x / speed * rolled, 1e-3)
        return (1.0 + self.shear * sheared) * (1.0 + self.push * ca.exp(self.power * ca.log(pushed)))


@dataclass(frozen=True)
class Ploughing:
    """`base`, with the side wall's force and the sinkage of a sliding wheel; neutral where unit weight and digging are 0.

    base: the law below the wheel; wall: what the side wall pushes; digging: how sliding deepens the sinkage.
    """

    base: ForceLaw = field(default_factory=TurnSlip)
    wall: Wall = field(default_factory=lambda: Wall(0.0))
    digging: Digging = field(default_factory=Digging)

    @property
    def name(self) -> str:
        """The base law's name with _ploughing."""
        return f"{self.base.name}_ploughing"

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel; see the module for the equations and softsoil.symbolic.wheel for conventions."""
        force = self.base(soil, wheel, contact)
        sinkage = force.sinkage * self.digging.factor(wheel, contact)
        aside = side_wall(self.wall, soil, wheel.radius, contact, sinkage)
        return replace(force, f_y=force.f_y + aside, sinkage=sinkage)
