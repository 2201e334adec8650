"""The refined model and its control problem in the form that acados takes.

AcadosModel and AcadosOcp where acados_template is installed, else records of their fields.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from softsoil.codegen.c_source import check_c_name
from softsoil.control.nmpc_clearance import ABSENT
from softsoil.control.ocp import CIRCLES, OBSTACLE, REFERENCE, Ocp
from softsoil.symbolic.model import Model

UNBOUNDED = 1e10
"""acados's own number for a bound that is none."""


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
    model = _blank("AcadosModel")
    xdot = ca.SX.sym("xdot", x.numel())
    model.name, model.x, model.xdot, model.u, model.p = name, x, xdot, u, ca.vertcat(s, r)
    model.f_expl_expr, model.f_impl_expr = rates, xdot - rates
    model.x_labels, model.u_labels, model.p_labels = (list(part) for part in names)
    return model


def to_acados_ocp(ocp: Ocp, name: str = "softsoil") -> Any:
    """The whole problem as `acados_template.AcadosOcp` has it: model, cost, constraints, solver_options, parameter_values.

    p, to be set at every stage: shared parameters, what histories provide, the reference (x, y, psi, u), and the obstacles
    (x, y, radius each); `model.p_labels` names them. acados multiplies the cost of a stage, slacks included, by its time step
    and leaves the last one as it is: external costs and slack prices are given accordingly. Soft: limits of steering angle and
    speed, clearances, reserve of lateral force; none of them at the first stage. One classical Runge-Kutta step an interval.
    Raises ValueError for a name that is no C identifier.
    """
    settings, weights, dt = ocp.settings, ocp.settings.weights, ocp.settings.dt
    model = to_acados(ocp, name)
    ref = ca.SX.sym("ref", len(REFERENCE))
    places = ca.SX.sym("obstacles", len(OBSTACLE), settings.obstacles)
    s, r = model.p[: len(ocp.s)], model.p[len(ocp.s) :]
    model.p = ca.vertcat(model.p, ref, ca.vec(places))
    model.p_labels += [f"ref_{label}" for label in REFERENCE.names]
    model.p_labels += [f"obstacle_{i}_{label}" for i in range(settings.obstacles) for label in OBSTACLE.names]
    cost, rest = ocp.cost(), ca.SX.zeros(len(ocp.w))
    model.cost_expr_ext_cost = cost(model.x, model.u, ref)
    model.cost_expr_ext_cost_e = weights.terminal * dt * cost(model.x, rest, ref)
    clear = ocp.clearance()
    gaps = [clear(model.x, places[:, i]) for i in range(settings.obstacles)]
    use = ocp.dynamics()(model.x, model.u, r, s)[1]
    reserve = [1.0 - settings.reserve - ca.sqrt(use**2 + 1e-4)] if ocp.bears else []
    model.con_h_expr = ca.vertcat(*gaps, *reserve) if gaps or reserve else ca.SX(0, 1)
    model.con_h_expr_e = ca.vertcat(*gaps) if gaps else ca.SX(0, 1)
    whole = _blank("AcadosOcp")
    for part in ("cost", "constraints", "solver_options"):
        if not hasattr(whole, part):
            setattr(whole, part, SimpleNamespace())
    whole.model = model
    obstacles = np.tile(ABSENT, settings.obstacles)
    whole.parameter_values = np.concatenate([ocp.s.nominal, np.zeros(len(ocp.r)), REFERENCE.nominal, obstacles])
    _costs(whole.cost, ocp, len(gaps) * CIRCLES, 2 * len(reserve))
    _constraints(whole.constraints, ocp, len(gaps) * CIRCLES, 2 * len(reserve))
    options = whole.solver_options
    options.N_horizon, options.tf = settings.steps, settings.steps * dt
    options.integrator_type, options.sim_method_num_stages, options.sim_method_num_steps = "ERK", 4, 1
    options.nlp_solver_type, options.hessian_approx, options.regularize_method = "SQP_RTI", "EXACT", "PROJECT"
    options.qp_solver = "PARTIAL_CONDENSING_HPIPM"
    return whole


def _costs(cost: Any, ocp: Ocp, gaps: int, reserves: int) -> None:
    weights, dt, boxes = ocp.settings.weights, ocp.settings.dt, len(ocp.state_box)
    cost.cost_type = cost.cost_type_0 = cost.cost_type_e = "EXTERNAL"
    for ending, count, scale in (("", boxes + gaps + reserves, 1.0), ("_e", boxes + gaps, dt)):
        for side in "lu":
            setattr(cost, f"z{side}{ending}", np.full(count, scale * weights.slack))
            setattr(cost, f"Z{side}{ending}", np.full(count, scale * weights.slack_squared))


def _constraints(constraints: Any, ocp: Ocp, gaps: int, reserves: int) -> None:
    boxes = [ocp.z.index(name) for name in ocp.state_box]
    limits = np.array(list(ocp.state_box.values()))
    constraints.x0 = ocp.z.nominal
    constraints.idxbu, constraints.lbu, constraints.ubu = np.arange(len(ocp.w)), ocp.w.lower, ocp.w.upper
    for ending, rows in (("", gaps + reserves), ("_e", gaps)):
        setattr(constraints, f"idxbx{ending}", np.array(boxes))
        setattr(constraints, f"lbx{ending}", limits[:, 0])
        setattr(constraints, f"ubx{ending}", limits[:, 1])
        setattr(constraints, f"idxsbx{ending}", np.arange(len(boxes)))
        setattr(constraints, f"lh{ending}", np.zeros(rows))
        setattr(constraints, f"uh{ending}", np.full(rows, UNBOUNDED))
        setattr(constraints, f"idxsh{ending}", np.arange(rows))


def _blank(kind: str) -> Any:
    """acados's own class where it is installed."""
    try:
        import acados_template
    except ImportError:
        return SimpleNamespace()
    return getattr(acados_template, kind)()
