"""From continuous time to steps: forward Euler (the paper's) and the classical Runge-Kutta method."""

from __future__ import annotations

import casadi as ca

from softsoil.symbolic.model import Model, Quantities

METHODS = ("euler", "rk4")


def discretize(model: Model, dt: float, method: str = "euler", substeps: int = 1) -> ca.Function:
    """One step x+ = F(x, u, p) with the input held, as a CasADi function [x, u, p] -> [x_next].

    More than one substep are calls of one function, so that the C code grows by a line per substep, not by the model.

    dt: step (s, > 0); method: "euler" (paper, below eq. (y_update)) or "rk4"; substeps: steps inside dt.
    Raises ValueError for another method, a step that is not positive, or fewer than one substep.
    """
    if method not in METHODS:
        raise ValueError(f"discretize: expected method of {', '.join(METHODS)}; found {method!r}")
    if not dt > 0 or substeps < 1:
        raise ValueError(f"discretize: expected dt > 0 s and substeps >= 1; found {dt} and {substeps}")
    ode = model.ode()
    x, u, p = model.symbols()
    h = dt / substeps
    end = _euler(ode, x, u, p, h) if method == "euler" else _rk4(ode, x, u, p, h)
    step = ca.Function("step", [x, u, p], [ca.cse(end)], ["x", "u", "p"], ["x_next"])
    return step if substeps == 1 else _repeated(step, substeps)


def _repeated(step: ca.Function, count: int) -> ca.Function:
    x, u, p = (ca.MX.sym(step.name_in(i), step.size1_in(i)) for i in range(3))
    end = x
    for _ in range(count):
        end = step(end, u, p)
    return ca.Function("step", [x, u, p], [end], ["x", "u", "p"], ["x_next"])


def _euler(ode: ca.Function, x: ca.SX, u: ca.SX, p: ca.SX, h: float) -> ca.SX:
    return x + h * ode(x, u, p)


def _rk4(ode: ca.Function, x: ca.SX, u: ca.SX, p: ca.SX, h: float) -> ca.SX:
    k1 = ode(x, u, p)
    k2 = ode(x + h / 2 * k1, u, p)
    k3 = ode(x + h / 2 * k2, u, p)
    k4 = ode(x + h * k3, u, p)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def read_memory(model: Model) -> ca.Function:
    """CasADi function [x, u_external, p, m] -> [u]: the full input, with what the memories provide at its end."""
    x, _, p = model.symbols()
    external, m = ca.SX.sym("u_external", len(model.external)), ca.SX.sym("m", len(model.cells))
    q: Quantities = {name: x[i] for i, name in enumerate(model.x.names)}
    q |= {name: external[i] for i, name in enumerate(model.external.names)}
    q |= {name: p[i] for i, name in enumerate(model.p.names)}
    q["memory"] = {name: m[i] for i, name in enumerate(model.cells.names)}
    provided: list[ca.SX] = []
    for memory in model.memories:
        values = memory.read(q)
        provided += [values[name] for name in memory.provides.names]
    u = ca.vertcat(external, *provided)
    return ca.Function("read_memory", [x, external, p, m], [u], ["x", "u_external", "p", "m"], ["u"])


def advance_memory(model: Model, dt: float) -> ca.Function:
    """CasADi function [x, u, p, m] -> [m_next]: the histories one step of dt (s) later; u is the full input."""
    x, u, p = model.symbols()
    m = ca.SX.sym("m", len(model.cells))
    q = model.quantities(x, u, p) if model.memories else {}
    q["memory"] = {name: m[i] for i, name in enumerate(model.cells.names)}
    q["dt"] = dt
    following: list[ca.SX] = []
    for memory in model.memories:
        values = memory.advance(q)
        following += [values[name] for name in memory.cells.names]
    m_next = ca.vertcat(*following) if following else ca.SX(0, 1)
    return ca.Function("advance_memory", [x, u, p, m], [m_next], ["x", "u", "p", "m"], ["m_next"])


def start_memory(model: Model) -> ca.Function:
    """CasADi function [x, u_external, p] -> [m]: the histories at a standing start."""
    x, u, p = model.symbols()
    q = model.quantities(x, u, p) if model.memories else {}
    first: list[ca.SX] = []
    for memory in model.memories:
        values = memory.start(q)
        first += [ca.SX(values[name]) for name in memory.cells.names]
    external = ca.SX.sym("u_external", len(model.external))
    provided = model.u.nominal[len(model.external) :]
    cells = ca.Function("cells", [x, u, p], [ca.vertcat(ca.SX(0, 1), *first)])
    m = cells(x, ca.vertcat(external, provided), p)
    return ca.Function("start_memory", [x, external, p], [m], ["x", "u_external", "p"], ["m"])


def step_with_memory(model: Model, dt: float, method: str = "euler", substeps: int = 1) -> ca.Function:
    """CasADi function [x, m, u_external, p] -> [x_next, m_next]: one step, histories rolled forward with it."""
    step, read, advance = discretize(model, dt, method, substeps), read_memory(model), advance_memory(model, dt)
    names = ["x", "m", "u_external", "p"], ["x_next", "m_next"]
    sizes = (len(model.x), len(model.cells), len(model.external), len(model.p))
    if substeps > 1:
        state, cells, inputs, values = (ca.MX.sym(name, size) for name, size in zip(names[0], sizes, strict=True))
        full = read(state, inputs, values, cells)
        following = [step(state, full, values), advance(state, full, values, cells)]
        return ca.Function("rollout_step", [state, cells, inputs, values], following, *names)
    x, m, external, p = (ca.SX.sym(name, size) for name, size in zip(names[0], sizes, strict=True))
    u = read(x, external, p, m)
    # Step and histories share the whole chain: without common subexpressions it would be computed twice.
    return ca.Function("rollout_step", [x, m, external, p], ca.cse([step(x, u, p), advance(x, u, p, m)]), *names)


def follow_memory(model: Model, dt: float) -> ca.Function:
    """CasADi function [x, m, u_external, p] -> [m_next, u]: histories rolled forward by dt (s) along known states, and the full
    input that they are read into."""
    x, _, p = model.symbols()
    m, external = ca.SX.sym("m", len(model.cells)), ca.SX.sym("u_external", len(model.external))
    full = read_memory(model)(x, external, p, m)
    following = advance_memory(model, dt)(x, full, p, m)
    names = ["x", "m", "u_external", "p"], ["m_next", "u"]
    return ca.Function("follow_memory", [x, m, external, p], ca.cse([following, full]), *names)
