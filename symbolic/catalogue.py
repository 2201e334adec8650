"""The effect catalogue by name, and models from a declared vehicle."""

from __future__ import annotations

from collections.abc import Mapping

from softsoil.symbolic.bicycle import bicycle
from softsoil.symbolic.effect import Effect, add_effect
from softsoil.symbolic.effects.body import (
    bank,
    grade,
    locked_differential,
    motion_resistance,
    payload,
    side_force,
    yaw_moment,
)
from softsoil.symbolic.effects.contact import aligning_moment, pressure_offset
from softsoil.symbolic.effects.delay import sensor_delay
from softsoil.symbolic.effects.lean import wheel_lean
from softsoil.symbolic.effects.sensor import gyro_bias, lever_arm, speed_scale
from softsoil.symbolic.effects.soil import bulldozing, rate_damping, relaxation, slip_sinkage, soil_change
from softsoil.symbolic.effects.steering import backlash, steering_delay, steering_gain, steering_lag, steering_offset
from softsoil.symbolic.effects.track import load_transfer, multipass
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import Vehicle
from softsoil.symbolic.wheel import ForceLaw


def catalogue(vehicle: Vehicle) -> dict[str, Effect]:
    """Every known effect by name, sized for the vehicle.
    Example: "payload_mass" in softsoil.catalogue(softsoil.load_vehicle("paper"))["payload"].parameters.names
    """
    effects = (
        multipass(vehicle.wheelbase), load_transfer(), wheel_lean(), aligning_moment(), pressure_offset(), rate_damping(),
        bulldozing(), slip_sinkage(), motion_resistance(), steering_lag(), steering_delay(), steering_offset(), steering_gain(),
        backlash(), relaxation(), bank(), grade(), side_force(), payload(), yaw_moment(), locked_differential(), soil_change(),
        gyro_bias(), lever_arm(), speed_scale(), sensor_delay(),
    )  # fmt: skip
    return {effect.name: effect for effect in effects}


def declared_model(
    vehicle: Vehicle,
    soil: Soil,
    law: ForceLaw | str = "turn_slip",
    effects: Mapping[str, Mapping[str, float]] | None = None,
    free: Layout = Layout(),  # noqa: B008
) -> Model:
    """The bicycle model of a vehicle on a soil, with the vehicle's declared effects (or the given ones).

    effects: name -> parameters, in place of the vehicle's own; {} gives the paper's structure.
    free: numbers of the vehicle that become parameters of the model.
    Raises ValueError for an effect that the catalogue lacks, KeyError for a parameter that the effect lacks.
    Example: softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay")).x.names[:3] == ("x", "y", "psi")
    """
    known = catalogue(vehicle)
    model = bicycle(vehicle, soil, law, free)
    for name, values in (vehicle.effects if effects is None else effects).items():
        if name not in known:
            raise ValueError(f"effects: expected names of {', '.join(known)}; found {name!r}")
        model = add_effect(model, known[name], values)
    return model
