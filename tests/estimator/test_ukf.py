"""The filter against the textbook Kalman filter, FilterPy, and its own promises."""

import casadi as ca
import numpy as np
import pytest

from softsoil.estimator.ukf import UnscentedKalmanFilter
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout, Signal

A = np.array([[0.0, 1.0], [-2.0, -0.5]])
B = np.array([0.0, 1.0])
H = np.array([[1.0, 0.0], [0.3, 1.0]])
DT = 0.01


def linear_model() -> Model:
    def rhs(q):
        return {"a": q["b"], "b": -2.0 * q["a"] - 0.5 * q["b"] + q["f"]}

    def output(q):
        return {"a_seen": q["a"], "mix": 0.3 * q["a"] + q["b"]}

    return Model.of(
        "linear",
        Layout.of(Signal("a", "m", "position"), Signal("b", "m/s", "speed")),
        Layout.of(Signal("f", "m/s^2", "push")),
        Layout(),
        Layout.of(Signal("a_seen", "m", "position"), Signal("mix", "m", "mixture")),
        rhs,
        output,
    )


def make(model, **changes):
    arguments = {"q": [1e-4, 2e-4], "r": [0.01, 0.04], "x0": [0.5, -0.2], "p0": [0.3, 0.4], **changes}
    return UnscentedKalmanFilter(model, DT, **arguments)


def test_linear_system_gives_the_textbook_kalman_filter():
    rng = np.random.default_rng(1)
    ukf = make(linear_model())
    x, cov = np.array([0.5, -0.2]), np.diag([0.3, 0.4])
    transition, q, r = np.eye(2) + DT * A, np.diag([1e-4, 2e-4]), np.diag([0.01, 0.04])
    for k in range(300):
        u = np.sin(0.1 * k)
        x, cov = transition @ x + DT * B * u, transition @ cov @ transition.T + q
        ukf.predict([u])
        if k % 2:
            y = rng.normal(size=2)
            s = H @ cov @ H.T + r
            gain = cov @ H.T @ np.linalg.inv(s)
            x, cov = x + gain @ (y - H @ x), cov - gain @ s @ gain.T
            ukf.update(y)
        assert np.allclose(ukf.x, x, rtol=0, atol=1e-12)
        assert np.allclose(ukf.P, cov, rtol=0, atol=1e-12)


def test_invalid_measurement_is_left_out_exactly_and_counted():
    both, single = make(linear_model()), make(linear_model())
    for k in range(50):
        both.predict([1.0])
        single.predict([1.0])
        innovation = both.update([0.1 * k, np.nan])
        assert innovation.used.tolist() == [True, False] and innovation.dof == 1
        # The reference: the second measurement with so much noise that it says nothing.
        single._update.inputs[6][...] = np.diag([0.01, 1e12])
        single.update([0.1 * k, 5.0])
        assert np.allclose(both.x, single.x, rtol=1e-9) and np.allclose(both.P, single.P, rtol=1e-9, atol=1e-12)
    assert both.counts.invalid == {"mix": 50}


def test_gate_leaves_out_an_outlier():
    ukf = make(linear_model(), gate=4.0)
    ukf.predict([0.0])
    before = ukf.x.copy()
    used = ukf.update([100.0, before[1] + 0.3 * before[0]]).used
    assert used.tolist() == [False, True]
    assert ukf.counts.gated == {"a_seen": 1}
    assert np.abs(ukf.x - before).max() < 0.1


def test_non_finite_input_keeps_the_last_value():
    held, plain = make(linear_model()), make(linear_model())
    for u, said in [(1.0, 1.0), (1.0, np.nan), (1.0, np.inf), (0.5, 0.5)]:
        held.predict([said])
        plain.predict([u])
    assert np.array_equal(held.x, plain.x)
    assert held.counts.held_inputs == {"f": 2}


def test_bounded_state_and_covariance_stay_sound_in_a_storm():
    model = linear_model()
    bounded = Layout.of(Signal("a", "m", "position", 0.0, -1.0, 1.0), model.x["b"])
    model = Model("bounded", bounded, model.u, model.p, model.y, model.stages)
    ukf = make(model, q=[1e-8, 1e-8], r=[1e-10, 1e4])
    rng = np.random.default_rng(3)
    for _ in range(3000):
        ukf.predict(rng.normal(size=1) * 100)
        ukf.update(rng.normal(size=2) * 10 ** rng.uniform(-3, 3, size=2), valid=rng.random(2) > 0.3)
        assert np.array_equal(ukf.P, ukf.P.T)
        assert np.linalg.eigvalsh(ukf.P).min() > -1e-15
        assert -1.0 <= ukf["a"] <= 1.0


def test_heading_is_compared_on_the_circle():
    model = Model.of(
        "heading",
        Layout.of(Signal("psi", "rad", "heading")),
        Layout(),
        Layout(),
        Layout.of(Signal("psi", "rad", "heading")),
        lambda q: {"psi": 0.0},
        lambda q: {"psi": q["psi"]},
    )
    ukf = UnscentedKalmanFilter(model, DT, q=[0.0], r=[0.01], x0=[3.1], p0=[0.01])
    innovation = ukf.update([-3.1])
    assert innovation.value[0] == pytest.approx(2 * np.pi - 6.2)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"q": [1.0]}, "expected shape"),
        ({"r": [0.0, 1.0]}, "positive definite"),
        ({"p0": [-1.0, 1.0]}, "positive semidefinite"),
        ({"x0": [1.0]}, r"x0: expected shape \(2,\)"),
    ],
)
def test_unfit_arguments_are_named(changes, words):
    with pytest.raises(ValueError, match=words):
        make(linear_model(), **changes)


def test_virtual_machine_and_compiled_code_agree():
    fast, slow = make(linear_model()), make(linear_model(), compiled=False)
    for k in range(20):
        for ukf in (fast, slow):
            ukf.predict([np.cos(k)])
            ukf.update([0.1, 0.2])
    assert np.allclose(fast.x, slow.x, rtol=1e-13, atol=1e-14)
    assert np.allclose(fast.P, slow.P, rtol=1e-11, atol=1e-14)


def test_model_functions_are_casadi_functions():
    assert isinstance(linear_model().ode(), ca.Function)
