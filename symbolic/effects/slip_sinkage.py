"""Wheels that dig themselves in where they slip."""

from dataclasses import replace

import casadi as ca

from softsoil.symbolic.bicycle import radius_of
from softsoil.symbolic.effect import Corner, Correction, Effect, Layout, Signal, Vehicle, each_wheel
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.smooth import smooth_min, smooth_norm


def effect(vehicle: Vehicle) -> Effect:
    """A slipping wheel digs: the same pressure at h (1 + f |s|), hence k_eq/(1 + f |s|)^n; s over the faster, rim or travel."""
    return Effect(
        name="slip_sinkage",
        doc="a wheel that slips digs itself in",
        kind="soil",
        reference="Vasilev; Lyasko 2010: h (1 + s)/(1 - s/2) and like laws",
        parameters=Layout.of(Signal("slip_sinkage", "", "sinkage per unit slip", 0.0, 0.0, 10.0, spread=2)),
        typical={"slip_sinkage": 1.0},
        corrections={
            "contacts": Correction(
                each_wheel(_compute),
                reads=("radius", "radius_rear", "wheel.soil.n", "wheel.contact.v_x", "wheel.contact.omega"),
                scales=("wheel.soil.k_phi", "wheel.soil.k_c"),
            )
        },
        signatures=("cornering slope",),
        separates="strong throttle at a constant speed",
        rests_on=("u", "omega_fl", "omega_fr", "omega_rl", "omega_rr"),
    )


def _compute(q: Quantities, corner: Corner) -> Corner:
    contact, soil = corner.contact, corner.soil
    rolling = radius_of(q, corner) * contact.omega  # type: ignore[union-attr]
    v_x = contact.v_x  # type: ignore[union-attr]
    rim, travel = smooth_norm(rolling, 0.0, 0.1), smooth_norm(v_x, 0.0, 0.1)
    slip = ca.sqrt((rolling - v_x) ** 2 + 1e-4) / -smooth_min(-rim, -travel, 0.01)
    soften = ca.exp(-soil.n * ca.log(1.0 + q["slip_sinkage"] * slip))  # type: ignore[union-attr]
    return corner.with_(soil=replace(soil, k_phi=soil.k_phi * soften, k_c=soil.k_c * soften))  # type: ignore
