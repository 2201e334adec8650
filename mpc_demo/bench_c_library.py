"""Speed of the generated C library: in a C loop, from Python, its forces alone, and rollouts for planners."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Callable, Iterator

import numpy as np

from softsoil.codegen.c_library.binding import CFilter, CLibrary
from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.text_cache import asked_for, texts_from_cache
from softsoil.control.c_estimator import c_library_texts
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.estimator.terrain import terrain_model
from softsoil.mpc_demo.bench_filter import DT, Q, R, U, Y, filterpy_filter
from softsoil.mpc_demo.bench_horizon import horizon_rows
from softsoil.mpc_demo.bench_rows import Row, microseconds

PAPER = "7.5-10.5 ms"
AGAINST = "FilterPy with the same model as NumPy code"
BATCH, HORIZON, ROWS = 200, 20, 50
"""Trajectories and steps of a rollout call; steps of a C loop."""
SIGMA_ROW = 24
"""Sigma points in a row of the library's arrays: 17 and idle ones."""


def c_library_rows(declared: Declaration) -> Iterator[Row]:
    """The rows of the C library without the declared effects (the same model as FilterPy's), and with them if there are any."""
    plain = Declaration(declared.vehicle.with_(effects={}), declared.soil, declared.law)
    with tempfile.TemporaryDirectory() as folder:
        write_library(folder, _texts(plain))
        library = CLibrary(folder)
        yield from _plain_rows(library, plain)
        yield from _more_rows(library)
        if declared.vehicle.effects:
            write_library(folder, _texts(declared))
            yield from _effect_rows(CLibrary(folder), library)
            yield from horizon_rows(declared, CLibrary(folder))


def _texts(declared: Declaration) -> dict[str, str]:
    return texts_from_cache(asked_for(declaration_toml(declared), DT), lambda: c_library_texts(declared, DT))


def _filter(library: CLibrary, policy: bool = False) -> CFilter:
    """A filter with Table-5 noise on its way; policy: with every rule, else prediction and update alone."""
    options = library.defaults()
    options.r_std[:] = np.sqrt(R)
    if not policy:
        options.gate_patience = options.gate_patience_rates = 0
        options.run_in, options.fastest = 0.0, np.inf
        options.change_sigmas = np.inf
    extra = library.sizes["x"] - 6
    x0 = np.concatenate([[0.0, 0.0, 0.0, 6.0, 0.1, 0.2], [0.5] * extra])
    return CFilter(library, x0, [0.1, 0.1, 0.01, 0.1, 0.1, 0.01, *[0.05] * extra], options)


def c_loop(library: CLibrary, every: int = 1, policy: bool = False) -> Callable[[], None]:
    """ROWS predictions, and an update after every `every` of them, in one call of the C library; policy: with every rule."""
    own = _filter(library, policy)
    t = DT * np.arange(ROWS + 1)
    u, y = np.tile(U, (ROWS + 1, 1)), np.tile(Y, (ROWS + 1, 1))
    start = bytes(own.state)

    def run() -> None:
        # The same stretch each time, from the same start: a kilobyte copied for ROWS steps.
        ctypes.memmove(ctypes.byref(own.state), start, len(start))
        own.replay(t, u, y, every)

    return run


def _plain_rows(library: CLibrary, declared: Declaration) -> Iterator[Row]:
    model = terrain_model(declared.build(), tied=False)
    x0 = model.x.pack(u=6.0, v=0.1, omega_z=0.2)
    p0 = np.array([0.1, 0.1, 0.01, 0.1, 0.1, 0.01, 0.05, 0.05]) ** 2
    theirs = filterpy_filter(model, DT, Q, R, x0, p0)

    def their_step() -> None:
        theirs.predict(u=U)
        theirs.update(Y)

    half, whole, python, forces, other = microseconds(
        c_loop(library, every=2), c_loop(library), _python_step(library), _forces(library), their_step
    )
    yield Row("clibrary_step_c", whole / ROWS, "us", AGAINST, other, PAPER)
    yield Row("clibrary_step_python", python, "us", AGAINST, other, PAPER)
    yield Row("clibrary_replay_per_step", half / ROWS, "us", AGAINST, other, PAPER)
    yield Row("clibrary_forces_alone", forces, "us", "prediction and update in a C loop", whole / ROWS)


def _python_step(library: CLibrary) -> Callable[[], None]:
    """A prediction and an update, each a call from Python."""
    own = _filter(library)
    own.u[:], own.y[:] = U, Y
    dt = ctypes.c_double(DT)

    def step() -> None:
        own.predict_held(dt)
        own.update_held(ctypes.c_double(own.state.t))

    return step


def _forces(library: CLibrary) -> Callable[[], None]:
    """The force evaluations of one prediction: what any filter on this model must pay."""
    own = _filter(library)
    points = np.repeat(np.asarray(own.x)[:, None], SIGMA_ROW, axis=1)
    out = np.empty(64 * SIGMA_ROW)
    p = np.asarray(library.defaults().p)
    arguments = [array.ctypes.data_as(ctypes.c_void_p) for array in (points, np.array(U), p, out)]
    function = library.c.softsoil_model_forces
    return lambda: function(*arguments)


def _rollout(library: CLibrary) -> Callable[[], object]:
    own = _filter(library)
    x0 = np.repeat(np.asarray(own.x)[:, None], BATCH, axis=1)
    u = np.repeat(np.tile(U, (HORIZON, 1))[:, :, None], BATCH, axis=2)
    u[:, 0] += 0.1 * np.sin(np.arange(BATCH) + 0.1 * np.arange(HORIZON)[:, None])
    p = np.asarray(library.defaults().p)
    m = library.history(p, x0[:, 0], u[0, :, 0])
    return lambda: library.rollout(p, DT, x0, u, m)


def _one_step(library: CLibrary) -> Callable[[], object]:
    own = _filter(library)
    p, x = np.asarray(library.defaults().p), np.array(own.x)
    m = library.history(p, x, U)
    arguments = [a.ctypes.data_as(ctypes.c_void_p) for a in (p, x, m, np.array(U))]
    function, dt = library.c.softsoil_step, ctypes.c_double(1e-9)
    return lambda: function(arguments[0], dt, arguments[1], arguments[2], arguments[3])


def _more_rows(library: CLibrary) -> Iterator[Row]:
    batch, single = microseconds(_rollout(library), _one_step(library))
    yield Row("rollout_step", batch / BATCH / HORIZON, "us", "softsoil_step, one at a time from Python", single)


def _effect_rows(library: CLibrary, plain: CLibrary) -> Iterator[Row]:
    with_effects, policy, without, python, rollout, other = microseconds(
        c_loop(library), c_loop(library, policy=True), c_loop(plain), _python_step(library), _rollout(library), _rollout(plain)
    )
    against = "the same without effects"
    yield Row("clibrary_step_c_effects", with_effects / ROWS, "us", against, without / ROWS)
    yield Row("clibrary_step_c_policy", policy / ROWS, "us", "the same without the policy", with_effects / ROWS)
    yield Row("clibrary_step_python_effects", python, "us", "the same in a C loop", with_effects / ROWS)
    each = BATCH * HORIZON
    yield Row("rollout_step_effects", rollout / each, "us", against, other / each)
