"""The C library against the CasADi original: steps, rollouts, forces, and the filter."""

import platform

import casadi as ca
import numpy as np
import pytest

from c_folders import NAMES, SCALAR, declared, library
from drives import clay_drive, reference_vehicle
from softsoil.codegen.c_library import build
from softsoil.codegen.c_library.binding import CFilter, CLibrary
from softsoil.codegen.c_library.build import FLAGS
from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.codegen.discretize import start_memory, step_with_memory
from softsoil.codegen.sampling import STEP
from softsoil.control.c_estimator import c_library_texts, c_parts
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.terrain_filter import TerrainFilter
from softsoil.recording.forward import HELD_INPUTS
from softsoil.recording.states import measured_states
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.wheel import Contact
from softsoil.windows.inputs import measured_inputs

SAME = 1e-9
"""What the library promises; rounding alone is about 1e-12."""
NOISE = np.array([1.2, 1.2, 0.0175, 0.25, 0.25, 0.0175])
NARROWER = [(*FLAGS, "-mno-avx512f"), ("-O2",)] if platform.machine() in ("x86_64", "AMD64") else [("-O2",)]
VARIANTS = {"vectors": FLAGS, "scalar": SCALAR, **{" ".join(flags[-1:]): flags for flags in NARROWER}}
"""The widest vectors of this machine, none, and what lies between."""
BUILDS = [
    pytest.param(name, flags, id=f"{name}-{words}", marks=[pytest.mark.study] if flags in NARROWER else [])
    for name in NAMES for words, flags in VARIANTS.items()
]  # fmt: skip

pytestmark = pytest.mark.compiler


def drive(model, seconds=3.0):
    log = clay_drive(seconds)
    return measured_inputs(log, model.external)[0], measured_states(log)


def casadi_rollout(model, dt, x0, u, p):
    """(N + 1, n_x) states in the CasADi virtual machine."""
    step, m = step_with_memory(model, dt), start_memory(model)(x0, u[0], p)
    x = [np.asarray(x0)]
    for row in u:
        following, m = step(x[-1], m, row, p)
        x.append(np.asarray(following)[:, 0])
    return np.array(x)


@pytest.mark.parametrize(("name", "flags"), BUILDS)
def test_steps_and_rollouts_equal_casadi(name, flags):
    lib, model = library(name, flags), c_parts(declared(name)).model
    u, _ = drive(model)
    p, x0 = model.p.nominal, model.x.pack(u=6.0, v=0.1, omega_z=0.2)
    expected = casadi_rollout(model, STEP, x0, u[:150], p)
    for wrong in ((np.full_like(x0, np.nan), u[0]), (x0, np.full_like(u[0], np.inf))):
        with pytest.raises(ValueError, match="not a finite number"):
            lib.history(p, *wrong)
    x, m = x0, lib.history(p, x0, u[0])
    for k in range(150):
        x, m = lib.step(p, STEP, x, m, u[k])
        assert np.abs(x - expected[k + 1]).max() < SAME
    # A number of trajectories that fills no whole number of vectors, each from a state of its own.
    start = np.repeat(x0[:, None], 11, 1)
    start[3] += 0.1 * np.arange(11)
    found = lib.rollout(p, STEP, start, np.repeat(u[:150, :, None], 11, 2))
    assert np.abs(found[:, :, 0] - expected[1:]).max() < SAME
    last = casadi_rollout(model, STEP, start[:, 10], u[:150], p)
    assert np.abs(found[:, :, 10] - last[1:]).max() < SAME


@pytest.mark.parametrize("name", NAMES)
def test_time_steps_are_free(name):
    lib, model = library(name), c_parts(declared(name)).model
    u, _ = drive(model)
    p, x0 = model.p.nominal, model.x.pack(u=6.0, v=0.1, omega_z=0.2)
    expected = casadi_rollout(model, 0.007, x0, u[:50], p)
    x, m = x0, lib.history(p, x0, u[0])
    for k in range(50):
        x, m = lib.step(p, 0.007, x, m, u[k])
    assert np.abs(x - expected[50]).max() < SAME


