"""Generated C: the same numbers as the symbols, built once, and the virtual machine where there is no compiler."""

import shutil
import subprocess
import tempfile
import warnings

import casadi as ca
import numpy as np
import pytest

import softsoil.codegen.compiled as compiled
from drives import clay_bicycle, reference_vehicle
from softsoil.codegen.c_source import check_c_name, write_c
from softsoil.codegen.compiled import CompiledFunction, at_points, find_compiler
from softsoil.codegen.discretize import advance_memory, discretize, read_memory, start_memory, step_with_memory
from softsoil.codegen.lanes import write_group, write_lanes
from softsoil.codegen.predictor import substeps_for
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.bench_filter import numpy_function
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.wheel import Contact, Wheel, force_law

X = np.array([1.0, 2.0, 0.3, 6.0, 0.2, 0.3])
U = np.array([0.1, 0.2, 0.3, 18.0, 18.5, 18.0, 18.5])
needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def square() -> ca.Function:
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y", 2, 3)
    return ca.Function("square", [x, y], [x * x, y + 1], ["x", "y"], ["xx", "yy"])


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SOFTSOIL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def no_compiler(monkeypatch):
    monkeypatch.setattr(compiled, "find_compiler", lambda: None)
    compiled._warn_no_compiler.cache_clear()
    yield
    compiled._warn_no_compiler.cache_clear()


@pytest.mark.compiler
@needs_compiler
def test_c_and_symbols_agree_on_the_model():
    step = discretize(clay_bicycle(), 0.012)
    p = clay_bicycle().p.nominal
    fast = CompiledFunction(step)
    assert fast.is_compiled
    assert np.allclose(fast(X, U, p), np.asarray(step(X, U, p))[:, 0], rtol=1e-13, atol=1e-15)


