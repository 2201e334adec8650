"""Soil that resists fast sinking by another amount than declared."""

from dataclasses import replace

from softsoil.symbolic.effect import Corner, Correction, Effect, Layout, Signal, Vehicle, each_wheel
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.smooth import smooth_positive


def effect(vehicle: Vehicle) -> Effect:
    """sigma += R omega X: another damping of the sinkage rate than the declared soil has."""
    return Effect(
        name="rate_damping",
        doc="soil that resists fast sinking by another amount than declared",
        kind="soil",
        reference="soil contact model: sigma -= R V_n",
        parameters=Layout.of(Signal("damping_change", "Pa s/m", "damping beyond the declared", 0.0, -3e4, 1e5, spread=3e4)),
        typical={"damping_change": -5e3},
        corrections={"contacts": Correction(each_wheel(_compute), sets=("wheel.soil.R",))},
        signatures=("cornering slope",),
        separates="the same manoeuvre at several speeds",
        rests_on=("u", "v", "omega_z"),
    )


def _compute(q: Quantities, corner: Corner) -> Corner:
    soil = corner.soil
    damping = soil.R + smooth_positive(soil.R + q["damping_change"], 1.0) - smooth_positive(soil.R, 1.0)  # type: ignore
    return corner.with_(soil=replace(soil, R=damping))  # type: ignore
