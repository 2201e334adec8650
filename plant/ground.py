"""What the plant's kernels take together: the soil with its memory, how it answers, and the motion of a wheel."""

from __future__ import annotations

from typing import Any, NamedTuple

from softsoil.plant.grid import RutGrid
from softsoil.plant.soil_field import SoilField


class Ground(NamedTuple):
    """The soil with its memory.

    keys, slots, count, nodes: arrays of a RutGrid with room for every tile that is touched before it reserves again;
    spacing (m): of the grid; field, meta: map of the soil.
    """

    keys: Any
    slots: Any
    count: Any
    nodes: Any
    spacing: float
    field: Any
    meta: Any


class Rules(NamedTuple):
    """How the contact is computed.

    reach: how far above the soil the footprint is searched (m); damped: 1 or 0 for the damping R; creep: speed (m/s) below
    which shear fades (0: none); cast: 1 for the reference's ray cast, 0 for the cylinder; own: layer of the wheel's own shear
    paths, 0 where all wheels share those of the ground.
    """

    reach: float
    damped: float
    creep: float
    cast: int
    own: int


class Motion(NamedTuple):
    """A wheel in world axes, each (3,): centre (m), axis (unit vector along the axle, leftward), velocity of the centre (m/s),
    rate: angular velocity of the wheel body, spin included (rad/s).
    """

    centre: Any
    axis: Any
    velocity: Any
    rate: Any


def ground_of(grid: RutGrid, soil: SoilField) -> Ground:
    """The arrays of a grid and a soil map as they stand: to be asked for again after the grid has reserved room."""
    return Ground(grid.keys, grid.slots, grid.count, grid.nodes, grid.spacing, soil.values, soil.meta)
