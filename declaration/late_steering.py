"""How late a vehicle's declared effects have its road wheels follow `steer`: what clocks of its logs may show."""

from __future__ import annotations

from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.vehicle import Vehicle

LATE = "late steering"
"""Signature of the effects that are meant, as their files give it."""


def late_steering(vehicle: Vehicle | None) -> float:
    """Seconds by which the road wheels follow `steer`, by the effects that the vehicle declares; 0 where it is not known."""
    if vehicle is None or not vehicle.effects:
        return 0.0
    known = catalogue(vehicle)
    return sum(
        float(vehicle.effects[name].get(signal.name, signal.nominal))
        for name, effect in known.items()
        if name in vehicle.effects and effect.kind == "steering" and LATE in effect.signatures
        for signal in effect.parameters
        if signal.unit == "s"
    )
