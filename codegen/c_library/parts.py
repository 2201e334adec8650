"""A model split for C: what leads to the wheels, the force law once for all wheels of a size, and what follows from forces.

The model is built a second time with a force law that writes down what it is asked and answers with symbols; no equation
is repeated. The law, nine tenths of the work, then stands in the C code once for all wheels that ask it alike and runs over all
pairs of wheel and sigma point. Sigma points that differ only in states on which no wheel depends share one evaluation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from itertools import groupby
from typing import Any

import casadi as ca

from softsoil.codegen.factor_order import factor_order
from softsoil.symbolic.model import Memory, Model, Quantities
from softsoil.symbolic.signals import Layout
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil
from softsoil.symbolic.wheel import Contact, ForceLaw, Wheel, WheelForce

SOIL = SOIL_SIGNALS.names
CONTACT = tuple(f.name for f in fields(Contact))
FORCE = tuple(f.name for f in fields(WheelForce))
TOLD = tuple(name for name in CONTACT if name not in ("rut_depth", "sweep"))
"""Arguments of the C function of one wheel; there a rut has no depth and the wheel stands upright."""
SAID = tuple(name for name in FORCE if not name.startswith("exit_") or name == "exit_path")
"""What it answers."""


@dataclass
class _Recorder:
    """A force law that keeps its arguments and answers with fresh symbols."""

    name: str
    calls: list[list[Any]] = field(default_factory=list)
    wheels: list[Wheel] = field(default_factory=list)
    answers: list[ca.SX] = field(default_factory=list)

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        self.calls.append([getattr(soil, n) for n in SOIL] + [getattr(contact, n) for n in CONTACT])
        self.wheels.append(wheel)
        answer = ca.SX.sym(f"force{len(self.calls)}", len(FORCE))
        self.answers.append(answer)
        return WheelForce(*(answer[i] for i in range(len(FORCE))))


@dataclass(frozen=True)
class LawPart:
    """The force law as some wheels need it, `calls` of them one after the other; function: [arguments, p] -> [outputs]."""

    calls: int
    function: ca.Function


@dataclass(frozen=True)
class Parts:
    """The functions that the C library is made of; x, u (full input), p, m, dt as in `softsoil.symbolic.model`.

    model; active: states that some wheel depends on, the first in the order of the covariance's factor; calls: wheels (law
    evaluations) per point; before: [x, u, p] -> [what differs between wheels and points (calls * n_arguments)]; laws: for
    all wheels in their order, one for those of one size whose arguments are numbers in the same places (a wheel that is known to
    meet no rut needs less); after: [x, u, p, F] -> [xdot];
    measure: [x, u, p, F] -> [y]; read: [x, u_external, p, m] -> [provided]; advance: [x, u, p, m, dt, F] -> [m_next];
    start: [x, u, p, F] -> [m]; force: of a front wheel, [soil, TOLD] -> [SAID]; outputs: names of the law's outputs in F
    (calls * n_outputs); measures_forces: whether the measurement depends on them; driven: measurements of states whose rate
    depends on them.
    """

    model: Model
    active: tuple[str, ...]
    calls: int
    arguments: tuple[str, ...]
    outputs: tuple[str, ...]
    measures_forces: bool
    driven: tuple[str, ...]
    before: ca.Function
    laws: tuple[LawPart, ...]
    after: ca.Function
    measure: ca.Function
    read: ca.Function
    advance: ca.Function
    start: ca.Function
    force: ca.Function

    def law_runs(self, *forms: str) -> str:
        """RUN(first wheel, wheels, function of each form) of every law, the functions named form_k, one after the other."""
        runs, first = [], 0
        for k, law in enumerate(self.laws):
            runs.append(f"RUN({first}, {law.calls}, {', '.join(f'{form}_{k}' for form in forms)})")
            first += law.calls
        return " ".join(runs)


def take_apart(build: Callable[[ForceLaw], Model], law: ForceLaw) -> Parts:
    """The parts of the model that `build` makes of a force law.

    Raises ValueError for a model whose wheels depend on each other's forces.
    """
    recorder = _Recorder(law.name)
    model = build(recorder)
    x, u, p = model.symbols()
    m, dt = ca.SX.sym("m", len(model.cells)), ca.SX.sym("dt")
    external = ca.SX.sym("u_external", len(model.external))
    recorder.calls.clear()
    recorder.answers.clear()
    recorder.wheels.clear()
    q = model.quantities(x, u, p)
    calls, wheel, every = len(recorder.calls), recorder.wheels[0], ca.vertcat(*recorder.answers)
    asked = ca.vertcat(*[ca.SX(a) for call in recorder.calls for a in call])
    if ca.depends_on(asked, every):
        raise ValueError("C library: expected wheels that do not depend on each other's forces")
    shared = [_shared([call[i] for call in recorder.calls], ca.vertcat(x, u)) for i in range(len(SOIL + CONTACT))]
    free = ca.SX.sym("free", len(shared))
    free_force = ca.vertcat(*_call(law, wheel, ca.vertsplit(free)))
    varying = [i for i, value in enumerate(shared) if value is None and ca.depends_on(free_force, free[i])]
    # What the law does not read may be any number that its argument can be.
    unread = [signal.nominal for signal in SOIL_SIGNALS] + [0.0] * len(CONTACT)
    shared = [number if value is None else value for number, value in zip(unread, shared, strict=True)]
    before = ca.vertcat(*[ca.SX(call[i]) for call in recorder.calls for i in varying])
    names = (*SOIL, *CONTACT)
    arguments = tuple(names[i] for i in varying)
    built = build(law)
    order = factor_order(built)
    last = max(k for k, i in enumerate(order) if ca.depends_on(before, x[i]))
    active = tuple(model.x.names[i] for i in order[: last + 1])

    q_memory = {**q, "memory": {n: m[i] for i, n in enumerate(model.cells.names)}, "dt": dt}
    xdot = ca.vertcat(*[q[f"d_{n}"] for n in model.x.names])
    y = ca.vertcat(*[q[f"y_{n}"] for n in model.y.names])
    moved = ca.vertcat(*[x[i] for i in range(len(model.x)) if ca.depends_on(ca.SX(xdot[i]), every)])
    driven = tuple(n for i, n in enumerate(model.y.names) if ca.depends_on(ca.SX(y[i]), moved))
    m_next = _of_memories(model, lambda memory: (memory.advance(q_memory), memory.cells))
    m_first = _of_memories(model, lambda memory: (memory.start(q), memory.cells))
    provided = _provided(model, x, external, p, m)

    wanted = ca.vertcat(xdot, y, m_next, m_first)
    used = [j for j in range(len(FORCE)) if any(ca.depends_on(wanted, a[j]) for a in recorder.answers)]
    given = ca.SX.sym("F", calls * len(used))
    places = ca.vertcat(*[a[j] for a in recorder.answers for j in used])

    def after(name: str, inputs: list[ca.SX], result: ca.SX) -> ca.Function:
        (replaced,) = ca.substitute([ca.densify(result)], [places], [given])
        return ca.Function(name, [*inputs, given], [ca.cse(replaced)])

    argument = ca.SX.sym("argument", len(varying))

    def law_of(number: int, wheel: Wheel, numbers: tuple[float | None, ...], count: int) -> LawPart:
        symbols = [argument[varying.index(i)] if i in varying else shared[i] for i in range(len(names))]
        answer = _call(law, wheel, [s if n is None else n for s, n in zip(symbols, numbers, strict=True)])
        result = ca.cse(ca.densify(ca.vertcat(*[ca.SX(answer[j]) for j in used])))
        return LawPart(count, ca.Function(f"law_{number}", [argument, p], [result]))

    known = [_numbers([a if i in varying else shared[i] for i, a in enumerate(call)]) for call in recorder.calls]
    sizes = [next(k for k, w in enumerate(recorder.wheels) if _one_size(w, other)) for other in recorder.wheels]
    kinds = groupby(zip(sizes, known, strict=True))
    alike = [(recorder.wheels[size], numbers, len(list(run))) for (size, numbers), run in kinds]
    return Parts(
        model=built, active=active, calls=calls, arguments=arguments, outputs=tuple(FORCE[j] for j in used),
        measures_forces=bool(ca.depends_on(y, every)), driven=driven,
        before=ca.Function("before", [x, u, p], [ca.cse(ca.densify(before))]),
        laws=tuple(law_of(k, *run) for k, run in enumerate(alike)),
        after=after("after", [x, u, p], xdot),
        measure=after("measure", [x, u, p], y),
        read=ca.Function("read", [x, external, p, m], [ca.cse(ca.densify(provided))]),
        advance=after("advance", [x, u, p, m, dt], m_next),
        start=after("start", [x, u, p], m_first),
        force=_split(free, _at_nominal(free_force, p, model)),
    )  # fmt: skip


def _at_nominal(force: ca.SX, p: ca.SX, model: Model) -> ca.SX:
    """A wheel's force with the parameters that its own size depends on at their nominal values."""
    if not ca.depends_on(force, p):
        return force
    (result,) = ca.substitute([force], [p], [ca.SX(model.p.nominal)])
    return result


