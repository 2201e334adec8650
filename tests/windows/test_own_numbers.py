"""Numbers of a vehicle, and a load, as parameters: the same model at their declared values, another vehicle's at others."""

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.windows.own_numbers import load_of, with_load, with_own_numbers

NAMES = ("yaw_inertia", "track_rear", "kappa", "n_f", "no_such_number")


def rates(model, **values):
    x = model.x.pack(u=5.0, v=0.2, omega_z=0.4)
    u = model.u.pack(steer=0.2, a_x=0.3, omega_fl=15.0, omega_fr=15.5, omega_rl=15.2, omega_rr=15.1)
    return model.ode()(x, u, model.p.pack(**values)).full().ravel()


def test_declared_values_change_nothing_and_effects_stay():
    model = bicycle(reference_vehicle(), CLAY)
    free = with_own_numbers(model, NAMES)
    assert {*free.p.names} - {*model.p.names} == {"yaw_inertia", "track_rear"}
    assert free.effects == model.effects and model.effects
    assert rates(free) == pytest.approx(rates(model), rel=1e-12)
    assert with_own_numbers(model, ("kappa",)).p == model.p


@pytest.mark.parametrize("name, value", [("yaw_inertia", 2500.0), ("track_rear", 1.4)])
def test_another_value_is_another_vehicle(name, value):
    vehicle = reference_vehicle()
    free = rates(with_own_numbers(bicycle(vehicle, CLAY), NAMES), **{name: value})
    assert free == pytest.approx(rates(bicycle(vehicle.with_(**{name: value}), CLAY)), rel=1e-12)
    assert not np.allclose(free, rates(bicycle(vehicle, CLAY)))


def test_no_load_changes_nothing_and_another_is_the_declared_effect():
    vehicle = reference_vehicle()
    load = load_of(vehicle)
    mass, place = load.parameters.names
    free = with_load(with_own_numbers(bicycle(vehicle, CLAY), NAMES))
    assert rates(free) == pytest.approx(rates(bicycle(vehicle, CLAY)), rel=1e-12)
    declared = {load.name: {mass: 200.0, place: free.p[place].nominal}}
    loaded = bicycle(vehicle.with_(effects={**vehicle.effects, **declared}), CLAY)
    assert rates(free, **{mass: 200.0}) == pytest.approx(rates(loaded), rel=1e-12)
    assert not np.allclose(rates(loaded), rates(free))
    assert with_load(loaded) is loaded
