"""What the C library knows of the vehicle's numbers, where its file states their errors."""

from __future__ import annotations

import numpy as np

from softsoil.codegen.c_library.parts import take_apart
from softsoil.codegen.c_library.vehicle import VehicleNumbers
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.changed_vehicle import HEAVIEST, LIGHTEST
from softsoil.estimator.promote import promote_parameters
from softsoil.estimator.strain import MOST, STEERING
from softsoil.estimator.terrain import terrain_model
from softsoil.estimator.tuning import Tuning
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.wheel import ForceLaw
from softsoil.windows.free_starts import SUBSTEPS, joint_prior
from softsoil.windows.own_numbers import (
    load_of,
    stated_error,
    steering_scale_of,
    with_load,
    with_own_numbers,
    with_steering_scale,
)


def vehicle_numbers(declared: Declaration, promote: tuple[str, ...] = ()) -> VehicleNumbers | None:
    """Of the declared vehicle; None where its file states no errors of them, or where a load is estimated as a state.

    promote: further parameters that the library's filter estimates.
    """
    vehicle = declared.vehicle
    error, load = stated_error(vehicle), load_of(vehicle).parameters[0].name
    scale = steering_scale_of(vehicle).parameters[0].name
    if error is None or {load, scale} & {*promote}:
        return None

    def build(law: ForceLaw) -> Model:
        built = bicycle(vehicle, declared.soil, law)
        tied = bool(built.effects)
        model = terrain_model(with_steering_scale(with_load(with_own_numbers(built, error.names))), tied=tied)
        return promote_parameters(model, *promote) if promote else model

    parts = take_apart(build, declared.force_law())
    p = parts.model.p
    prior = joint_prior(error, parts.model, {name: float(p[name].nominal) for name in error.names if name in p})
    return VehicleNumbers(
        parts=parts, names=prior.names, std=np.linalg.norm(np.linalg.pinv(prior.root), axis=1),
        information=prior.root.T @ prior.root, load=load, mass=vehicle.mass, load_known=MOST,
        load_std=vehicle.uncertainty.get(load, 0.0) / vehicle.mass, loads=(LIGHTEST, HEAVIEST), substeps=SUBSTEPS,
        best_sensor=Tuning().sensor_floor, scale=scale, ratio=float(p[scale].nominal), scale_known=STEERING,
    )  # fmt: skip
