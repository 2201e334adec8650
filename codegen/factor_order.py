"""Order of the states in a covariance's factor: those that forces depend on first, so that the others share the centre's forces.

Sigma points depend on the factor: another order is another (equally good) filter, so that every filter of a model takes this one.
"""

from __future__ import annotations

import casadi as ca

from softsoil.symbolic.model import Model

POSE = ("x", "y", "psi")
"""States that the others drive and that, on level ground, drive none."""


def factor_order(model: Model) -> tuple[int, ...]:
    """Indices of the states: all but the pose and what of it drives them, then the rest, each group in the model's order."""
    x, u, p = model.symbols()
    q = model.quantities(x, u, p)
    rates = ca.vertcat(*[ca.SX(q[f"d_{name}"]) for name in model.x.names if name not in POSE], 0)
    drives = [name not in POSE or bool(ca.depends_on(rates, x[i])) for i, name in enumerate(model.x.names)]
    every = range(len(drives))
    return (*(i for i in every if drives[i]), *(i for i in every if not drives[i]))