def _split(free: ca.SX, force: ca.SX) -> ca.Function:
    soil, contact = ca.SX.sym("soil", len(SOIL)), ca.SX.sym("contact", len(TOLD))
    asked = ca.vertcat(soil, *[contact[TOLD.index(name)] if name in TOLD else 0.0 for name in CONTACT])
    said = ca.vertcat(*[force[FORCE.index(name)] for name in SAID])
    (result,) = ca.substitute([said], [free], [asked])
    return ca.Function("force", [soil, contact], [ca.cse(ca.densify(result))])


def _one_size(one: Wheel, other: Wheel) -> bool:
    """Whether two wheels have the same radius and width, of numbers or expressions."""
    pairs = (one.radius, other.radius), (one.width, other.width)
    return all(ca.is_equal(ca.SX(a), ca.SX(b), 3) for a, b in pairs)


def _numbers(call: list[Any]) -> tuple[float | None, ...]:
    """A wheel's arguments that are numbers and stay so: the law is simpler for them."""
    return tuple(float(ca.SX(value)) if ca.SX(value).is_constant() else None for value in call)


def _shared(values: list[Any], points: ca.SX) -> Any | None:
    """The one value that all wheels have at all points, or None."""
    first = ca.SX(values[0])
    same = all(ca.is_equal(first, ca.SX(value), 30) for value in values[1:])
    return first if same and not ca.depends_on(first, points) else None


