"""A long kernel cut into functions computes what it computes in one, whatever its statements read."""

import ctypes
import re

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
        lines.append(f"const ssv t{k} = 0.7 * t{near} - 0.4 * t{far} + a0[{k % 3}];")
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
    own = [[line for line in body.splitlines() if not line.strip().startswith("w[")] for body in bodies]
    assert len(bodies) == -(-len(statements(0)) // 20) and max(len(lines) for lines in own) == 20
    room = int(re.search(r"ssv w\[(\d+)\];", text)[1])
    assert room < sum(line.strip().startswith("w[") for body in bodies for line in body.splitlines())


def test_a_kernel_with_shared_inputs_is_not_cut():
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    with pytest.raises(ValueError, match="inputs that all vary"):
        write_kernel(ca.Function("f", [x, p], [x * p]), "f", (True, False), parts=True)