@pytest.mark.compiler
@needs_compiler
def test_c_example_prints_the_numbers_of_python(tmp_path):
    """The file that `write_c` makes is all that a C program needs."""
    step, p = discretize(clay_bicycle(), 0.012), clay_bicycle().p.nominal
    write_c([step], tmp_path)
    values = [", ".join(repr(float(v)) for v in vector) for vector in (X, U, p)]
    (tmp_path / "main.c").write_text(
        f"""#include <stdio.h>
#include "model.h"
int main(void) {{
  double x[] = {{{values[0]}}}, u[] = {{{values[1]}}}, p[] = {{{values[2]}}}, next[6], w[step_SZ_W];
  long long iw[step_SZ_IW + 1];
  const double *arg[step_SZ_ARG] = {{x, u, p}};
  double *res[step_SZ_RES] = {{next}};
  if (step(arg, res, iw, w, 0)) return 1;
  for (int i = 0; i < 6; ++i) printf("%.17g\\n", next[i]);
  return 0;
}}
""",
        encoding="utf-8",
    )
    command = [find_compiler(), "-std=c99", "-O1", "main.c", "model.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    printed = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=True).stdout.split()
    assert np.allclose([float(v) for v in printed], np.asarray(step(X, U, p))[:, 0], rtol=1e-13, atol=1e-15)


def test_generated_c_is_the_same_on_every_run(tmp_path):
    first, second = (write_c([discretize(clay_bicycle(), 0.012)], tmp_path / name)[0] for name in ("a", "b"))
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.compiler
@needs_compiler
def test_cache_is_built_once_and_keyed_by_content(own_cache, monkeypatch):
    CompiledFunction(square())
    built = sorted(own_cache.iterdir())
    assert [path.suffix for path in built if path.name.startswith("square")] == [".so"]
    monkeypatch.setattr(compiled, "_compile", lambda *_: pytest.fail("compiled again"))
    again = CompiledFunction(square())
    assert again.is_compiled and sorted(own_cache.iterdir()) == built


@pytest.mark.compiler
@needs_compiler
def test_other_content_is_another_library(own_cache):
    x = ca.SX.sym("x")
    functions = [CompiledFunction(ca.Function("f", [x], [k * x])) for k in (2.0, 3.0)]
    assert [float(f(1.0)[0]) for f in functions] == [2.0, 3.0]


def test_without_a_compiler_one_warning_and_the_same_numbers(no_compiler):
    with pytest.warns(UserWarning, match="no C compiler found"):
        slow = CompiledFunction(square())
    assert not slow.is_compiled
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        CompiledFunction(square())
    xx, yy = slow([1.0, 3.0], np.zeros((2, 3)))
    assert np.array_equal(xx, [1.0, 9.0]) and np.array_equal(yy, np.ones((2, 3)))
    mapped, parts = at_points(discretize(clay_bicycle(), 0.012), 3)
    assert parts == () and mapped.size_in(0) == (6, 3)


def test_broken_compiler_falls_back_with_its_reason(own_cache, monkeypatch, tmp_path):
    fake = tmp_path / "cc"
    fake.write_text("#!/bin/sh\necho 'no room left' >&2\nexit 1\n", encoding="utf-8")
    fake.chmod(0o755)
    monkeypatch.setattr(compiled, "find_compiler", lambda: str(fake))
    with pytest.warns(UserWarning, match="no room left"):
        assert not CompiledFunction(square()).is_compiled


@pytest.mark.compiler
@needs_compiler
def test_cache_that_cannot_be_made_costs_only_the_cache(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("SOFTSOIL_CACHE", str(tmp_path / "file" / "cache"))
    assert CompiledFunction(square()).is_compiled


@pytest.mark.compiler
@needs_compiler
def test_compiler_without_native_code_is_used_all_the_same(own_cache, monkeypatch, tmp_path):
    old = tmp_path / "cc"
    old.write_text(
        f'#!/bin/sh\ncase "$*" in *-march=native*) echo "unknown flag" >&2; exit 1;; esac\nexec {find_compiler()} "$@"\n',
        encoding="utf-8",
    )
    old.chmod(0o755)
    monkeypatch.setattr(compiled, "find_compiler", lambda: str(old))
    assert CompiledFunction(square()).is_compiled


def test_unfit_inputs_and_buffers_are_named():
    function = CompiledFunction(square(), compiled=False)
    with pytest.raises(ValueError, match=r"expected 2 inputs \(x, y\), found 1"):
        function([1.0, 2.0])
    with pytest.raises(ValueError, match=r"input y: expected shape \(2, 3\), found \(2,\)"):
        function([1.0, 2.0], [1.0, 2.0])
    with pytest.raises(ValueError, match=r"expected a float array of shape \(2, 3\) in Fortran order"):
        function.bind_input(1, np.zeros((2, 3)))


def test_run_outlives_the_object_that_it_came_from():
    run = CompiledFunction(square(), compiled=False).run
    for _ in range(100):
        run()


@pytest.mark.parametrize("name", ["a b", "1a", "a;rm", "../a", "", "a" * 64, "a\n"])
def test_names_that_may_not_stand_in_c(name, tmp_path):
    with pytest.raises(ValueError, match="expected a name"):
        check_c_name(name)
    with pytest.raises(ValueError, match="expected a name"):
        write_c([square()], tmp_path, name=name)


def test_write_c_refuses_a_file_and_nothing(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match="expected a folder"):
        write_c([square()], tmp_path / "file")
    with pytest.raises(ValueError, match="at least one function"):
        write_c([], tmp_path)


@pytest.mark.compiler
@needs_compiler
@pytest.mark.parametrize("count", [1, 4, 17])
def test_points_together_are_the_points_one_by_one(count):
    rng = np.random.default_rng(count)
    step, p = discretize(clay_bicycle(), 0.012), clay_bicycle().p.nominal
    points = X[:, None] + 0.2 * rng.standard_normal((6, count))
    together, parts = at_points(step, count)
    assert parts
    assert np.allclose(
        np.asarray(together(points, U, p)), np.asarray(step.map(count)(points, U, p)), rtol=1e-13, atol=1e-15
    )


@pytest.mark.compiler
@needs_compiler
@pytest.mark.parametrize("count", [3, 17])
def test_repeated_points_are_steps_in_turn(count):
    step, p = discretize(clay_bicycle(), 0.0125), clay_bicycle().p.nominal
    points = X[:, None] + 0.1 * np.random.default_rng(count).standard_normal((6, count))
    together, parts = at_points(step, count, 16)
    expected = points
    for _ in range(16):
        expected = np.asarray(step.map(count)(expected, U, p))
    assert parts and np.allclose(np.asarray(together(points, U, p)), expected, rtol=1e-12, atol=1e-14)


def test_points_are_repeated_without_a_compiler_too(no_compiler):
    step, p = discretize(clay_bicycle(), 0.0125), clay_bicycle().p.nominal
    whole = discretize(clay_bicycle(), 0.05, substeps=4)
    together, parts = at_points(step, 2, 4)
    points = np.stack([X, 1.01 * X], axis=1)
    assert parts == () and np.allclose(np.asarray(together(points, U, p)), np.asarray(whole.map(2)(points, U, p)), rtol=1e-14)


def test_what_cannot_be_repeated_is_refused():
    x = ca.SX.sym("x", 2)
    with pytest.raises(ValueError, match="in the shape of the point"):
        write_lanes(ca.Function("f", [x], [x[0]]), 3, "f", 2)


def test_a_slow_log_compiles_no_larger_program_than_a_quick_one():
    """5 Hz: the step is a loop over its substeps; unrolled, the source would grow by the model with each of them."""
    model = Declaration(reference_vehicle(), CLAY).build()
    fast, slow = substeps_for(0.012), substeps_for(0.2)
    assert fast == 1 and slow == 14
    lanes = [
        len(write_lanes(discretize(model, dt / count, "euler"), 15, "step", count).splitlines())
        for dt, count in ((0.012, fast), (0.2, slow))
    ]
    assert lanes[1] < lanes[0] + 10
    with tempfile.TemporaryDirectory() as folder:
        sizes = []
        for dt, count in ((0.012, fast), (0.2, slow)):
            (path,) = write_c([step_with_memory(model, dt, substeps=count)], folder, header=False)
            sizes.append(len(path.read_text(encoding="utf-8").splitlines()))
    assert sizes[1] < 3 * sizes[0]


def test_a_step_of_many_substeps_is_those_substeps():
    model = Declaration(reference_vehicle(), CLAY).build()
    whole, part = step_with_memory(model, 0.2, substeps=14), discretize(model, 0.2 / 14)
    u, p = model.external.nominal, model.p.nominal
    x, m = model.x.pack(u=6.0, v=0.1, omega_z=0.2), np.asarray(start_memory(model)(model.x.pack(u=6.0), u, p))[:, 0]
    full = np.asarray(read_memory(model)(x, u, p, m))[:, 0]
    expected = x
    for _ in range(14):
        expected = np.asarray(part(expected, full, p))[:, 0]
    x_next, m_next = whole(x, m, u, p)
    assert np.allclose(np.asarray(x_next)[:, 0], expected, rtol=1e-12, atol=1e-14)
    assert np.allclose(np.asarray(m_next)[:, 0], np.asarray(advance_memory(model, 0.2)(x, full, p, m))[:, 0], rtol=1e-12)


@pytest.mark.compiler
@needs_compiler
def test_vector_exp_and_log_are_those_of_the_c_library():
    x = ca.SX.sym("x")
    values = np.concatenate(
        [np.linspace(-700, 700, 999), np.logspace(-300, 0, 300), -np.logspace(-12, 0, 50), [0.0, 1.0]]
    )
    together, _ = at_points(ca.Function("both", [x], [ca.vertcat(ca.exp(x), ca.log(ca.fabs(x) + 1e-305))]), len(values))
    exp, log = np.asarray(together(values[None, :]))
    assert np.allclose(exp, np.exp(values), rtol=1e-15, atol=0)
    assert np.allclose(log, np.log(np.abs(values) + 1e-305), rtol=4e-16, atol=4e-16)


@pytest.mark.compiler
@needs_compiler
def test_every_operation_in_lanes():
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    a, b = x[0], x[1]
    results = [
        ca.fmin(a, b), ca.fmax(a, u), ca.if_else(a > b, a, u), ca.sin(a) + ca.cos(u), ca.atan2(a, b), ca.floor(3 * a), ca.sign(b),
        ca.fabs(b), ca.tanh(a), a**3, (1 + a * a) ** u, 1 / (2 + a * a), ca.sqrt(1 + b * b), -a, u * u,
        ca.logic_and(a > 0, b > 0), ca.logic_not(a > 0), ca.tan(a), ca.acos(ca.tanh(b)), ca.exp(u) + 0 * a,
    ]  # fmt: skip
    function = ca.Function("many", [x, u], [ca.densify(ca.vertcat(*results))])
    points = np.random.default_rng(2).standard_normal((2, 7))
    assert np.allclose(
        np.asarray(at_points(function, 7)[0](points, 0.7)),
        np.asarray(function.map(7)(points, 0.7)),
        rtol=1e-14,
        atol=1e-15,
    )


TARGETS = [
    ("gcc", "-march=native"), ("gcc", "-march=native", "-mno-avx512f"), ("gcc", "-O1"), ("gcc", "-DSOFTSOIL_SCALAR"),
    ("clang", "-march=native"), ("clang", "-DSOFTSOIL_SCALAR"),
]  # fmt: skip


@pytest.mark.compiler
@pytest.mark.parametrize("target", TARGETS, ids=" ".join)
def test_the_same_numbers_on_other_targets(target, tmp_path):
    """One wheel's force, which is computed in two vectors side by side, on any compiler and width of vectors."""
    if shutil.which(target[0]) is None:
        pytest.skip(f"{target[0]} is not installed")
    x, count = ca.SX.sym("x", 4), 19
    force = force_law("turn_slip")(CLAY, Wheel(0.33, 0.21), Contact(x[0], x[1], x[2], x[3]))
    function = ca.Function("force", [x], [ca.vertcat(force.f_x, force.f_y)])
    source, library = tmp_path / "force.c", tmp_path / "force.so"
    source.write_text(write_lanes(function, count, "force_points"), encoding="utf-8")
    command = [target[0], "-O2", "-fPIC", "-shared", *target[1:], str(source), "-lm", "-o", str(library)]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if "-mno-avx512f" in target and built.returncode != 0:
        pytest.skip("another kind of processor")
    assert built.returncode == 0, built.stderr[:2000]
    points = np.random.default_rng(5).uniform([3, -1, 8, 0], [9, 1, 40, 6000], (count, 4)).T
    found, expected = ca.external("force_points", str(library))(points), function.map(count)(points)
    assert np.allclose(np.asarray(found), np.asarray(expected), rtol=1e-10, atol=1e-8)


@pytest.mark.compiler
@needs_compiler
def test_division_and_roots_at_the_ends_of_numbers():
    x = ca.SX.sym("x", 2)
    function = ca.Function("ends", [x], [ca.vertcat(x[0] / x[1], ca.sqrt(x[0]), ca.fmin(1.0, x[0] / x[1]))])
    points = np.array([[1, 0], [-1, 0], [0, 0], [3, np.inf], [0, 5], [1e300, 1e-3], [1e-300, 3], [4, -np.inf]], float).T
    found = np.asarray(at_points(function, points.shape[1])[0](points))
    with np.errstate(all="ignore"):
        expected = np.array([points[0] / points[1], np.sqrt(points[0])])
    assert np.allclose(found[:2], expected, rtol=1e-15, atol=0, equal_nan=True)
    assert found[2, 0] == 1.0


def test_lanes_refuse_what_they_cannot_hold():
    with pytest.raises(ValueError, match="expected dense vectors"):
        write_lanes(square(), 3, "s")


def test_numpy_code_gives_the_numbers_of_the_symbols():
    step, p = discretize(clay_bicycle(), 0.012), clay_bicycle().p.nominal
    assert np.allclose(numpy_function(step, "step")(X, U, p), np.asarray(step(X, U, p))[:, 0], rtol=1e-13, atol=1e-15)


@pytest.mark.compiler
@needs_compiler
def test_a_long_compilation_is_announced_once(own_cache, monkeypatch, tmp_path, caplog):
    slow = tmp_path / "cc"
    slow.write_text(f'#!/bin/sh\nsleep 0.2\nexec {find_compiler()} "$@"\n', encoding="utf-8")
    slow.chmod(0o755)
    monkeypatch.setattr(compiled, "find_compiler", lambda: str(slow))
    monkeypatch.setattr(compiled, "PATIENCE", 0.05)
    compiled._say_compiling.cache_clear()
    x = ca.SX.sym("x")
    for k in (2.0, 3.0):
        assert CompiledFunction(ca.Function("f", [x], [k * x])).is_compiled
    assert [record.getMessage() for record in caplog.records] == ["compiling the model, once; kept in the cache"]
    assert not [path for path in own_cache.iterdir() if path.is_dir()]


@pytest.mark.skipif(find_compiler() is None, reason="no compiler")
def test_a_function_that_was_compiled_before_is_not_written_again(tmp_path, monkeypatch):
    monkeypatch.setenv("SOFTSOIL_CACHE", str(tmp_path))
    written = []
    monkeypatch.setattr(compiled, "write_group", lambda *a, **k: written.append(a[0]) or write_group(*a, **k))
    z = ca.SX.sym("z", 2)

    def library(factor, driver=";"):
        function = ca.Function("f", [z], [factor * z[0] * z[1]])
        return compiled.group_library(function, f"void call_{len(driver)}(void) {{{driver}}}")

    first = library(2.0)
    assert library(2.0) == first and len(written) == 1
    assert len({first, library(3.0), library(2.0, ";;")}) == 3 and len(written) == 3
