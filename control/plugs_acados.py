"""The refined model in the form that acados takes: an AcadosModel where acados is installed, else a record of its fields."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import casadi as ca

from softsoil.codegen.c_source import check_c_name
from softsoil.control.ocp import Ocp
from softsoil.symbolic.model import Model


def to_acados(source: Ocp | Model, name: str = "softsoil") -> Any:
    """Fields x, xdot, u, p, f_expl_expr, f_impl_expr, labels and name, as `acados_template.AcadosModel` has them.

    source: an Ocp (states z, inputs w) or a Model (its states and external inputs); p holds the shared parameters and then,
    per stage, what the model's histories provide. Raises ValueError for a name that is no C identifier.

    Example:
        >>> import softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))
        >>> softsoil.to_acados(model).x_labels
        ['x', 'y', 'psi', 'u', 'v', 'omega_z']
    """
    check_c_name(name)
    if isinstance(source, Ocp):
        x, u, r, s = source.symbols()
        rates = source.dynamics()(x, u, r, s)[0]
        names = (source.z.names, source.w.names, (*source.s.names, *source.r.names))
    else:
        external = len(source.external)
        x, s = ca.SX.sym("x", len(source.x)), ca.SX.sym("s", len(source.p))
        u, r = ca.SX.sym("u", external), ca.SX.sym("r", len(source.u) - external)
        rates = source.ode()(x, ca.vertcat(u, r), s)
        names = (source.x.names, source.external.names, (*source.p.names, *source.u.names[external:]))
    model = _blank()
    xdot = ca.SX.sym("xdot", x.numel())
    model.name, model.x, model.xdot, model.u, model.p = name, x, xdot, u, ca.vertcat(s, r)
    model.f_expl_expr, model.f_impl_expr = rates, xdot - rates
    model.x_labels, model.u_labels, model.p_labels = (list(part) for part in names)
    return model


def _blank() -> Any:
    """acados's own class where it is installed."""
    try:
        from acados_template import AcadosModel
    except ImportError:
        return SimpleNamespace()
    return AcadosModel()
