"""Numbers of a vehicle, a load and the steering's scale as parameters of its model, so that windows can move them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from softsoil.files.joint_error import JointError, independent_error
from softsoil.symbolic.bicycle import vehicle_quantities
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import Effect, add_effect
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import NUMBERS, Vehicle

MODELLED = {number.name: number for number in NUMBERS if number.modelled}
"""Numbers that a model reads, by name."""


def stated_error(vehicle: object) -> JointError | None:
    """What a vehicle's file states of the errors of its numbers, but that of a load: their joint error, else the standard
    deviations of its table [uncertainty], each for itself. None where it states neither, or those of effects alone, as `refine`
    writes them: of the vehicle itself that says nothing."""
    if not isinstance(vehicle, Vehicle):
        return None
    load = load_of(vehicle).parameters
    one_by_one = {name: std for name, std in vehicle.uncertainty.items() if name not in load}
    return vehicle.joint_error or (independent_error(one_by_one) if MODELLED.keys() & one_by_one.keys() else None)


def with_own_numbers(model: Model, names: Sequence[str]) -> Model:
    """The bicycle `model` with those of the named numbers as parameters, at their declared values, that are none yet.

    A name that no number of its vehicle has is left out. What the model says does not change.
    """
    vehicle = model.geometry
    free = [name for name in names if name in MODELLED and name not in model.p]
    values = {name: vehicle.rear_track if name == "track_rear" else float(getattr(vehicle, name)) for name in free}
    own = (*(name for name in model.p.names if name in MODELLED), *free)
    layout = Layout(tuple(Signal(name, MODELLED[name].unit, MODELLED[name].doc, value) for name, value in values.items()))
    stages = tuple(
        replace(s, compute=lambda q: vehicle_quantities(vehicle, {name: q[name] for name in own}))
        if s.name == "vehicle" and free else s
        for s in model.stages
    )  # fmt: skip
    return replace(model, p=model.p + layout, stages=stages)


def with_load(model: Model) -> Model:
    """The bicycle `model` with the mass of a load as a parameter: of the declared one, or of none at its typical place.

    What the model says does not change.
    """
    return _led_by_none(model, load_of(model.geometry))


def with_steering_scale(model: Model) -> Model:
    """The bicycle `model` with the ratio of road-wheel angle and `steer` as a parameter: the declared one, or 1.

    What the model says does not change.
    """
    return _led_by_none(model, steering_scale_of(model.geometry))


def _led_by_none(model: Model, effect: Effect) -> Model:
    """The model with an effect whose first parameter, at its nominal value, makes it nothing; as it is where that is declared."""
    if effect.name in model.effects:
        return model
    lead = effect.parameters[0]
    return add_effect(model, effect, {**effect.typical, lead.name: lead.nominal})


def steering_scale_of(vehicle: Vehicle) -> Effect:
    """The effect of another steering ratio than declared, whose parameter is that over the declared one."""
    return next(effect for effect in catalogue(vehicle).values() if effect.reference == "steering ratio")


def load_of(vehicle: Vehicle) -> Effect:
    """The effect of a load on a vehicle, which leads with its mass (kg)."""
    return next(effect for effect in catalogue(vehicle).values() if adds_mass(effect))


def adds_mass(effect: Effect) -> bool:
    """Whether an effect makes the vehicle heavier."""
    return "vehicle" in effect.corrections and "mass" in effect.corrections["vehicle"].adds
