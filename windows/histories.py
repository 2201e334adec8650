"""A model's histories (ruts, delays) along states that are known, for many parameter sets at once."""

from __future__ import annotations

import casadi as ca

from softsoil.codegen.discretize import follow_memory
from softsoil.codegen.step_loop import PathLoop
from softsoil.symbolic.model import Model


def history_loop(model: Model, dt: float, beside: ca.Function | None = None) -> PathLoop:
    """The loop, compiled for samples of dt (s).

    beside: [x, u, p] -> [y] of the full inputs, SX: what is to be known along the states beside the histories, default nothing.
    """
    follow = follow_memory(model, dt)
    x, m, external, p = (ca.SX.sym(follow.name_in(i), follow.size1_in(i)) for i in range(follow.n_in()))
    following, full = follow(x, m, external, p)
    y = beside(x, full, p) if beside is not None else ca.SX(0, 1)
    return PathLoop(ca.Function("history_step", [x, m, external, p], ca.cse([following, y])))
