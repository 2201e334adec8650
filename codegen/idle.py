"""Numbers that a vehicle declares and that do nothing in the model at hand."""

from __future__ import annotations

import casadi as ca

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
    model = bicycle(vehicle, declared.soil, declared.law, free=free)
    x, u, p = model.symbols()
    q = model.quantities(x, u, p)
    q |= {"memory": {name: ca.SX.sym(name) for name in model.cells.names}, "dt": 0.01}
    results = [q[f"d_{name}"] for name in model.x.names] + [q[f"y_{name}"] for name in model.y.names]
    for memory in model.memories:
        results += [*memory.advance(q).values(), *memory.start(q).values()]
    every = ca.vertcat(*map(ca.SX, results))
    return tuple(n.name for n in given if not ca.depends_on(every, p[model.p.index(n.name)]))
