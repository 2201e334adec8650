"""A long kernel cut into functions computes what it computes in one, whatever its statements read."""

import ctypes
import re
from importlib.resources import files

import casadi as ca
import numpy as np
import pytest

from softsoil.codegen.c_library.kernels import write_kernel
from softsoil.codegen.compiled import build_library, find_compiler
from softsoil.codegen.kernel_parts import in_parts

ARGUMENTS = ("const ssv *a0", "ssv *r0")
COUNT, OUTPUTS = 200, 20


def statements(seed: int) -> list[str]:
    """A random straight line that reads near and far values and stores some as it goes."""
    rng = np.random.default_rng(seed)
    lines = ["const ssv t0 = a0[0] * a0[1];"]
    for k in range(1, COUNT):
        near, far = rng.integers(max(k - 4, 0), k), rng.integers(0, k)
        kind = "double" if k % 5 == 0 else "ssv"
        lines.append(f"const {kind} t{k} = 0.7 * t{near} - 0.4 * t{far} + a0[{k % 3}];")
        if k % (COUNT // OUTPUTS) == 0:
            lines.append(f"r0[{k * OUTPUTS // COUNT}] = t{far};")
    return [*lines, f"r0[0] = t{COUNT - 1};"]


@pytest.mark.skipif(find_compiler() is None, reason="no compiler")
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("size", [1, 7, 50, 1000])
def test_parts_compute_what_the_whole_computes(seed, size):
    found = []
    for cut in (size, 10 * COUNT):
        kernel = in_parts("f", ARGUMENTS, statements(seed), cut)
        text = f"typedef double ssv;\n{kernel}void run(const double *x, double *y) {{ f(x, y); }}"
        library = build_library("parts", (text,), ("-O1", "-fPIC", "-ffp-contract=off"))
        run = ctypes.CDLL(str(library)).run
        run.argtypes = [ctypes.c_void_p] * 2
        x, y = np.array([0.3, -1.2, 0.8]), np.full(OUTPUTS, np.nan)
        run(x.ctypes.data, y.ctypes.data)
        found.append(y)
    assert np.isfinite(found[1]).all()
    assert np.array_equal(found[0], found[1])


def test_no_part_is_longer_than_asked_and_places_are_used_again():
    text = in_parts("f", ARGUMENTS, statements(0), 20)
    bodies = re.findall(r"static void f_\d+\(.*?\{\n(.*?)\n\}", text, re.S)
    lines = [line.strip() for body in bodies for line in body.splitlines()]
    own = [[line for line in body.splitlines() if not re.match(r" *(w\[|d\[|\(void\))", line)] for body in bodies]
    assert len(bodies) == -(-len(statements(0)) // 20) and max(len(lines) for lines in own) == 20
    for kind, array in (("ssv", "w"), ("double", "d")):
        room = int(re.search(rf"{kind} {array}\[(\d+)\];", text)[1])
        assert 0 < room < sum(line.startswith(f"{array}[") for line in lines)


@pytest.mark.skipif(find_compiler() is None, reason="no compiler")
def test_a_kernel_with_shared_inputs_is_cut():
    """Points of a horizon that share parameters, in parts and in one: the same numbers to the last bit."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    y = x
    for k in range(400):
        y = ca.vertcat(y[1] * ca.sin(p[0] + k), y[2] + p[1] * y[0], ca.tanh(y[0] - y[1] + ca.exp(p[0] * k / 400)))
    function = ca.Function("f", [x, p], [y])
    found = []
    for parts in (True, False):
        kernel = write_kernel(function, "f", (True, False), parts=parts)
        assert ("f_1(" in kernel) is parts
        header = (files("softsoil.codegen.c_library") / "templates" / "softsoil_lanes.h.in").read_text(encoding="utf-8")
        run = """void run(const double *x, const double *p, double *y) {
  double lane[3][SOFTSOIL_LANES]; ssv v[3], r[3];
  for (int i = 0; i < 3; ++i) for (int l = 0; l < SOFTSOIL_LANES; ++l) lane[i][l] = x[i] + 0.1 * l;
  for (int i = 0; i < 3; ++i) v[i] = ssv_load(lane[i]);
  f(v, p, r);
  for (int i = 0; i < 3; ++i) ssv_store(lane[i], r[i]);
  memcpy(y, lane, sizeof(lane));
}"""
        library = build_library("shared_parts", (f"{header}\n{kernel}\n{run}",), ("-O2", "-fPIC", "-ffp-contract=off"))
        c = ctypes.CDLL(str(library)).run
        c.argtypes = [ctypes.c_void_p] * 3
        values, shared, result = np.array([0.3, -0.4, 0.2]), np.array([0.1, 0.7]), np.full(3 * 8, np.nan)
        c(values.ctypes.data, shared.ctypes.data, result.ctypes.data)
        found.append(result)
    assert np.isfinite(found[0][:3]).all() and np.array_equal(found[0], found[1], equal_nan=True)


def test_several_groups_are_not_cut():
    x = ca.SX.sym("x")
    with pytest.raises(ValueError, match="expected one group of points to cut"):
        write_kernel(ca.Function("f", [x], [2 * x]), "f", (True,), groups=2, parts=True)
