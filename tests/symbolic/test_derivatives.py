"""The tracing's derivatives, by differences of rollouts, against algorithmic differentiation of the model."""

import casadi as ca
import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.codegen.discretize import start_memory, step_with_memory
from softsoil.declaration.model_file import Declaration
from softsoil.recording.read import read_drive
from softsoil.refinement.fit import Free, Weights, _Problem
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import neutral
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import CLAY
from softsoil.windows.shooting import Shooting, shooting_drive

AGREE = 2e-5
"""Relative rms difference: what one-sided steps of 5e-6 of a parameter's scale leave of the curvature (1.2e-5 for n)."""
SCALES = {"n_f": 0.1, "kappa": 0.4, "transfer_height": 0.3, "steering_lag": 0.1, "yaw_moment": 500.0}


def tangent_step(model: Model, dt: float) -> ca.Function:
    """[x, dx, m, dm, u, p, dp] -> [x', dx', m', dm']: a step and its directional derivative."""
    x, _, p = model.symbols()
    m, u = ca.SX.sym("m", len(model.cells)), ca.SX.sym("u", len(model.external))
    dx, dm, dp = (ca.SX.sym(f"d{name}", of.numel()) for name, of in (("x", x), ("m", m), ("p", p)))
    after = step_with_memory(model, dt)(x, m, u, p)
    moved = [ca.jtimes(part, ca.vertcat(x, m, p), ca.vertcat(dx, dm, dp)) for part in after]
    return ca.Function("tangent", [x, dx, m, dm, u, p, dp], ca.cse([after[0], moved[0], after[1], moved[1]]))


def algorithmic(shooting: Shooting, p: np.ndarray, name: str) -> np.ndarray:
    """(N, 6) derivative of the first window's states by a parameter, memory before the window included."""
    model, drive = shooting.model, shooting.drive
    step = tangent_step(model, drive.dt)
    direction = np.zeros(len(p))
    for each in ("n_f", "n_r") if name == "n_f" else (name,):
        direction[model.p.index(each)] = 1.0
    states = np.column_stack([drive.smooth, np.tile(model.x.nominal[6:], (len(drive.t), 1))])
    first = start_memory(model)
    x, u, q = (ca.SX.sym(s, n) for s, n in (("x", states.shape[1]), ("u", drive.inputs.shape[1]), ("p", len(p))))
    by_p = ca.Function("by_p", [x, u, q], [ca.jtimes(first(x, u, q), q, ca.DM(direction))])
    m, dm = first(states[0], drive.inputs[0], p), by_p(states[0], drive.inputs[0], p)
    row = int(shooting.rows[0])
    for k in range(row):
        _, _, m, dm = step(states[k], np.zeros(states.shape[1]), m, dm, drive.inputs[k], p, direction)
    x, dx, found = states[row], np.zeros(states.shape[1]), []
    for k in range(row, row + shooting.steps):
        x, dx, m, dm = step(x, dx, m, dm, drive.inputs[k], p, direction)
        found.append(np.array(dx)[:6, 0])
    return np.array(found)


@pytest.fixture(scope="module")
def shooting() -> Shooting:
    vehicle = reference_vehicle()
    model = Declaration(vehicle, CLAY).build()
    model = neutral(model, catalogue(vehicle)["steering_lag"])
    return Shooting(model, shooting_drive(read_drive(MULTI_LOG), model, 1.0), 0.5)


@pytest.mark.parametrize("name", SCALES)
def test_differences_are_the_derivatives(shooting: Shooting, name: str) -> None:
    p = shooting.model.p.nominal
    p[shooting.model.p.index("steering_lag")] = 0.05
    sets = ("n_f", "n_r") if name == "n_f" else (name,)
    signal = shooting.model.p[name]
    free = Free(name, sets, SCALES[name], signal.lower, signal.upper)
    problem = _Problem((shooting,), (np.array([0]),), Weights(np.ones(6)), (free,), p[None])
    value = np.array([p[shooting.model.p.index(name)]])
    differences = problem.jacobian(value, problem.residual(value))[..., 0].reshape(-1, 6)
    exact = algorithmic(shooting, p, name)
    channels = slice(2, 6)  # x and y follow from these
    size = np.sqrt(np.mean(exact[:, channels] ** 2))
    assert size > 0
    assert np.sqrt(np.mean((differences - exact)[:, channels] ** 2)) < AGREE * size
