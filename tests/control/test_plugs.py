"""The model in other tools' forms computes what the model computes."""

import re
import subprocess
import sys
import textwrap

import casadi as ca
import numpy as np
import pytest

from benchmarks.guide.blocks import run_page
from drives import PROJECT, clay_bicycle, reference_vehicle
from softsoil.codegen.compiled import find_compiler
from softsoil.control.nmpc import Nmpc
from softsoil.control.nmpc_casadi import programme, write_solver
from softsoil.control.ocp import REFERENCE, Ocp, OcpSettings
from softsoil.control.plugs_acados import to_acados, to_acados_ocp
from softsoil.control.plugs_do_mpc import do_mpc_controller, to_do_mpc
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout, Signal

Z0 = {"u": 5.0, "v": 0.1, "omega_z": 0.2, "steer": 0.1}


def ocp(model: Model | None = None, steps: int = 10) -> Ocp:
    return Ocp(model or clay_bicycle(), reference_vehicle(), OcpSettings(steps=steps, dt=0.1, obstacles=0))


def linear_bicycle() -> Model:
    """Small and quick: linear tyres on the reference vehicle's axles."""
    v = reference_vehicle()
    x, u = clay_bicycle().x, clay_bicycle().u
    stiffness = Layout.of(Signal("stiffness", "N/rad", "of an axle", 3e4, 0.0, 1e6))

    def rhs(q):
        front = q["stiffness"] * (q["steer"] - (q["v"] + v.l_f * q["omega_z"]) / q["u"])
        rear = -q["stiffness"] * (q["v"] - v.l_r * q["omega_z"]) / q["u"]
        cos, sin, axle = ca.cos(q["psi"]), ca.sin(q["psi"]), q["v"] + v.l_f * q["omega_z"]
        return {
            "x": q["u"] * cos - axle * sin, "y": q["u"] * sin + axle * cos, "psi": q["omega_z"], "u": q["a_x"],
            "v": (front + rear) / v.mass - q["u"] * q["omega_z"],
            "omega_z": (front * v.l_f - rear * v.l_r) / v.yaw_inertia,
        }  # fmt: skip

    return Model.of("linear", x, u, stiffness, x, rhs, lambda q: {name: q[name] for name in x.names})


def test_do_mpc_model_has_the_same_rates():
    problem = ocp()
    theirs = to_do_mpc(problem)
    z, w, s = problem.z.pack(Z0), np.array([0.1, 0.3]), problem.s.nominal
    ours = np.array(problem.dynamics()(z, w, np.zeros(0), s)[0]).ravel()
    rates = ca.Function("rates", [theirs.x, theirs.u, theirs.z, theirs.tvp, theirs.p], [theirs._rhs])
    found = np.array(rates(z, w, np.zeros(0), np.zeros(len(REFERENCE)), s)).ravel()
    np.testing.assert_allclose(found, ours, rtol=1e-12)


def test_do_mpc_drives_the_model_to_the_path():
    problem = ocp(linear_bicycle(), steps=15)
    places = {"x": lambda k: 0.5 * k, "y": lambda k: 0.4, "psi": lambda k: 0.0, "u": lambda k: 5.0}
    mpc = do_mpc_controller(problem, lambda k, name: places[name](k), problem.s.nominal)
    z = problem.z.pack(u=5.0)
    mpc.x0 = z
    mpc.set_initial_guess()
    w = np.asarray(mpc.make_step(z.reshape(-1, 1))).ravel()
    assert mpc.solver_stats["success"]
    assert w[0] > 0.05, "the path lies to the left"


@pytest.mark.parametrize("whole", (True, False))
def test_acados_fields_hold_the_same_rates(whole):
    problem = ocp()
    source = problem if whole else problem.model
    fields = to_acados(source, "softsoil_model")
    explicit = ca.Function("explicit", [fields.x, fields.u, fields.p], [fields.f_expl_expr])
    implicit = ca.Function("implicit", [fields.x, fields.xdot, fields.u, fields.p], [fields.f_impl_expr])
    x = problem.z.pack(Z0)[: fields.x.numel()]
    u = np.array([0.1, 0.3]) if whole else problem.model.external.nominal
    p = problem.s.nominal[: fields.p.numel()]
    ours = problem.dynamics()(x, u, np.zeros(0), p)[0] if whole else problem.model.ode()(x, u, p)
    found = explicit(x, u, p)
    np.testing.assert_allclose(np.array(found), np.array(ours), rtol=1e-12)
    np.testing.assert_allclose(np.array(implicit(x, found, u, p)), 0.0, atol=1e-9)
    assert len(fields.x_labels) == fields.x.numel() and len(fields.p_labels) == fields.p.numel()


