"""Steps converge at their order, and parameters become states."""

import casadi as ca
import numpy as np
import pytest

from drives import clay_bicycle
from softsoil.codegen.discretize import discretize
from softsoil.estimator.promote import promote_parameters, tie_parameters
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout, Signal

ORDERS = {"euler": 1, "rk4": 4}


def pendulum() -> Model:
    return Model.of(
        "pendulum",
        Layout.of(Signal("a", "rad", "angle"), Signal("w", "rad/s", "rate")),
        Layout.of(Signal("push", "rad/s^2", "push")),
        Layout.of(Signal("g", "1/s^2", "stiffness", 9.0, 0.0, 20.0)),
        Layout.of(Signal("a_seen", "rad", "angle")),
        lambda q: {"a": q["w"], "w": -q["g"] * ca.sin(q["a"]) + q["push"]},
        lambda q: {"a_seen": q["a"]},
    )


def end(method: str, steps: int, substeps: int = 1) -> np.ndarray:
    step = discretize(pendulum(), 1.0 / steps, method, substeps)
    x = np.array([0.8, 0.0])
    for _ in range(steps):
        x = np.asarray(step(x, [0.5], [9.0]))[:, 0]
    return x


@pytest.mark.parametrize("method", ORDERS)
def test_error_falls_with_the_order_of_the_method(method):
    exact = end("rk4", 4000)
    errors = [np.linalg.norm(end(method, steps) - exact) for steps in (40, 80, 160)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.allclose(orders, ORDERS[method], atol=0.15)


def test_substeps_are_steps():
    assert np.allclose(end("rk4", 10, substeps=4), end("rk4", 40), rtol=1e-13)


def test_euler_is_the_papers_step():
    model = clay_bicycle()
    x, u, p = np.array([0, 0, 0.1, 6, 0.1, 0.2]), np.array([0.1, 0, 0, 18, 18, 18, 18.0]), model.p.nominal
    step = np.asarray(discretize(model, 0.012)(x, u, p))[:, 0]
    assert np.allclose(step, x + 0.012 * np.asarray(model.ode()(x, u, p))[:, 0], rtol=1e-14)


@pytest.mark.parametrize(
    ("dt", "method", "substeps"), [(0.0, "euler", 1), (-1.0, "rk4", 1), (0.1, "midpoint", 1), (0.1, "rk4", 0)]
)
def test_unfit_arguments_are_named(dt, method, substeps):
    with pytest.raises(ValueError, match="discretize: expected"):
        discretize(pendulum(), dt, method, substeps)


def test_promoted_parameter_is_a_state_that_stays():
    model = promote_parameters(pendulum(), "g")
    assert model.x.names == ("a", "w", "g") and model.p.names == () and model.x["g"].upper == 20.0
    rates = np.asarray(model.ode()([0.3, 0.1, 9.0], [0.0], []))[:, 0]
    assert np.allclose(rates, [*np.asarray(pendulum().ode()([0.3, 0.1], [0.0], [9.0]))[:, 0], 0.0])
    with pytest.raises(KeyError, match="expected one of g"):
        promote_parameters(pendulum(), "h")


def test_tied_parameter_stands_for_both():
    model = clay_bicycle()
    tied = tie_parameters(model, Signal("n", "", "exponent", 0.5, 0.2, 1.6), "n_f", "n_r")
    x, u = np.array([0, 0, 0, 6, 0.2, 0.1]), np.array([0.2, 0, 0, 18, 18, 18, 18.0])
    apart = model.ode()(x, u, model.p.pack(n_f=0.8, n_r=0.8))
    assert np.array_equal(np.asarray(tied.ode()(x, u, tied.p.pack(n=0.8))), np.asarray(apart))


def test_one_name_stands_for_one_quantity():
    twice = Layout.of(Signal("a", "m", "a"))
    with pytest.raises(ValueError, match="'a' twice"):
        Model.of("bad", twice, twice, Layout(), Layout(), lambda q: {"a": 0}, lambda q: {})
