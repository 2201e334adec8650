"""The driver as an FMI unit, run in FMPy against the driver in C on the same measurements; units and description."""

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.codegen.c_library.fmi import exponents
from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.pack_fmu import pack_fmus
from softsoil.control.c_fmu import POINTS
from softsoil.control.c_folder import controller_texts
from softsoil.control.c_statuses import STATUSES
from softsoil.control.courses import double_lane_change
from softsoil.control.driver_binding import CDriver
from softsoil.control.driver_types import MEASUREMENTS, DriverSettings
from softsoil.control.ocp import OcpSettings
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.soil import CLAY

fmpy = pytest.importorskip("fmpy")
pytestmark = [pytest.mark.compiler, pytest.mark.study]
SAME = 1e-9
TICK = DriverSettings().tick
OBSTACLE = [30.0, 1.5, 1.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def texts():
    declared = Declaration(reference_vehicle(), CLAY, "hard_ground")
    return controller_texts(declared, fmi=True, settings=OcpSettings(steps=20, dt=0.1))


@pytest.fixture(scope="module")
def units(texts, tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmu")
    write_library(folder, texts)
    return pack_fmus(folder)


def test_both_units_are_valid_and_have_units(units):
    from fmpy.validation import validate_fmu

    assert [path.name for path in units] == ["softsoil.fmu", "softsoil_driver.fmu"]
    for path in units:
        assert not validate_fmu(str(path))
    described = {v.name: v for v in fmpy.read_model_description(str(units[1])).modelVariables}
    assert described["u"].unit == "m/s" and described["a_asked"].unit == "m/s^2" and described["n"].unit is None
    assert {v.unit for v in fmpy.read_model_description(str(units[0])).modelVariables} >= {"m", "rad", "rad/s"}


def test_units_are_made_of_base_units():
    assert exponents("rad s^2/m") == {"rad": 1, "s": 2, "m": -1}
    assert exponents("N m") == {"kg": 1, "m": 2, "s": -2} and exponents("rad/(N m)") == {"rad": 1, "kg": -1, "m": -2, "s": 2}
    assert exponents("") == {} and exponents("N/m^(n+1)") == {} and exponents("furlong") == {}


def test_the_unit_drives_as_the_driver_does(texts, units):
    """A path and an obstacle set as arrays, measurements with gaps; a communication step of one tick, then of two."""
    from fmpy.fmi3 import FMU3Slave

    path, speed = double_lane_change(), 5.5
    driver = CDriver(texts, len(MEASUREMENTS) - 5)
    driver.start(path, speed, [OBSTACLE], 0.7)
    description = fmpy.read_model_description(str(units[1]))
    reference = {v.name: v.valueReference for v in description.modelVariables}
    unit = FMU3Slave(
        guid=description.guid, unzipDirectory=fmpy.extract(str(units[1])), modelIdentifier="softsoil_driver", instanceName="one"
    )
    unit.instantiate()
    unit.enterInitializationMode(startTime=0.0)
    points = np.zeros((2, POINTS))
    points[:, : len(path.points)] = path.points.T
    for name, values in (
        ("speed", [speed]), ("n0", [0.7]), ("path_points", [float(len(path.points))]), ("path_x", points[0]),
        ("path_y", points[1]),
        ("obstacle_count", [1.0]), ("obstacles", OBSTACLE + [0.0] * 75),
    ):  # fmt: skip
        unit.setFloat64([reference[name]], [float(value) for value in values])
    names = ("n", "n_used", "lost", "status", "n_std", "position_std", "dead_reckoned")
    waits = unit.getFloat64([reference[name] for name in names])
    assert waits[:4] == [0.7, 0.7, 1.0, [name for name, _ in STATUSES].index("NO_STATE")]
    assert np.isnan(waits[4:]).all(), "nothing is known yet"
    unit.exitInitializationMode()
    rng, t, seen = np.random.default_rng(2), 0.0, []
    for k in range(240):
        measured = {"x": speed * t, "y": 0.05 * rng.standard_normal(), "psi": 0.01 * rng.standard_normal(), "u": speed, "v": 0.0}
        if k % 7:
            measured["omega_z"] = 0.0
        ticks = 1 if k < 200 else 2
        for i in range(ticks):
            command = driver.tick(t + i * TICK, measured if i == 0 else {})
        unit.setFloat64([reference[name] for name in MEASUREMENTS], [measured.get(name, np.nan) for name in MEASUREMENTS])
        unit.doStep(currentCommunicationPoint=t, communicationStepSize=ticks * TICK)
        found = unit.getFloat64([reference[name] for name in ("steer_asked", "a_asked", "n", "along", "solved", "lost")])
        expected = [command.steer, command.a_asked, command.n, command.along, command.solved, command.lost]
        np.testing.assert_allclose(found, expected, atol=SAME)
        seen.append(found)
        t += ticks * TICK
    assert np.ptp([row[0] for row in seen]) > 1e-3 and not seen[-1][5], "it steered, on a plan"
    with pytest.raises(Exception, match="fmi3DoStep"):
        unit.doStep(currentCommunicationPoint=t, communicationStepSize=0.5 * TICK)
    unit.terminate()
    unit.freeInstance()
