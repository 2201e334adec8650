"""Numbers that a vehicle declares and that do nothing in the model at hand."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca

from softsoil.symbolic.declaration import Declaration
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.vehicle import NUMBERS


def idle_numbers(declared: Declaration) -> tuple[str, ...]:
    """Names of the vehicle's numbers, of those declared other than by default, on which neither rates nor outputs nor histories
    of the declared model depend: no effect that would use them is declared.
    """
    vehicle, model = declared.vehicle, declared.build()
    given = [n.name for n in NUMBERS if n.modelled and n.default is not None and getattr(vehicle, n.name) != n.default]
    symbols = {name: ca.SX.sym(name) for name in given}

    def free(compute: Callable) -> Callable:
        return lambda q: {**compute(q), **symbols}

    stages = tuple(replace(s, compute=free(s.compute)) if s.name == "vehicle" else s for s in model.stages)
    q: Quantities = replace(model, stages=stages).quantities(*model.symbols())
    q |= {"memory": {name: ca.SX.sym(name) for name in model.cells.names}, "dt": 0.01}
    results = [q[f"d_{name}"] for name in model.x.names] + [q[f"y_{name}"] for name in model.y.names]
    for memory in model.memories:
        results += [*memory.advance(q).values(), *memory.start(q).values()]
    every = ca.vertcat(*map(ca.SX, results))
    return tuple(name for name, symbol in symbols.items() if not ca.depends_on(every, symbol))