@pytest.mark.parametrize("obstacles", (0, 2))
def test_the_acados_problem_has_the_same_cost_and_limits(obstacles):
    """Costs as acados adds them up, stages times the step and the last one as it is, against the programme's objective."""
    model = clay_bicycle() if obstacles else linear_bicycle()
    problem = Ocp(model, reference_vehicle(), OcpSettings(steps=4, dt=0.1, obstacles=obstacles))
    fields, rng, n = to_acados_ocp(problem), np.random.default_rng(0), 4
    m, dt = fields.model, problem.settings.dt
    z = problem.z.pack(Z0) + 0.05 * rng.standard_normal((n + 1, len(problem.z)))
    w = 0.1 * rng.standard_normal((n, 2))
    ref, places = rng.standard_normal((n + 1, 4)), rng.uniform(4.0, 8.0, (n + 1, 3 * obstacles))
    s, r = problem.s.nominal, np.zeros(len(problem.r))
    p = [np.concatenate([s, r, ref[k], places[k]]) for k in range(n + 1)]
    stage = ca.Function("stage", [m.x, m.u, m.p], [m.cost_expr_ext_cost, m.con_h_expr])
    last = ca.Function("last", [m.x, m.p], [m.cost_expr_ext_cost_e, m.con_h_expr_e])
    total = dt * sum(float(stage(z[k], w[k], p[k])[0]) for k in range(n)) + float(last(z[n], p[n])[0])
    form = programme(problem)
    values = ca.Function("values", [form.nlp["x"], form.nlp["p"]], [form.nlp["f"], form.nlp["g"]])
    f, g = values(form.pack(z, w), np.concatenate([s, np.zeros(len(r) * n), ref.ravel(), places.ravel()]))
    assert total == pytest.approx(float(f), rel=1e-12)
    rows = (stage(z[2], w[2], p[2])[1], last(z[n], p[n])[1])
    theirs = np.array(g).ravel()
    for h, least, soft in zip(rows, ("lh", "lh_e"), ("idxsh", "idxsh_e"), strict=True):
        h = np.array(h).ravel()
        assert all(np.isclose(theirs, value, rtol=1e-12).any() for value in h)
        assert len(h) == len(getattr(fields.constraints, least)) == len(getattr(fields.constraints, soft))
    assert rows[0].numel() == 3 * obstacles + (2 if problem.bears else 0)
    boxes = len(problem.state_box)
    assert len(fields.cost.zl) == boxes + rows[0].numel() and len(fields.cost.Zu_e) == boxes + rows[1].numel()
    assert fields.cost.zl_e[0] == pytest.approx(dt * problem.settings.weights.slack)
    assert fields.cost.Zl[0] == pytest.approx(problem.settings.weights.slack_squared)
    np.testing.assert_array_equal(fields.constraints.ubu, problem.w.upper)
    np.testing.assert_array_equal(
        [fields.constraints.lbx, fields.constraints.ubx], np.array(list(problem.state_box.values())).T
    )
    assert len(fields.parameter_values) == m.p.numel() == len(m.p_labels)
    assert m.p_labels[-1:] == (["obstacle_1_radius"] if obstacles else ["ref_u"])
    assert fields.solver_options.N_horizon == n and fields.solver_options.tf == pytest.approx(n * dt)


def test_a_name_that_is_no_identifier_is_refused():
    with pytest.raises(ValueError, match="starts with a letter"):
        to_acados(ocp(), "1; rm")


@pytest.mark.study
def test_the_whole_solver_as_one_c_file_finds_the_same_plan(tmp_path):
    compiler = find_compiler()
    if compiler is None:
        pytest.skip("no C compiler")
    problem = ocp(linear_bicycle(), steps=5)
    source = write_solver(problem, tmp_path)[0]
    library = tmp_path / "solver.so"
    subprocess.run([compiler, "-O0", "-shared", "-fPIC", str(source), "-o", str(library), "-lm"], check=True)
    ref = np.column_stack([0.5 * np.arange(6), np.full(6, 0.4), np.zeros(6), np.full(6, 5.0)])
    ours = Nmpc(problem, "converged", tolerance=1e-6)
    ours.set_parameters(problem.s.nominal, np.zeros((5, 0)), ref)
    z0 = problem.z.pack(u=5.0)
    ours.set_initial_guess(np.tile(z0, (6, 1)), np.zeros((5, 2)))
    ours.make_step(z0)
    form = programme(problem)
    lower, upper = form.lower.copy(), form.upper.copy()
    lower[: len(z0)] = upper[: len(z0)] = z0
    p = np.concatenate([problem.s.nominal, ref.ravel()])
    found = ca.external("nmpc", str(library))(
        x0=form.pack(np.tile(z0, (6, 1)), np.zeros((5, 2))),
        p=p,
        lbx=lower,
        ubx=upper,
        lbg=form.g_lower,
        ubg=form.g_upper,
    )
    _, w = form.unpack(np.array(found["x"]).ravel())
    np.testing.assert_allclose(w, ours.w, atol=2e-3)


def test_the_do_mpc_example_of_the_docs_runs_as_printed():
    text = (PROJECT / "docs" / "reference" / "plugs.md").read_text(encoding="utf-8")
    blocks = re.findall(r"(?:^    .*\n|^\n)+", text, re.M)
    (printed,) = [block for block in blocks if "mpc.make_step" in block]
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(printed)], capture_output=True, text=True, cwd=PROJECT, check=False
    )
    assert done.returncode == 0, done.stderr[-1000:]
    steer_rate, _ = map(float, re.findall(r"-?[\d.]+(?:e-?\d+)?", done.stdout.splitlines()[-1]))
    assert steer_rate > 0.05, "the path lies to the left"


def test_the_example_with_histories_prints_what_it_says(tmp_path):
    text = (PROJECT / "docs" / "reference" / "plugs.md").read_text(encoding="utf-8")
    (step,) = run_page(text, tmp_path)
    assert step.expected and step.faults() == []
