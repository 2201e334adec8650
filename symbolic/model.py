"""A model: named states, inputs, parameters and outputs, and the equations between them, as CasADi functions.

The equations are a chain of named stages. Each stage reads the quantities found so far and adds its own; an effect
(`softsoil.symbolic.effect`) corrects the quantities of a stage and never edits it. The chain ends with the rate `d_<state>` of
every state and the value `y_<output>` of every output.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from softsoil.symbolic.signals import Layout, Signal

Scalar = Any
Quantities = dict[str, Any]
"""Everything the chain has computed so far, by name."""
Compute = Callable[[Quantities], Mapping[str, Any]]


@dataclass(frozen=True)
class Stage:
    """One named step of the derivation; `compute` maps the quantities so far to the new ones."""

    name: str
    compute: Compute


@dataclass(frozen=True)
class Memory:
    """A history kept beside the states, so that sigma points and NMPC stay small.

    cells: its numbers; provides: the model inputs that it supplies; read: quantities (x, u, p and cells by name, under
    `memory`) -> provided inputs; advance: quantities of the whole chain (and `memory`, `dt`) -> next cells;
    start: quantities of the whole chain with nominal provided inputs -> first cells, as on a straight standing start.
    All are CasADi expressions of fixed size.
    """

    name: str
    cells: Layout
    provides: Layout
    read: Callable[[Quantities], Mapping[str, Scalar]]
    advance: Callable[[Quantities], Mapping[str, Scalar]]
    start: Callable[[Quantities], Mapping[str, Scalar]]


@dataclass(frozen=True)
class Model:
    """Continuous-time model xdot = f(x, u, p), y = g(x, u, p); argument order always (x, u, p).

    x, u, p, y: layouts of states, inputs, parameters, outputs; stages: the derivation in order; memories: histories whose
    provided signals are the last entries of u. Raises ValueError where one name stands for two quantities.
    Example: softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay")).ode().name_in() == ["x", "u", "p"]
    """

    name: str
    x: Layout
    u: Layout
    p: Layout
    y: Layout
    stages: tuple[Stage, ...]
    memories: tuple[Memory, ...] = ()
    effects: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _ = self.x + self.u + self.p  # raises where a name is taken twice
        provided = tuple(name for memory in self.memories for name in memory.provides.names)
        if provided and self.u.names[-len(provided) :] != provided:
            raise ValueError(f"model {self.name}: expected inputs to end with {provided}, found {self.u.names}")

    @classmethod
    def of(cls, name: str, x: Layout, u: Layout, p: Layout, y: Layout, rhs: Compute, output: Compute) -> Model:
        """A model in one stage: rhs returns the rate of each state by name, output the value of each output by name."""

        def compute(q: Quantities) -> Quantities:
            rates = {f"d_{key}": value for key, value in rhs(q).items()}
            return {**rates, **{f"y_{key}": value for key, value in output(q).items()}}

        return cls(name, x, u, p, y, (Stage("model", compute),))

    @property
    def external(self) -> Layout:
        """Inputs that the user supplies: u less what memories provide."""
        provided = [name for memory in self.memories for name in memory.provides.names]
        return self.u.without(*provided)

    @property
    def cells(self) -> Layout:
        """Layout of all memory cells."""
        return Layout(tuple(signal for memory in self.memories for signal in memory.cells))

    def quantities(self, x: ca.SX, u: ca.SX, p: ca.SX) -> Quantities:
        """All quantities of the chain for (n_x,), (n_u,), (n_p,) CasADi vectors."""
        q: Quantities = {}
        for layout, vector in ((self.x, x), (self.u, u), (self.p, p)):
            q.update({name: vector[i] for i, name in enumerate(layout.names)})
        for stage in self.stages:
            q.update(stage.compute(q))
        return q

    def ode(self) -> ca.Function:
        """CasADi function [x, u, p] -> [xdot]."""
        x, u, p = self.symbols()
        q = self.quantities(x, u, p)
        xdot = ca.vertcat(*[self._result(q, f"d_{name}") for name in self.x.names])
        return ca.Function("ode", [x, u, p], [xdot], ["x", "u", "p"], ["xdot"])

    def measurement(self) -> ca.Function:
        """CasADi function [x, u, p] -> [y]."""
        x, u, p = self.symbols()
        q = self.quantities(x, u, p)
        y = ca.vertcat(*[self._result(q, f"y_{name}") for name in self.y.names])
        return ca.Function("measurement", [x, u, p], [y], ["x", "u", "p"], ["y"])

    def probe(self, *names: str) -> ca.Function:
        """CasADi function [x, u, p] -> [values of the named quantities]; KeyError for one the chain does not compute."""
        x, u, p = self.symbols()
        q = self.quantities(x, u, p)
        values = ca.vertcat(*[self._result(q, name) for name in names])
        return ca.Function("probe", [x, u, p], [values], ["x", "u", "p"], ["values"])

    def symbols(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Fresh symbols (x, u, p)."""
        return ca.SX.sym("x", len(self.x)), ca.SX.sym("u", len(self.u)), ca.SX.sym("p", len(self.p))

    def _result(self, q: Quantities, name: str) -> Scalar:
        if name not in q:
            raise KeyError(f"model {self.name}: expected its stages to compute {name!r}; found {', '.join(sorted(q))}")
        return q[name]

    def correct(self, stage: str, compute: Compute) -> Model:
        """The model with `compute` applied to the quantities right after the named stage; ValueError for no such stage."""
        names = [s.name for s in self.stages]
        if stage not in names:
            raise ValueError(f"model {self.name}: expected a stage of {', '.join(names)}; found {stage!r}")
        at = names.index(stage)
        before = self.stages[at].compute

        def corrected(q: Quantities) -> Quantities:
            first = dict(before(q))
            return {**first, **compute({**q, **first})}

        return replace(self, stages=(*self.stages[:at], Stage(stage, corrected), *self.stages[at + 1 :]))


def promote_parameters(model: Model, *names: str) -> Model:
    """The model with the named parameters as states of zero rate (paper, eq. (bicycle_est)).

    names: parameters, appended to x in this order with their bounds. Raises KeyError for a name that is not a parameter.
    """
    promoted = Layout(tuple(model.p[name] for name in names))
    still = Stage("promoted", lambda q: {f"d_{name}": 0.0 for name in names})
    return replace(model, x=model.x + promoted, p=model.p.without(*names), stages=(*model.stages, still))


def tie_parameters(model: Model, signal: Signal, *names: str) -> Model:
    """The model with one parameter in the place of several, e.g. n for n_f and n_r.

    Raises KeyError for a name that is not a parameter.
    """
    remaining = model.p.without(*names)
    spread = Stage(f"tie_{signal.name}", lambda q: dict.fromkeys(names, q[signal.name]))
    return replace(model, p=Layout((signal, *remaining)), stages=(spread, *model.stages))


def with_nominal(model: Model, **values: float) -> Model:
    """The model with other nominal parameter values; KeyError for a name that is not a parameter."""
    return replace(model, p=model.p.with_nominal(**values))
