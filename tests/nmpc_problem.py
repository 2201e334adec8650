"""One small problem for the tests of solver and loop, so that its C is built once: the plain bicycle, few quadrature nodes."""

from functools import lru_cache

from drives import reference_vehicle
from softsoil.control.ocp import Ocp, OcpSettings
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.soil import CLAY

N = 20


@lru_cache(maxsize=1)
def small_ocp() -> Ocp:
    """N = 20 steps of 0.1 s."""
    model = nominal_bicycle(reference_vehicle(), CLAY, TurnSlip(front_nodes=2))
    return Ocp(model, reference_vehicle(), OcpSettings(steps=N, dt=0.1))
