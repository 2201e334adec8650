"""Numbers that a vehicle declares and that do nothing in the model at hand."""

from __future__ import annotations

from softsoil.declaration.ground import idle
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import NUMBERS


def idle_numbers(declared: Declaration) -> tuple[str, ...]:
    """Names of the vehicle's numbers, of those declared other than by default, on which neither rates nor outputs nor histories
    of the declared model depend: no effect that would use them is declared.
    """
    vehicle = declared.vehicle
    given = [n for n in NUMBERS if n.modelled and n.default is not None and getattr(vehicle, n.name) != n.default]
    free = Layout(tuple(Signal(n.name, n.unit, n.doc, getattr(vehicle, n.name), n.lower, n.upper) for n in given))
    return idle(bicycle(vehicle, declared.soil, declared.law, free=free), free.names)
