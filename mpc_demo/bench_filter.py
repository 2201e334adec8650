"""Speed of the terrain filter: from Python, in C alone, over a log, and from model to machine code."""

from __future__ import annotations

import importlib.util
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from softsoil.codegen.compiled import CompiledFunction, at_points
from softsoil.codegen.discretize import discretize
from softsoil.codegen.numpy_code import write_numpy
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.terrain import estimate_terrain, terrain_model
from softsoil.estimator.ukf import UnscentedKalmanFilter
from softsoil.estimator.unscented import UnscentedScaling, predict_function
from softsoil.mpc_demo.bench_rows import Row, microseconds, seconds
from softsoil.recording.drive import Recording
from softsoil.symbolic.model import Model
from softsoil.symbolic.wheel import Contact, Wheel

DT = 0.012
Q = np.array([0.02, 0.02, 0.002, 0.1, 0.05, 0.02, 0.002, 0.002]) ** 2 * DT
R = np.array([1.2, 1.2, 0.0175, 0.25, 0.25, 0.0175]) ** 2
"""Table-5 noise."""
U = np.array([0.1, 0.2, 0.3, 18.0, 18.0, 18.0, 18.0])
Y = np.array([0.1, 0.05, 0.01, 6.0, 0.1, 0.2])


def filter_rows(declared: Declaration, drive: Recording) -> Iterator[Row]:
    """The rows of the filter for the declared model without effects, on one clean drive."""
    model = terrain_model(declared.plain(), tied=False)
    x0 = model.x.pack(u=6.0, v=0.1, omega_z=0.2)
    p0 = np.array([0.1, 0.1, 0.01, 0.1, 0.1, 0.01, 0.05, 0.05]) ** 2
    ours = UnscentedKalmanFilter(model, DT, q=Q, r=R, x0=x0, p0=p0)
    theirs = filterpy_filter(model, DT, Q, R, x0, p0)

    def reset() -> None:
        ours.x, ours.P = x0, np.diag(p0)
        theirs.x, theirs.P = x0.copy(), np.diag(p0)

    def step() -> None:
        ours.predict(U)
        ours.update(Y)

    def their_step() -> None:
        theirs.predict(u=U)
        theirs.update(Y)

    reset()
    step()
    python, c, other = microseconds(step, in_c(ours), their_step)
    paper, against = "7.5-10.5 ms", "FilterPy with the same model as NumPy code"
    yield Row("ukf_step_python", python, "us", against, other, paper)
    yield Row("ukf_step_c", c, "us", against, other, paper)
    yield _replay(declared, drive, other)
    yield _force(declared)
    yield from _rebuild(model)


def _replay(declared: Declaration, drive: Recording, filterpy_us: float) -> Row:
    """A whole log without reading it: per 12 ms row, one prediction and half an update."""
    model = declared.plain()
    n0 = float(declared.soil.n)
    short = drive.between(drive.t[0], drive.t[0] + 1.0)
    estimate_terrain(short, model, n0)
    # The filter is built anew each time; the difference of a long and a short log leaves the steps alone.
    # Building takes longer than many rows and varies: the least of a few runs of each.
    longest = min(seconds(lambda: estimate_terrain(drive, model, n0)) for _ in range(3))
    shortest = min(seconds(lambda: estimate_terrain(short, model, n0)) for _ in range(3))
    taken = (longest - shortest) * 1e6 / (len(drive) - len(short))
    return Row("log_replay_per_step", taken, "us", "FilterPy, prediction and update", filterpy_us, "7.5-10.5 ms")


def _force(declared: Declaration) -> Row:
    """One wheel's forces in C on buffers against an ordinary call of the same compiled function."""
    v_x, v_y, omega, load, yaw = (ca.SX.sym(name) for name in ("v_x", "v_y", "omega", "load", "yaw_rate"))
    wheel = Wheel(declared.vehicle.radius, declared.vehicle.width)
    force = declared.force_law()(declared.soil, wheel, Contact(v_x, v_y, omega, load, yaw))
    inputs = [v_x, v_y, omega, load, yaw]
    function = CompiledFunction(ca.Function("force", inputs, [ca.vertcat(force.f_x, force.f_y)]))
    values = (6.0, -0.5, 19.0, 3400.0, 0.3)
    for array, value in zip(function.inputs, values, strict=True):
        array[...] = value
    ours, ordinary = microseconds(function.run, lambda: function.function(*values))
    return Row("force_call", ours, "us", "an ordinary CasADi call of the same C", ordinary, "200-400 us")


def _rebuild(model: Model) -> Iterator[Row]:
    """From the equations to a prediction step in machine code, with an empty cache and with a full one."""

    def build() -> None:
        step = discretize(model, DT)
        many, parts = at_points(step, 2 * len(model.x) + 1)
        CompiledFunction(predict_function(step, model.x, UnscentedScaling(), many), parts=parts)

    with tempfile.TemporaryDirectory() as folder, cache_at(folder):
        cold, cached = seconds(build), seconds(build)
    yield Row("rebuild_cold", cold, "s", "the same with the code in the cache", cached)
    yield Row("rebuild_cached", cached, "s", "the same with an empty cache", cold)


@contextmanager
def cache_at(folder: str) -> Iterator[None]:
    """The cache of compiled functions in `folder` for a while."""
    before = os.environ.get("SOFTSOIL_CACHE")
    os.environ["SOFTSOIL_CACHE"] = folder
    try:
        yield
    finally:
        del os.environ["SOFTSOIL_CACHE"]
        if before is not None:
            os.environ["SOFTSOIL_CACHE"] = before


def in_c(ukf: UnscentedKalmanFilter) -> Callable[[], None]:
    """Predict and update in C alone: both functions in turn on their buffers, as a step from Python has left them.

    The two calls from Python into the buffers are in it (about 0.1 us each), nothing else is.
    """
    predict, update = ukf.compiled

    def both() -> None:
        predict.run()
        update.run()

    return both


def numpy_function(function: ca.Function, name: str) -> Callable[..., np.ndarray]:
    """The CasADi function as NumPy code, written to a file and imported from it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.py"
        path.write_text(write_numpy(function, name), encoding="utf-8")
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None:
            raise OSError(f"{path}: expected a module, found none")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return getattr(module, name)


def filterpy_filter(model: Model, dt: float, q: np.ndarray, r: np.ndarray, x0: np.ndarray, p0: np.ndarray) -> Any:
    """FilterPy's unscented filter on the same model, written as NumPy code; ValueError where FilterPy is not installed."""
    try:
        from filterpy.kalman import MerweScaledSigmaPoints
        from filterpy.kalman import UnscentedKalmanFilter as FilterPy
    except ImportError:
        raise ValueError("bench: expected FilterPy to compare with (pip install filterpy), found none") from None
    step = numpy_function(discretize(model, dt), "step")
    p, n = model.p.nominal, len(model.x)
    points = MerweScaledSigmaPoints(n, alpha=1.0, beta=2.0, kappa=0.0)
    other = FilterPy(
        n, len(model.y), dt, hx=lambda x: x[: len(model.y)], fx=lambda x, dt, u: step(x, u, p), points=points
    )
    other.x, other.P, other.Q, other.R = x0.copy(), np.diag(p0), np.diag(q), np.diag(r)
    return other