def test_forces_equal_the_law():
    lib, wheel = library("plain"), reference_vehicle().wheel
    names = ("v_x", "v_y", "omega", "load", "yaw_rate", "steer_rate", "dv_y", "entry_path", "overlap")
    s = [ca.SX.sym(name) for name in names]
    force = declared("plain").force_law()(CLAY, wheel, Contact(*s))
    law = ca.Function("law", s, [force.f_x, force.f_y, force.m_y, force.m_z, force.sinkage, force.exit_path])
    rng = np.random.default_rng(0)
    for _ in range(50):
        contact = rng.uniform([1, -2, 3, 500, -1, -1, -2, 0, 0], [10, 2, 30, 6000, 1, 1, 2, 0.1, 1])
        expected = np.array([float(v) for v in law(*contact)])
        found = lib.force(list(CLAY.parameters().values()), contact)
        assert np.allclose(found, expected, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize(("name", "flags"), BUILDS)
def test_filter_equals_the_estimators(name, flags):
    """Estimate, covariance and consistency, with dropouts, a steering that is missing for a while, and angles across pi."""
    lib, model = library(name, flags), c_parts(declared(name)).model
    u, y = drive(model)
    y[:, 2] += 3.0
    y[:, :2] = y[:, :2] @ np.array([[np.cos(3.0), np.sin(3.0)], [-np.sin(3.0), np.cos(3.0)]])
    extra = len(model.x) - 6
    x0, std0 = np.concatenate([y[0], [0.6] * extra]), np.concatenate([NOISE, [0.02] * extra])
    theirs = TerrainFilter(model, STEP, NOISE)
    theirs.start(x0, std0)
    options = lib.defaults()
    options.r_std[:] = NOISE
    ours = CFilter(lib, x0, std0, options)
    rng = np.random.default_rng(1)
    turn = model.x.index("psi")
    for k in range(160):
        inputs = np.where(60 <= k < 100, np.nan, u[k])
        theirs.predict(inputs)
        ours.predict(inputs, STEP)
        assert (ours.state.missing > HELD_INPUTS) == (60 + HELD_INPUTS / STEP <= k + 1 < 101), k
        if k % 2:
            z = y[k + 1] + rng.normal(size=6) * NOISE
            z[k % 6] = np.nan if k % 7 == 0 else z[k % 6]
            seen = theirs.update(z)
            ours.update(z, ours.state.t)
            assert abs(ours.state.nis - seen.nis) < 1e-7 and ours.state.dof == seen.dof
        away = ours.x - theirs.ukf.x
        away[turn] -= 2 * np.pi * np.round(away[turn] / (2 * np.pi))
        assert np.abs(away).max() < SAME
        assert np.abs(ours.P - theirs.ukf.P).max() < SAME
    assert ours.state.updates == 80 and abs(ours.x[-1] - 0.6) > 1e-4


def test_the_vehicle_s_error_of_n_is_in_the_library_s_bars(tmp_path):
    """Filter and horizon: the same n, variances larger by (n_error n)^2."""
    own = declared("plain")
    write_library(tmp_path, c_library_texts(Declaration(own.vehicle.with_(n_error=0.05), own.soil)))
    model, ends = c_parts(own).model, []
    soil = [model.x.index(name) for name in ("n_f", "n_r")]
    u, y = drive(model, 10.0)
    for lib in (library("plain"), CLibrary(tmp_path, SCALAR)):
        c, horizon = CFilter(lib, np.append(y[0], [0.6, 0.6]), np.append(NOISE, [0.1, 0.1])), CHorizon(lib)
        horizon.start(0.0)
        for k in range(len(u) - 1):
            c.predict(u[k], STEP)
            c.update(y[k + 1], c.state.t)
            horizon.push(u[k], y[k], k * STEP)
            horizon.update()
        assert horizon.head.windows > 1
        ends.append((c.x[soil], c.std[soil], horizon.n, horizon.std))
    (x, std, n, n_std), (other_x, other_std, other_n, other_n_std) = ends
    np.testing.assert_array_equal(x, other_x)
    np.testing.assert_array_equal(n, other_n)
    np.testing.assert_allclose(other_std**2 - std**2, (0.05 * x) ** 2, rtol=1e-9)
    np.testing.assert_allclose(other_n_std**2 - n_std**2, (0.05 * n) ** 2, rtol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_replay_is_the_loop(name):
    lib, model = library(name), c_parts(declared(name)).model
    u, y = drive(model)
    t = STEP * np.arange(len(u))
    x0 = np.concatenate([y[0], [0.6] * (len(model.x) - 6)])
    one, other = CFilter(lib, x0), CFilter(lib, x0)
    y[::2, 0] = np.nan  # measured in rows without an update only
    found = one.replay(t, u, y, every=2)
    for k in range(1, len(t)):
        other.predict(u[k - 1], t[k] - other.state.t)
        if k % 2 == 0:
            other.update(np.concatenate([y[k - 1, :1], y[k, 1:]]), t[k])
    assert np.array_equal(one.x, other.x) and np.array_equal(found["x"][-1], other.x)
    assert np.array_equal(one.P, other.P)


def test_a_library_in_the_cache_is_of_its_processor_and_compiler(tmp_path, monkeypatch):
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "softsoil_filter.c").write_text("int f(void) { return 1; }\n", encoding="utf-8")
    found = set()
    for processor, version in (("flags: avx512f", "gcc 12"), ("flags: sse2", "gcc 12"), ("flags: sse2", "gcc 14")):
        monkeypatch.setattr(build, "machine", lambda processor=processor: processor)
        monkeypatch.setattr(build, "compiler_version", lambda _, version=version: version)
        found.add(build.build_c_library(tmp_path).name)
    assert len(found) == 3
