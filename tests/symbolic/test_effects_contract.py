"""What every effect of the catalogue promises, alone, in pairs and all at once, with every force law."""

import itertools
from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.codegen.discretize import read_memory, start_memory, step_with_memory
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import Correction, add_effect, neutral
from softsoil.symbolic.model import Model, in_order
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.wheel import ForceLaw, WheelForce, law_names

DT, STEPS = 0.01, 3
KNOWN = catalogue(reference_vehicle())
NAMES = tuple(KNOWN)
RUT = {"multipass": 1e-5}
"""An effect whose absence is another quadrature of the same contact: two strips of the width, one of them empty."""


NO_NUMBERS = ("name", "verdict", "joint_error")
"""Fields of a soil that no law reads."""


def bare(law: ForceLaw | str = "turn_slip") -> Model:
    return nominal_bicycle(reference_vehicle().with_(effects={}), CLAY, law)


def with_effects(*names: str, law: ForceLaw | str = "turn_slip") -> Model:
    model = bare(law)
    for name in names:
        model = add_effect(model, KNOWN[name])
    return model


def states(model: Model, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """A state in a turn and inputs of a few steps; what effects add to the states begins at zero."""
    rng = np.random.default_rng(seed)
    x = np.zeros(len(model.x))
    x[:6] = [1.0, -2.0, 0.6, 5.0, 0.15, 0.35]
    inputs = np.array([0.2, 0.3, 0.4, 15.6, 16.4, 15.7, 16.5]) + 0.02 * rng.normal(size=(STEPS, 7))
    return x, inputs


def driven(model: Model) -> dict[str, float]:
    """States, outputs and histories by name after a few steps: whatever a model says."""
    x, inputs = states(model)
    p = model.p.nominal
    step, first, full = step_with_memory(model, DT), start_memory(model), read_memory(model)
    m = first(x, inputs[0], p)
    for u in inputs:
        x, m = step(x, m, u, p)
    y = model.measurement()(x, full(x, inputs[-1], p, m), p)
    parts = ((model.x.names, x), (model.y.names, y), (model.cells.names, m))
    found = {
        f"{kind} {name}": float(value)
        for kind, (names, values) in zip("xym", parts, strict=True)
        for name, value in zip(names, np.asarray(values).ravel(), strict=True)
    }
    assert np.isfinite(list(found.values())).all()
    return found


def assert_same(found: dict[str, float], expected: dict[str, float], within: float = 1e-12) -> None:
    for name in found.keys() & expected.keys():
        assert found[name] == pytest.approx(expected[name], rel=within, abs=within), name


@pytest.mark.parametrize("name", NAMES)
def test_absent_is_the_identity(name):
    """At its neutral values an effect changes no state and no output, on a drive through its own histories."""
    effect = KNOWN[name]
    assert_same(driven(neutral(bare(), effect)), driven(bare()), RUT.get(name, 1e-12))


@pytest.mark.parametrize("name", NAMES)
def test_present_is_not(name):
    found, without = driven(with_effects(name)), driven(bare())
    assert max(abs(found[key] - without[key]) for key in without) > 1e-9 or name in ("soil_change", "backlash")


@dataclass(frozen=True)
class Everything:
    """A force law that looks at all it is given: quick, and no change of a soil or a contact is lost on it."""

    name: str = "everything"

    def __call__(self, soil, wheel, contact) -> WheelForce:
        given = ca.vertcat(*(v for part in (soil, contact) for n, v in vars(part).items() if n not in NO_NUMBERS))
        count = np.arange(1.0, given.numel() + 1.0)
        weights = 100.0 * np.cos(np.outer(np.arange(1.0, 6.0), count))
        forces = ca.vertsplit(ca.mtimes(weights, ca.sin(count * given)))
        return WheelForce(*forces[:4], sinkage=0.05, exit_path=1e-4 * forces[4])


@pytest.mark.slow
def test_any_order_of_two_gives_the_same_model():
    for one, other in itertools.combinations(NAMES, 2):
        first, second = with_effects(one, other, law=Everything()), with_effects(other, one, law=Everything())
        for layout in ("x", "u", "p", "y", "cells"):
            assert getattr(first, layout).names == getattr(second, layout).names, (one, other)
        arguments = numbers(first)
        a, b = (np.asarray(rates_and_outputs(model)(*arguments)) for model in (first, second))
        assert np.isfinite(a).all() and np.allclose(a, b, rtol=1e-12, atol=1e-12), (one, other)


def rates_and_outputs(model: Model) -> ca.Function:
    x, u, p = model.symbols()
    q = model.quantities(x, u, p)
    values = [q[f"d_{name}"] for name in model.x.names] + [q[f"y_{name}"] for name in model.y.names]
    return ca.Function("f", [x, u, p], [ca.vertcat(*values)])


def test_any_order_of_all_gives_the_same_drive():
    expected, rng = driven(with_effects(*NAMES)), np.random.default_rng(1)
    for _ in range(3):
        found = driven(with_effects(*rng.permutation(NAMES)))
        assert found.keys() == expected.keys()
        assert_same(found, expected)


def test_the_order_of_the_vehicle_s_file_does_not_matter():
    vehicle = reference_vehicle()
    turned = vehicle.with_(effects=dict(reversed(vehicle.effects.items())))
    assert_same(driven(bicycle(turned, CLAY)), driven(bicycle(vehicle, CLAY)))


def numbers(model: Model, seed: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States, full inputs and parameters in a turn, what memories provide drawn small."""
    rng = np.random.default_rng(seed)
    x, inputs = states(model)
    provided = 0.01 * rng.uniform(0.1, 1.0, len(model.u) - len(model.external))
    return x, np.concatenate([inputs[0], provided]), model.p.nominal


@pytest.mark.parametrize("name", NAMES)
def test_an_effect_changes_and_reads_what_it_says(name):
    """Its corrections write what they declare, in the way they declare; nothing that they read goes unsaid."""
    effect = KNOWN[name]
    model = bare()
    for stage, correction in effect.corrections.items():
        for written, before, after, others in probed(add_effect(model, effect), stage, correction):
            assert written in correction.writes | {"wheels"}, f"{stage}: {written}"
            if written in correction.adds:
                assert evaluate(ca.jacobian(after, before)) == pytest.approx(1.0, abs=1e-12), f"{stage}: {written}"
            if written in correction.scales:
                rest = evaluate(ca.jacobian(after, before) - after / before)
                assert rest == pytest.approx(0.0, abs=1e-12), f"{stage}: {written}"
            unsaid = {n for n in others if ca.depends_on(after, others[n])} - {*correction.reads, *correction.sets, written}
            assert not unsaid, f"{stage}: {written} depends on {unsaid}"


def probed(model: Model, stage: str, correction: Correction):
    """(quantity, symbol before, expression after, symbols of all quantities of the chain) per quantity that is changed."""
    x, u, p = model.symbols()
    q = {n: v[i] for layout, v in ((model.x, x), (model.u, u), (model.p, p)) for i, n in enumerate(layout.names)}
    given = set(q)
    for each in model.stages:
        q.update(each.compute(q))
        if each.name == stage:
            break
        for one in each.corrections:
            q.update(one.compute(q))
    symbols = {n: ca.SX.sym(n) for n in q if n not in given and n != "wheels"}
    q.update(symbols)
    q["wheels"] = tuple(map(symbolic_wheel, q.get("wheels", ())))
    for n, after in correction.compute(q).items():
        if n != "wheels":
            yield n, symbols.get(n, ca.SX.sym("new")), ca.SX(after), symbols
        elif "wheels" in correction.sets:
            yield n, ca.SX.sym("old"), ca.vertcat(*[ca.SX(v) for w in after for v in parts(w).values()]), symbols
        else:
            for old, new in zip(map(parts, q[n]), map(parts, after), strict=True):
                for part in (part for part in new if not ca.is_equal(ca.SX(new[part]), old[part])):
                    yield part, old[part], ca.SX(new[part]), {**symbols, **old}


WHEEL = ("y", "load", "delta", "spin", "x", "apart", "scrub")


def parts(corner) -> dict:
    """wheel.<part> -> value of a corner."""
    found = {f"wheel.{n}": getattr(corner, n) for n in WHEEL}
    for kind in ("soil", "contact", "force"):
        holder = getattr(corner, kind)
        if holder is not None:
            found |= {f"wheel.{kind}.{n}": value for n, value in vars(holder).items() if n != "name"}
    return found


def symbolic_wheel(corner):
    """The wheel with a symbol in the place of every number."""
    corner = replace(corner, **{n: ca.SX.sym(n) for n in WHEEL})
    for kind in ("soil", "contact", "force"):
        holder = getattr(corner, kind)
        if holder is not None:
            symbols = {n: ca.SX.sym(f"{kind}_{n}") for n in vars(holder) if n != "name"}
            corner = replace(corner, **{kind: replace(holder, **symbols)})
    return corner


def evaluate(expression) -> float:
    symbols = ca.symvar(ca.SX(expression))
    values = np.random.default_rng(8).uniform(0.3, 0.9, len(symbols))
    return float(ca.Function("f", symbols, [expression]).call([ca.DM(value) for value in values])[0])


def test_effects_without_an_order_are_refused():
    def correction(effect, **kinds):
        return Correction(lambda q: {}, effect=effect, **kinds)

    first, second = correction("b", reads=("mass",), adds=("l_f",)), correction("a", adds=("mass",))
    assert [c.effect for c in in_order("vehicle", [first, second])] == ["a", "b"]
    with pytest.raises(ValueError, match="found a circle: a reads l_f; b reads mass"):
        in_order("vehicle", [first, correction("a", reads=("l_f",), adds=("mass",))])
    with pytest.raises(ValueError, match="a and b: expected both to add to mass"):
        in_order("vehicle", [correction("a", adds=("mass",)), correction("b", scales=("mass",))])


def test_what_an_effect_reads_others_have_changed_before():
    """Sinkage by slip goes by the changed soil; a payload's lever by where the body's lean has put the axle."""
    known = catalogue(reference_vehicle())
    model = with_effects("slip_sinkage", "soil_change", "payload", "pressure_offset", "wheel_lean", "load_transfer")
    order = {stage.name: [c.effect for c in stage.corrections] for stage in model.stages}
    assert order["vehicle"] == ["pressure_offset", "payload"]
    assert order["loads"].index("load_transfer") < order["loads"].index("wheel_lean")
    assert order["contacts"].index("soil_change") < order["contacts"].index("slip_sinkage")
    assert known["payload"].name in model.effects


EDGES = {
    "turning": ([0, 0, 0.6, 5.0, 0.15, 0.35], [0.2, 0.3, 0.4, 15.6, 16.4, 15.7, 16.5]),
    "zero slip": ([0, 0, 0, 5.0, 0, 0], [0, 0, 0, *[5.0 / reference_vehicle().radius] * 4]),
    "standing": ([0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0]),
    "spinning on the spot": ([0, 0, 0, 0, 0, 0], [0.1, 0, 0, 9, 9, 9, 9]),
    "wheels in the air": ([0, 0, 0, 8.0, 0.1, 0.9], [0.2, 0, -9.81, 24, 24, 24, 24]),
}


@lru_cache(maxsize=1)
def linearised(law: str):
    """The model with the whole catalogue, its rates and outputs and all their derivatives."""
    model = with_effects(*NAMES, law=law)
    x, u, p = model.symbols()
    q = ca.vertcat(x, u, p)
    values = ca.cse(rates_and_outputs(model)(x, u, p))
    return model, ca.Function("f", [x, u, p], [values, ca.jacobian(values, q)])


@pytest.mark.slow
@pytest.mark.parametrize("law", law_names())
def test_finite_and_differentiable_at_the_edges_with_every_law(law):
    """Each effect alone, every pair with the first ones, and all together; on hard ground nothing sinks."""
    model, f = linearised(law)
    known = catalogue(reference_vehicle())
    absent = {s.name: s.nominal for e in known.values() for s in e.parameters}
    sets = [{}, *({**known[n].typical} for n in NAMES), {k: v for n in NAMES for k, v in known[n].typical.items()}]
    for edge, (state, inputs) in EDGES.items():
        x = np.concatenate([state, np.zeros(len(model.x) - 6)])
        u = np.concatenate([inputs, model.u.nominal[7:]])
        for values in sets:
            found = f(x, u, model.p.pack({**absent, **values}))
            for part, what in zip(found, ("value", "derivative"), strict=True):
                assert np.isfinite(np.asarray(part.nonzeros())).all(), f"{what} {edge} {values}"


def test_signatures_are_shared_and_mutual():
    known = catalogue(reference_vehicle())
    for one, other in itertools.combinations(known.values(), 2):
        assert one.looks_like(other) == other.looks_like(one)
    shared = [s for e in known.values() for s in e.signatures]
    alone = sorted(s for s in shared if shared.count(s) == 1)
    others = sorted(set(shared) - set(alone))
    assert not alone, f"signatures of one effect alone: {alone}; expected words that another has, of {others}"


def test_every_effect_says_what_it_rests_on_and_what_separates_it():
    for effect in catalogue(reference_vehicle()).values():
        assert effect.rests_on and effect.separates and effect.doc and effect.reference, effect.name
