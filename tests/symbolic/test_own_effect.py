"""An effect of one's own: what its declaration promises is checked where it is added, and names effect, stage and quantity."""

import pytest

import softsoil
from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, add_effect

MODEL = softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))


def effect(parameter="cd_area", compute=lambda q: {"d_u": q["d_u"] - 0.001 * q["cd_area"] * q["u"] ** 2}, stage="rates", **other):
    declared = {"adds": ("d_u",), "reads": (), **{k: other.pop(k) for k in ("adds", "sets", "reads") if k in other}}
    layout = Layout.of(Signal(parameter, "m^2", "drag area", 0.0, 0.0, 20.0))
    words = {"name": "my_drag", "doc": "drag", "kind": "body", "reference": "mine"}
    corrections = {"corrections": {stage: Correction(compute, **declared)}}
    return Effect(parameters=layout, typical={parameter: 2.0}, **{**words, **corrections, **other})


def built(one):
    return add_effect(MODEL, one).ode()


def test_a_right_one_is_in_the_equations():
    x, u = MODEL.x.nominal, MODEL.u.nominal
    model = add_effect(MODEL, effect(), {"cd_area": 8.0})
    before, after = (float(m.ode()(x, u, m.p.nominal)[3]) for m in (MODEL, model))
    assert after - before == pytest.approx(-0.008 * x[3] ** 2)


@pytest.mark.parametrize("taken", ["mass", "radius", "spin_fl", "force_y"])
def test_a_parameter_called_as_a_quantity_is_refused(taken):
    one = effect(taken, lambda q: {"d_u": q["d_u"] - 0.001 * q[taken]})
    with pytest.raises(ValueError, match=f"effect my_drag: parameter '{taken}': expected a name of its own"):
        built(one)


@pytest.mark.parametrize("taken", ["c", "u", "steer", "n_f"])
def test_a_parameter_called_as_one_of_the_model_is_refused(taken):
    with pytest.raises(ValueError, match=f"effect my_drag: '{taken}': expected a name of its own"):
        add_effect(MODEL, effect(taken, lambda q: {"d_u": q["d_u"]}))


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"adds": ("d_q",)}, "adds or scales: expected a quantity of this stage or an earlier one, found 'd_q'"),
        ({"compute": lambda q: {"d_v": q["d_v"]}}, "expected changes of d_u, as it declares; found 'd_v'"),
        ({"compute": lambda q: {"d_u": q["masss"]}}, "stage rates: expected to read a quantity .* found 'masss'"),
        ({"stage": "inputs", "adds": ("du",), "compute": lambda q: {"du": q["mass"]}}, "stage inputs: expected to read .*'mass'"),
    ],
)
def test_a_correction_that_is_not_as_declared_is_refused(other, words):
    with pytest.raises(ValueError, match=f"effect my_drag.*{words}"):
        built(effect(**other))


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"name": "my-drag"}, "expected a name of letters"),
        ({"place": ("start",)}, "expected one of cd_area; found 'start'"),
        ({"for_control": {"area": 1.0}}, "expected one of cd_area; found 'area'"),
    ],
)
def test_a_declaration_that_cannot_be_is_refused(other, words):
    with pytest.raises(ValueError, match=words):
        effect(**other)


def test_an_effect_that_corrects_nothing_is_refused():
    with pytest.raises(ValueError, match="effect my_drag: expected a correction of a stage at least"):
        add_effect(MODEL, effect(corrections={}))
