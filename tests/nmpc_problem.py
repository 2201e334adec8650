"""Small problems for the tests of solver and loop, so that their C is built once: few steps, few quadrature nodes."""

from functools import lru_cache

from drives import reference_vehicle
from softsoil.control.ocp import Ocp, OcpSettings
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.soil import CLAY, Soil

N = 20


@lru_cache(maxsize=1)
def small_ocp() -> Ocp:
    """The plain bicycle on clay, N = 20 steps of 0.1 s."""
    vehicle = reference_vehicle().with_(simulator={})
    model = nominal_bicycle(vehicle, CLAY, TurnSlip(front_nodes=2))
    return Ocp(model, vehicle, OcpSettings(steps=N, dt=0.1))


@lru_cache(maxsize=2)
def rut_ocp(soil: Soil = CLAY) -> Ocp:
    """The same with rear wheels in the ruts of the front ones, which keep histories."""
    vehicle = reference_vehicle().with_(effects={"multipass": {"kappa": 0.7}}, simulator={})
    return Ocp(bicycle(vehicle, soil, TurnSlip(front_nodes=2)), vehicle, OcpSettings(steps=N, dt=0.1))
