"""The real-time solver: its derivatives, its subproblem and its solutions against CasADi's own."""

import ctypes
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

from drives import reference_vehicle
from nmpc_problem import N, rut_ocp, small_ocp
from softsoil.control.c_controller import controller_files
from softsoil.control.nmpc import Nmpc
from softsoil.control.nmpc_binding import CController
from softsoil.control.nmpc_casadi import CasadiNmpc, answers_in_time, fallback
from softsoil.control.nmpc_settings import SETTINGS
from softsoil.control.nmpc_status import Status
from softsoil.control.ocp import Ocp, OcpSettings
from softsoil.control.ocp_examples import closed_loop_cost, tanh_bicycle

OBSTACLES = np.array([[8.0, 2.2, 0.4]])


def straight(ocp: Ocp, y: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A reference beside the vehicle, and the plan that drives straight on."""
    x = 5.0 * ocp.settings.dt * np.arange(N + 1)
    ref = np.column_stack([x, np.full(N + 1, y), np.zeros(N + 1), np.full(N + 1, 5.0)])
    return ref, np.stack([ocp.z.pack(u=5.0, x=place) for place in x])


INSIDE = """
#include <string.h>
void inside_ab(const softsoil_nmpc_t *c, double *ab) {
  for (int k = 0; k < QP_N; ++k)
    for (int i = 0; i < NZ; ++i) memcpy(ab + (k * NZ + i) * NV, c->work.qp.AB[k][i], NV * sizeof(double));
}
void inside_clip(softsoil_nmpc_t *c, double *h) {
  for (int k = 0; k < STAGES; ++k)
    for (int i = 0; i < NV; ++i) memcpy(c->work.qp.H[k][i], h + (k * NV + i) * NV, NV * sizeof(double));
  clip(&c->work.qp);
  for (int k = 0; k < STAGES; ++k)
    for (int i = 0; i < NV; ++i) memcpy(h + (k * NV + i) * NV, c->work.qp.H[k][i], NV * sizeof(double));
}
"""
"""Windows into the C code for the tests below."""


@lru_cache(maxsize=1)
def inside() -> CController:
    """The controller of the small problem with its insides in sight, started."""
    texts = controller_files(small_ocp(), digits=17)
    controller = CController(small_ocp(), {**texts, "src/softsoil_nmpc.c": texts["src/softsoil_nmpc.c"] + INSIDE})
    controller.call("init", None, small_ocp().z.nominal)
    return controller


def test_sensitivities_are_those_of_the_casadi_step():
    ocp, controller, rng = small_ocp(), inside(), np.random.default_rng(1)
    ref, z = straight(ocp)
    z, w = z + 0.03 * rng.standard_normal(z.shape), 0.1 * rng.standard_normal((N, 2))
    controller.call("guess", z, w)
    controller.call("parameters", ocp.s.nominal, np.zeros((N, 1)), ref, np.zeros((N + 1, 2, 3)))
    controller.call("linearise")
    ab = np.zeros((N, len(ocp.z), len(ocp.z) + 2))
    controller.c.inside_ab(controller.self, ab.ctypes.data_as(ctypes.c_void_p))
    a, b, r, s = ocp.symbols()
    end = ocp.step()(a, b, r, s)
    check = ca.Function("check", [a, b, r, s], [end, ca.jacobian(end, ca.vertcat(a, b))])
    for k in (0, N - 1):
        value, jacobian = check(z[k], w[k], np.zeros(0), ocp.s.nominal)
        np.testing.assert_allclose(controller.view("end")[k], np.array(value).ravel(), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(ab[k], np.array(jacobian), rtol=1e-9, atol=1e-10)


def test_clipping_raises_the_eigenvalues_and_nothing_else():
    nv, rng = len(small_ocp().z) + 2, np.random.default_rng(2)
    root = rng.standard_normal((N + 1, nv, nv))
    hessian = root + root.transpose(0, 2, 1)
    values, vectors = np.linalg.eigh(hessian)
    expected = (vectors * np.maximum(values, SETTINGS.least_curvature)[:, None, :]) @ vectors.transpose(0, 2, 1)
    found = np.ascontiguousarray(hessian)
    inside().c.inside_clip(inside().self, found.ctypes.data_as(ctypes.c_void_p))
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.study
def test_converged_plan_is_ipopts():
    ocp = small_ocp()
    ref, z = straight(ocp)
    ours, theirs = Nmpc(ocp, "converged", most=40, tolerance=1e-4), CasadiNmpc(ocp, "ipopt")
    for solver in (ours, theirs):
        solver.set_parameters(ocp.s.nominal, np.zeros((N, 0)), ref, OBSTACLES)
        solver.set_initial_guess(z, np.zeros((N, 2)))
        solver.make_step(z[0])
        assert solver.stats.status is Status.CONVERGED, solver.stats.sentence
    assert ours.stats.cost == pytest.approx(theirs.stats.cost, rel=1e-3)
    np.testing.assert_allclose(ours.z, theirs.z, atol=5e-3)


def test_real_time_iterations_run_into_the_converged_plan():
    ocp = small_ocp()
    ref, z = straight(ocp)
    plans = []
    for mode, steps in (("converged", 1), ("rti", 12)):
        solver = Nmpc(ocp, mode)
        solver.set_parameters(ocp.s.nominal, np.zeros((N, 0)), ref)
        solver.set_initial_guess(z, np.zeros((N, 2)))
        for _ in range(steps):
            solver.make_step(z[0])
        plans.append(solver.w.copy())
    np.testing.assert_allclose(plans[1], plans[0], atol=5e-3)


def test_a_state_that_is_not_finite_leaves_the_plan_alone():
    ocp = small_ocp()
    solver = Nmpc(ocp)
    solver.set_parameters(ocp.s.nominal, np.zeros((N, 0)), straight(ocp)[0])
    before = solver.w.copy()
    solver.make_step(np.full(len(ocp.z), np.nan))
    assert solver.stats.status is Status.BAD_STATE and not solver.stats.status.usable
    np.testing.assert_array_equal(solver.w, before)


def test_inputs_keep_their_limits_where_the_path_asks_for_more():
    ocp = small_ocp()
    ref, z = straight(ocp, y=6.0)
    solver = Nmpc(ocp, "converged")
    solver.set_parameters(ocp.s.nominal, np.zeros((N, 0)), ref)
    solver.set_initial_guess(z, np.zeros((N, 2)))
    solver.make_step(z[0])
    assert np.all(solver.w <= ocp.w.upper + 1e-9) and np.all(solver.w >= ocp.w.lower - 1e-9)
    assert np.abs(solver.w[:, 0]).max() > 0.9 * ocp.w.upper[0]


@lru_cache(maxsize=1)
def plain_ocp() -> Ocp:
    return Ocp(tanh_bicycle(reference_vehicle()), reference_vehicle(), OcpSettings(obstacles=0))


@pytest.mark.study
def test_closed_loop_cost_is_that_of_the_converged_solutions_and_of_ipopt():
    steps, costs = 70, {}
    for name, solver in (
        ("rti", Nmpc(plain_ocp(), "rti")), ("converged", Nmpc(plain_ocp(), "converged")),
        ("ipopt", CasadiNmpc(plain_ocp(), "ipopt")),
    ):  # fmt: skip
        costs[name], _ = closed_loop_cost(plain_ocp(), solver, steps)
    assert costs["converged"] == pytest.approx(costs["ipopt"], rel=1e-3)
    assert costs["rti"] == pytest.approx(costs["ipopt"], rel=1e-2)


def test_a_plan_moves_on_in_time():
    solver = Nmpc(plain_ocp())
    z = np.stack([plain_ocp().z.pack(u=5.0, x=5.0 * plain_ocp().settings.dt * k) for k in range(41)])
    solver.set_initial_guess(z, np.zeros((40, 2)))
    solver.shift(0.4 * plain_ocp().settings.dt)
    np.testing.assert_allclose(solver.z[:, 0], z[:, 0] + 0.4 * 5.0 * plain_ocp().settings.dt, atol=1e-12)


def avoiding_ocp() -> Ocp:
    return Ocp(tanh_bicycle(reference_vehicle()), reference_vehicle(), OcpSettings(steps=N, dt=0.1, obstacles=1))


@pytest.mark.skipif(not ca.has_nlpsol("fatrop"), reason="this CasADi has no fatrop")
def test_fatrop_finds_the_stages_and_ipopts_plan():
    ocp, solvers = avoiding_ocp(), []
    ref, z = straight(ocp)
    for name in ("fatrop", "ipopt"):
        solver = CasadiNmpc(ocp, name)
        solver.set_parameters(ocp.s.nominal, np.zeros((N, 0)), ref, np.array([[7.0, 1.0, 0.4]]))
        solver.set_initial_guess(z, np.zeros((N, 2)))
        solver.make_step(z[0])
        assert solver.stats.status is Status.CONVERGED, solver.stats.sentence
        solvers.append(solver)
    assert fallback() == "fatrop"
    assert solvers[0].nlp.stats()["nx"] == [len(ocp.z)] * (N + 1), "stage by stage, not one dense problem"
    assert solvers[0].stats.cost == pytest.approx(solvers[1].stats.cost, rel=1e-3)
    np.testing.assert_allclose(solvers[0].z, solvers[1].z, atol=1e-3)


def test_a_plugin_that_never_returns_is_given_up():
    assert answers_in_time("pass") and not answers_in_time("raise SystemExit(3)")
    assert not answers_in_time("while True: pass", 0.3)


def test_a_solver_that_casadi_lacks_is_refused(monkeypatch):
    monkeypatch.setattr(ca, "has_nlpsol", lambda name: name == "ipopt")
    assert fallback() == "ipopt"
    with pytest.raises(ValueError, match="expected a solver that this CasADi has"):
        CasadiNmpc(avoiding_ocp(), "fatrop")


@pytest.mark.parametrize("solver", ("rti", "converged", "ipopt"))
def test_an_obstacle_that_cannot_be_cleared_is_said(solver):
    ocp = avoiding_ocp()
    ref, z = straight(ocp)
    made = CasadiNmpc(ocp, "ipopt") if solver == "ipopt" else Nmpc(ocp, solver)
    made.set_parameters(ocp.s.nominal, np.zeros((N, 0)), ref, np.array([[12.0, 0.3, 9.0]]))
    made.set_initial_guess(z, np.zeros((N, 2)))
    for _ in range(8):
        made.make_step(z[0])
        assert made.stats.status in (Status.BLOCKED, Status.NOT_CLOSED) and made.stats.sentence
        assert np.all(made.w <= ocp.w.upper + 1e-6) and np.all(made.w >= ocp.w.lower - 1e-6)
    assert made.stats.status is Status.BLOCKED and made.stats.gap < 0 < made.stats.touch <= N


def test_a_step_before_parameters_is_refused():
    for solver in (Nmpc(small_ocp()), CasadiNmpc(small_ocp(), "ipopt")):
        with pytest.raises(ValueError, match=r"expected set_parameters .* before make_step"):
            solver.make_step(small_ocp().z.nominal)


@pytest.mark.parametrize("mode", ("rti", "converged"))
def test_numbers_that_are_not_finite_are_said_and_forgotten(mode):
    ocp = avoiding_ocp()
    ref, z = straight(ocp)
    solver = Nmpc(ocp, mode)
    solver.set_initial_guess(z, np.zeros((N, 2)))
    solver.set_parameters(np.full(len(ocp.s), np.nan), np.zeros((N, 0)), ref)
    solver.make_step(z[0])
    assert solver.stats.status is Status.NOT_FINITE and not solver.stats.status.usable
    solver.set_parameters(ocp.s.nominal, np.zeros((N, 0)), ref)
    solver.make_step(z[0])
    assert solver.stats.status.usable and np.isfinite(solver.z).all() and np.isfinite(solver.stats.cost)


def test_every_outcome_has_its_sentence_and_only_whole_plans_are_driven():
    assert all(len(status.value) > 20 for status in Status)
    driven = {status.name for status in Status if status.usable}
    halts = {"BLOCKED", "POSITION_UNKNOWN", "STEERING_STUCK", "SENSORS_DISAGREE"}
    assert driven == {"CONVERGED", "ITERATED", "OUT_OF_ITERATIONS", "LATE"} | halts


@pytest.mark.parametrize("wrong", ({"ref": np.zeros((3, 4))}, {"s": np.zeros(1)}, {"obstacles": np.zeros((3, 3))}))
def test_parameters_of_another_shape_are_refused(wrong):
    ocp = plain_ocp()
    given = {"s": ocp.s.nominal, "r": np.zeros((40, 0)), "ref": np.zeros((41, 4)), "obstacles": None, **wrong}
    with pytest.raises(ValueError, match="expected"):
        Nmpc(ocp).set_parameters(**given)


@pytest.mark.study
def test_histories_follow_the_plan():
    ocp = rut_ocp()
    model, solver = ocp.model, Nmpc(ocp)
    memory = np.zeros(len(model.cells))
    z = np.tile(ocp.z.pack(u=5.0, steer=0.2, omega_z=0.3), (21, 1))
    solver.set_initial_guess(z, np.zeros((20, 2)))
    r = solver.histories(memory, ocp.s.nominal)
    names = [signal.name for memory in model.memories for signal in memory.provides]
    assert r.shape == (20, len(names))
    provided = dict(zip(names, r.T, strict=True))
    assert provided["rut_path_l"][-1] > provided["rut_path_l"][0] >= 0, (
        "the front wheels leave shear path that the rear ones meet later"
    )
    assert abs(provided["rut_offset_l"][-1]) > 0.01, "in a turn the rut lies beside the rear wheels"
