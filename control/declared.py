"""The declaration that a controller predicts with."""

from __future__ import annotations

from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.declaration import Declaration


def for_control(declared: Declaration) -> Declaration:
    """`declared`, with the effects that a controller's model needs at least where its vehicle declares none (`for_control` of the
    effects)."""
    if declared.vehicle.effects:
        return declared
    least = {name: e.for_control for name, e in catalogue(declared.vehicle).items() if e.for_control}
    return declared.with_effects(least)
