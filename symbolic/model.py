"""A model: named states, inputs, parameters and outputs, and the equations between them, as CasADi functions.

The equations are a chain of named stages. Each stage reads the quantities computed so far and adds its own; an effect
(`softsoil.symbolic.effect`) corrects the quantities of a stage and never edits it. The chain ends with the rate `d_<state>` of
every state and the value `y_<output>` of every output.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import is_
from typing import Any

import casadi as ca

from softsoil.files.joint_error import JointError
from softsoil.symbolic.signals import Layout

Scalar = Any
Quantities = dict[str, Any]
"""Everything the chain has computed so far, by name."""
Compute = Callable[[Quantities], Mapping[str, Any]]


@dataclass(frozen=True)
class Correction:
    """What an effect changes right after a stage.

    compute: quantities so far -> changed and new ones; reads: quantities whose final value it needs; adds, scales: those that it
    adds to or multiplies, by what does not depend on them; sets: those that it makes anew or replaces. A part of each wheel is
    named wheel.<part>, e.g. wheel.soil.n. effect: name of the effect, empty for a probe, which sees what all effects leave.
    """

    compute: Compute
    reads: tuple[str, ...] = ()
    adds: tuple[str, ...] = ()
    scales: tuple[str, ...] = ()
    sets: tuple[str, ...] = ()
    effect: str = ""

    @property
    def writes(self) -> frozenset[str]:
        """All quantities that it changes."""
        return frozenset((*self.adds, *self.scales, *self.sets))


@dataclass(frozen=True)
class Stage:
    """One named step of the derivation; `compute` maps the quantities so far to the new ones, then corrections change them."""

    name: str
    compute: Compute
    corrections: tuple[Correction, ...] = ()

    def __call__(self, q: Quantities) -> Quantities:
        """New and changed quantities from those so far, q."""
        found = dict(self.compute(q))
        for correction in self.corrections:
            found |= self._corrected(correction, {**q, **found})
        return found

    def _corrected(self, correction: Correction, q: Quantities) -> Mapping[str, Any]:
        """What a correction makes of the quantities q so far; ValueError for an effect whose correction is not as it declares."""
        if not correction.effect:
            return correction.compute(q)
        where, there = f"effect {correction.effect}, stage {self.name}", q.keys()
        declared = {"wheels" if name.startswith("wheel.") else name for name in correction.writes}
        added = {"wheels" if name.startswith("wheel.") else name for name in (*correction.adds, *correction.scales)}
        for name in sorted(added - there):
            raise ValueError(f"{where}: adds or scales: expected a quantity of this stage or an earlier one, found {name!r}")
        try:
            changed = correction.compute(q)
        except KeyError as missing:
            words = f"{where}: expected to read a quantity of this stage or an earlier one, found {missing}"
            raise ValueError(words) from missing
        for name in sorted(changed.keys() - declared):
            raise ValueError(f"{where}: expected changes of {', '.join(sorted(declared))}, as it declares; found {name!r}")
        return changed


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
class Added:
    """What one effect brought into a model: its name, states, parameters and memories."""

    name: str
    x: Layout
    p: Layout
    memories: tuple[Memory, ...]


@dataclass(frozen=True, eq=False)
class Model:
    """Continuous-time model xdot = f(x, u, p), y = g(x, u, p); argument order always (x, u, p).

    x, u, p, y: layouts of states, inputs, parameters, outputs; stages: the derivation in order; memories: histories whose
    provided signals are the last entries of u; added: the effects in it, by name; geometry: the vehicle, where it has one;
    doubted: "vehicle", "soil": those whose numbers are contradicted by the logs that they were identified from; together: error
    of parameters that were identified together, which stands in the place of their spreads.
    Two models are equal only where they are one.
    Raises ValueError where one name stands for two quantities.
    Example: softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay")).ode().name_in() == ["x", "u", "p"]
    """

    name: str
    x: Layout
    u: Layout
    p: Layout
    y: Layout
    stages: tuple[Stage, ...]
    memories: tuple[Memory, ...] = ()
    added: tuple[Added, ...] = ()
    geometry: Any = None
    doubted: tuple[str, ...] = ()
    together: JointError | None = None
    _symbols: tuple[ca.SX, ca.SX, ca.SX] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        symbols = tuple(ca.SX.sym(name, len(layout)) for name, layout in zip("xup", (self.x, self.u, self.p), strict=True))
        object.__setattr__(self, "_symbols", symbols)
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
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were added, in alphabetical order."""
        return tuple(added.name for added in self.added)

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
        """All quantities of the chain for (n_x,), (n_u,), (n_p,) CasADi vectors, those of `symbols` computed once."""
        return dict(self._chain) if all(map(is_, (x, u, p), self._symbols)) else self._through(x, u, p)

    @cached_property
    def _chain(self) -> Quantities:
        return self._through(*self._symbols)

    def _through(self, x: ca.SX, u: ca.SX, p: ca.SX) -> Quantities:
        q: Quantities = {}
        for layout, vector in ((self.x, x), (self.u, u), (self.p, p)):
            q.update({name: vector[i] for i, name in enumerate(layout.names)})
        own = {name: added.name for added in self.added for name in added.p.names}
        for stage in self.stages:
            found = stage(q)
            for name in own.keys() & found.keys():
                where = f"effect {own[name]}: parameter {name!r}"
                raise ValueError(f"{where}: expected a name of its own, found a quantity of the model called so")
            q.update(found)
        return q

    def ode(self) -> ca.Function:
        """CasADi function [x, u, p] -> [xdot]."""
        return self._function("ode", "xdot", [f"d_{name}" for name in self.x.names])

    def measurement(self) -> ca.Function:
        """CasADi function [x, u, p] -> [y]."""
        return self._function("measurement", "y", [f"y_{name}" for name in self.y.names])

    def probe(self, *names: str) -> ca.Function:
        """CasADi function [x, u, p] -> [values of the named quantities]; KeyError for one the chain does not compute."""
        return self._function("probe", "values", names)

    def _function(self, name: str, result: str, quantities: Sequence[str]) -> ca.Function:
        values = ca.vertcat(*[self._result(self._chain, quantity) for quantity in quantities])
        return ca.Function(name, [*self._symbols], [values], ["x", "u", "p"], [result])

    def symbols(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """The model's own symbols (x, u, p), the same at every call."""
        return self._symbols

    def _result(self, q: Quantities, name: str) -> Scalar:
        if name not in q:
            raise KeyError(f"model {self.name}: expected its stages to compute {name!r}; found {', '.join(sorted(q))}")
        return q[name]

    def correct(self, stage: str, correction: Correction | Compute) -> Model:
        """The model with a correction after the named stage, put in order among those of other effects; a plain function comes
        after all of them. Raises ValueError for no such stage, or corrections that have no order.
        """
        names = [s.name for s in self.stages]
        if stage not in names:
            raise ValueError(f"model {self.name}: expected a stage of {', '.join(names)}; found {stage!r}")
        at = names.index(stage)
        new = correction if isinstance(correction, Correction) else Correction(correction)
        there = self.stages[at].corrections
        probes = tuple(c for c in (*there, new) if not c.effect)
        ordered = (*in_order(stage, [c for c in (*there, new) if c.effect]), *probes)
        return replace(self, stages=(*self.stages[:at], replace(self.stages[at], corrections=ordered), *self.stages[at + 1 :]))


def in_order(stage: str, corrections: Sequence[Correction]) -> list[Correction]:
    """The corrections of a stage such that each comes after all that change what it reads, alphabetically where none does.

    Raises ValueError for two that change one quantity in ways that do not commute, and for a circle.
    """
    waiting = sorted(corrections, key=lambda c: c.effect)
    for i, one in enumerate(waiting):
        for other in waiting[:i]:
            alike = set(one.adds) & set(other.adds) | set(one.scales) & set(other.scales)
            clash = sorted((one.writes & other.writes) - alike)
            if clash:
                raise ValueError(
                    f"effects {other.effect} and {one.effect}: expected both to add to {clash[0]} after stage {stage}, or both "
                    "to multiply it; found one that does not: their order would matter"
                )
    ordered: list[Correction] = []
    while waiting:
        free = next((c for c in waiting if not any(c is not o and set(c.reads) & o.writes for o in waiting)), None)
        if free is None:
            changed = {name for c in waiting for name in c.writes}
            circle = "; ".join(f"{c.effect} reads {', '.join(sorted(changed & set(c.reads)))}" for c in waiting)
            raise ValueError(
                f"effects after stage {stage}: expected an order in which each reads what no later one changes, found a circle: "
                f"{circle}"
            )
        waiting.remove(free)
        ordered.append(free)
    return ordered
