"""The declaration that a controller predicts with."""

from __future__ import annotations

from softsoil.symbolic.declaration import Declaration

LEAST_EFFECTS = {"multipass": {"kappa": 1.0}, "load_transfer": {"transfer_height": 0.74, "roll_sweep": 0.55}}
"""Effects that a controller's model carries where its vehicle declares none."""


def for_control(declared: Declaration) -> Declaration:
    """`declared`, with LEAST_EFFECTS where its vehicle declares no effects."""
    return declared if declared.vehicle.effects else declared.with_effects(LEAST_EFFECTS)
