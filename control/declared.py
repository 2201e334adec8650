"""The declaration that a controller predicts with."""

from __future__ import annotations

from softsoil.declaration.handed import check_declaration
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.catalogue import catalogue


def for_control(declared: Declaration) -> Declaration:
    """`declared`, with the effects that a controller's model needs at least where its vehicle declares none (`for_control` of the
    effects). Raises TypeError for what is no declaration."""
    check_declaration("controller", declared)
    if declared.vehicle.effects:
        return declared
    least = {name: e.for_control for name, e in catalogue(declared.vehicle).items() if e.for_control}
    return declared.with_effects(least)
