"""Soil pushed aside by the wheels' side walls."""

from dataclasses import replace

from softsoil.symbolic.bicycle import radius_of
from softsoil.symbolic.effect import Corner, Correction, Effect, Layout, Signal, Vehicle, each_wheel
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.side_wall import Wall, side_wall

READS = (
    "radius", "radius_rear", "wheel.force.sinkage", "wheel.soil.c", "wheel.soil.phi", "wheel.contact.v_x",
    "wheel.contact.v_y", "wheel.contact.omega",
)  # fmt: skip


def effect(vehicle: Vehicle) -> Effect:
    """Passive earth pressure on each wheel's side wall, `side_wall`: the law that the single-wheel tests in sand gave."""
    return Effect(
        name="bulldozing",
        doc="soil pushed aside by the wheel's side wall",
        kind="soil",
        reference="Hegedus; Ishigami 2007; passive earth pressure after Lancellotta 2002",
        parameters=Layout.of(Signal("soil_density", "N/m^3", "unit weight of the soil", 0.0, 0.0, 25e3, spread=2e4)),
        typical={"soil_density": 8e3},
        corrections={"forces": Correction(each_wheel(_compute), reads=READS, adds=("wheel.force.f_y",))},
        signatures=("cornering slope",),
        separates="slow driving at large slip angles",
        rests_on=("v", "omega_z"),
    )


def _compute(q: Quantities, corner: Corner) -> Corner:
    force, wall = corner.force, Wall(q["soil_density"])
    aside = side_wall(wall, corner.soil, radius_of(q, corner), corner.contact, force.sinkage)  # type: ignore
    return corner.with_(force=replace(force, f_y=force.f_y + aside))  # type: ignore