def _call(law: ForceLaw, wheel: Wheel, values: list[Any]) -> list[Any]:
    soil = dict(zip(SOIL, values[: len(SOIL)], strict=True))
    contact = dict(zip(CONTACT, values[len(SOIL) :], strict=True))
    force = law(Soil("c_library", **soil), wheel, Contact(**contact))
    return [getattr(force, name) for name in FORCE]


def _provided(model: Model, x: ca.SX, external: ca.SX, p: ca.SX, m: ca.SX) -> ca.SX:
    """What memories provide; see `softsoil.codegen.discretize.read_memory`."""
    q: Quantities = {name: x[i] for i, name in enumerate(model.x.names)}
    q |= {name: external[i] for i, name in enumerate(model.external.names)}
    q |= {name: p[i] for i, name in enumerate(model.p.names)}
    q["memory"] = {name: m[i] for i, name in enumerate(model.cells.names)}
    return _of_memories(model, lambda memory: (memory.read(q), memory.provides))


def _of_memories(model: Model, values: Callable[[Memory], tuple[Mapping[str, Any], Layout]]) -> ca.SX:
    """What each memory says, one after the other, in the order of its layout."""
    entries: list[Any] = []
    for memory in model.memories:
        found, layout = values(memory)
        entries += [found[name] for name in layout.names]
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)
