"""The refined model in the form that do-mpc takes."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import casadi as ca

from softsoil.control.ocp import REFERENCE, Ocp
from softsoil.symbolic.model import Model


def to_do_mpc(source: Ocp | Model) -> Any:
    """A set-up `do_mpc.model.Model` of continuous time.

    source: an Ocp (states z, inputs w, wheel speeds following from the motion; its stage parameters and the path reference
    as time-varying parameters) or a Model (its states and external inputs; what histories provide as time-varying
    parameters). Parameters are do-mpc parameters under their names, so that n can be set at run time.
    Raises ValueError where do-mpc is not installed.

    Example:
        >>> import softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))
        >>> softsoil.to_do_mpc(model).x.keys()
        ['x', 'y', 'psi', 'u', 'v', 'omega_z']
    """
    do_mpc = _do_mpc()
    model = do_mpc.model.Model("continuous", "SX")
    states, inputs, stage, shared, rates = _parts(source)
    x = [model.set_variable("_x", name) for name in states]
    u = [model.set_variable("_u", name) for name in inputs]
    r = [model.set_variable("_tvp", name) for name in stage]
    s = [model.set_variable("_p", name) for name in shared]
    if isinstance(source, Ocp):
        for name in REFERENCE.names:
            model.set_variable("_tvp", f"ref_{name}")
    found = rates(*(ca.vertcat(*part) if part else ca.SX(0, 1) for part in (x, u, r, s)))
    for i, name in enumerate(states):
        model.set_rhs(name, found[i])
    model.setup()
    return model


def do_mpc_controller(ocp: Ocp, reference: Any, parameters: Any, settings: dict[str, Any] | None = None) -> Any:
    """A set-up do-mpc controller for the Ocp's tracking part with do-mpc's default settings (IPOPT, collocation).

    reference: (k, name) -> value of the path at step k, names of REFERENCE, asked at every solve; parameters (n_s,): shared
    parameters; settings: do-mpc settings over the defaults. Obstacles and the force reserve are left to the user.
    """
    do_mpc = _do_mpc()
    model = to_do_mpc(ocp)
    mpc = do_mpc.controller.MPC(model)
    n = ocp.settings.steps
    mpc.set_param(n_horizon=n, t_step=ocp.settings.dt, store_full_solution=False, n_robust=0, **(settings or {}))
    mpc.settings.supress_ipopt_output()
    z = ca.vertcat(*[model.x[name] for name in ocp.z.names])
    w = ca.vertcat(*[model.u[name] for name in ocp.w.names])
    ref = ca.vertcat(*[model.tvp[f"ref_{name}"] for name in REFERENCE.names])
    h, cost = ocp.settings.dt, ocp.cost()
    rest = ca.SX.zeros(len(ocp.w))
    mpc.set_objective(lterm=h * cost(z, w, ref), mterm=h * ocp.settings.weights.terminal * cost(z, rest, ref))
    for name in ocp.w.names:
        mpc.set_rterm(**{name: 0.0})
        mpc.bounds["lower", "_u", name], mpc.bounds["upper", "_u", name] = ocp.w[name].lower, ocp.w[name].upper
    for name, (low, high) in ocp.state_box.items():
        mpc.bounds["lower", "_x", name], mpc.bounds["upper", "_x", name] = low, high
    template = mpc.get_tvp_template()

    def varying(_: float) -> Any:
        for k in range(n + 1):
            for name in REFERENCE.names:
                template["_tvp", k, f"ref_{name}"] = reference(k, name)
        return template

    mpc.set_tvp_fun(varying)
    constant = mpc.get_p_template(1)
    constant["_p", 0] = parameters
    mpc.set_p_fun(lambda _: constant)
    mpc.setup()
    return mpc


def _parts(source: Ocp | Model) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...], tuple[str, ...], Any]:
    if isinstance(source, Ocp):
        dynamics = source.dynamics()
        names = (source.z.names, source.w.names, source.r.names, source.s.names)
        return *names, lambda x, u, r, s: dynamics(x, u, r, s)[0]
    provided = source.u.names[len(source.external) :]
    ode = source.ode()
    return (
        source.x.names, source.external.names, provided, source.p.names, lambda x, u, r, s: ode(x, ca.vertcat(u, r), s),
    )  # fmt: skip


def _do_mpc() -> ModuleType:
    try:
        import do_mpc
    except ImportError:
        raise ValueError("to_do_mpc: expected do-mpc to be installed (pip install do-mpc), found none") from None
    return do_mpc
