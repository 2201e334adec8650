"""A model's histories (ruts, delays) along states that are known, for many parameter sets at once.

States that no sensor measures, as forces that build up, run along the known ones as histories do: what is carried from row to row
is (those states, histories).
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.discretize import discretize, follow_memory
from softsoil.codegen.step_loop import PathLoop
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]
KNOWN = len(STATE_CHANNELS)
"""States of a model that logs measure, its first ones."""


def history_loop(model: Model, dt: float, beside: ca.Function | None = None) -> PathLoop:
    """The loop over what is carried, compiled for samples of dt (s); of the states x only the known ones are read.

    beside: [x, u, p] -> [y] of the full inputs, SX: what is to be known along the states beside the histories, default nothing.
    """
    follow = follow_memory(model, dt)
    known, m, external, p = (ca.SX.sym(follow.name_in(i), follow.size1_in(i)) for i in range(follow.n_in()))
    more = ca.SX.sym("more", len(model.x) - KNOWN)
    x = ca.vertcat(known[:KNOWN], more)
    following, full = follow(x, m, external, p)
    y = beside(x, full, p) if beside is not None else ca.SX(0, 1)
    later = discretize(model, dt)(x, full, p)[KNOWN:] if len(model.x) > KNOWN else ca.SX(0, 1)
    carried, after = ca.vertcat(more, m), ca.vertcat(later, following)
    return PathLoop(ca.Function("history_step", [known, carried, external, p], ca.cse([after, y])))


def first_carried(model: Model, start: ca.Function, x: Array, u: Array, sets: Array) -> Array:
    """(K, n) what is carried first, at the states x (n_x,) and inputs u (n_u,), for parameters sets (K, n_p): other states at
    their nominal values, histories as at a standing `start`."""
    more = model.x.nominal[KNOWN:]
    return np.array([np.concatenate([more, start(x, u, p).full()[:, 0]]) for p in sets]).reshape(len(sets), -1)


def parted(model: Model, carried: Array) -> tuple[Array, Array]:
    """The states (..., n_x - 6) that logs do not measure, and the histories (..., n_m), of what is carried."""
    count = len(model.x) - KNOWN
    return carried[..., :count], carried[..., count:]
