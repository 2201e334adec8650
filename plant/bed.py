"""A bed of soil and one wheel at a time: the contact model by itself, for tests, figures and teaching."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.plant.contact import REACH, tiles_within_reach, wheel_contact
from softsoil.plant.grid import RutGrid
from softsoil.plant.ground import Motion, Rules, ground_of
from softsoil.plant.soil_field import SoilField
from softsoil.symbolic.soil import Soil

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Touch:
    """What the soil did to the wheel in one step: force (3,) N, moment about the wheel centre (3,) N m, sinkage (m)."""

    force: Array
    moment: Array
    sinkage: float


class SoilBed:
    """Deformable soil with its memory.

    soil: a Soil or SoilField; spacing: of the grid (m); damping: with the soil's R; creep: speed below which shear fades;
    cast: find the wheel as the reference simulator does (`softsoil.plant.reference.raycast`).
    """

    def __init__(
        self,
        soil: Soil | SoilField,
        spacing: float = 0.03,
        *,
        damping: bool = True,
        creep: float = 0.0,
        cast: bool = False,
    ) -> None:
        self.field = SoilField.uniform(soil) if isinstance(soil, Soil) else soil
        self.grid = RutGrid(spacing)
        self.rules = Rules(REACH, float(damping), float(creep), int(cast), 0)

    def touch(
        self,
        centre: ArrayLike,
        *,
        axis: ArrayLike = (0.0, 1.0, 0.0),
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        rate: ArrayLike = (0.0, 0.0, 0.0),
        radius: float = 0.330229,
        width: float = 0.2121,
        dt: float = 0.002,
    ) -> Touch:
        """One step of dt (s) with the wheel where it is: centre (m), axle direction, velocity, angular velocity (3,)."""
        self.grid.reserve(tiles_within_reach(radius, width, self.grid.spacing))
        force, moment = np.zeros(3), np.zeros(3)
        motion = Motion(*(np.array(a, dtype=float) for a in (centre, axis, velocity, rate)))
        ground = ground_of(self.grid, self.field)
        sinkage = wheel_contact(ground, 0, 0, self.rules, motion, float(radius), float(width), float(dt), force, moment)
        return Touch(force, moment, sinkage)
