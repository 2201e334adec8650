"""The steering map in C against the vehicle's own, and no trace of it where a vehicle has none."""

import ctypes
import json
import subprocess

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.codegen.c_library.steering import HEADER, steering_header
from softsoil.control.c_estimator import c_library_texts
from softsoil.declaration.model_file import Declaration
from softsoil.files.steering_map import SteeringMap
from softsoil.symbolic.soil import CLAY

FLAGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC")
SOURCE = """#include "softsoil_steering.h"
double angle(double c) { return softsoil_steer_angle(c); }
double command(double a) { return softsoil_steer_command(a); }
"""


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_c_and_python_look_up_the_same(tmp_path, sign):
    steering = SteeringMap((-3.0, -1.1, 0.2, 2.5), tuple(sign * a for a in (-0.5, -0.15, 0.01, 0.47)))
    (tmp_path / "softsoil_steering.h").write_text(steering_header(steering), encoding="utf-8")
    (tmp_path / "use.c").write_text(SOURCE, encoding="utf-8")
    library = tmp_path / "use.so"
    subprocess.run(["cc", *FLAGS, str(tmp_path / "use.c"), "-o", str(library)], check=True)
    c = ctypes.CDLL(str(library))
    for name, look_up, values in (("angle", steering.angle_of, np.linspace(-4, 4, 61)),
                                  ("command", steering.command_of, np.linspace(-0.6, 0.6, 61))):  # fmt: skip
        function = getattr(c, name)
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
        np.testing.assert_allclose([function(v) for v in values], look_up(values), atol=1e-14)
        assert np.isnan(function(float("nan")))


def test_the_library_has_the_header_only_where_the_vehicle_has_a_map():
    plain = reference_vehicle().with_(effects={})
    without = c_library_texts(Declaration(plain, CLAY))
    mapped = c_library_texts(Declaration(plain.with_(steering=SteeringMap((-1.0, 1.0), (-0.4, 0.4))), CLAY))
    assert HEADER not in without and "steering" not in json.loads(without["formulation.json"])["vehicle"]
    assert set(mapped) == {*without, HEADER}
    said = json.loads(mapped["formulation.json"])["vehicle"]["steering"]
    assert said == {"command": [-1.0, 1.0], "angle": [-0.4, 0.4]}
