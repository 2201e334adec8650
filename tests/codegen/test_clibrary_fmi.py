"""The FMI unit, run in FMPy against the model's own steps."""

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.guide.blocks import run_page
from c_folders import declared, library
from drives import PROJECT
from softsoil.codegen.sampling import STEP
from softsoil.commands.cli import app
from softsoil.control.c_fmu import OBSTACLES, POINTS
from softsoil.declaration.model_file import declaration_toml

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.compiler
SAME = 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plain", pytest.param("tracks", marks=pytest.mark.study)])
def test_unit_runs_in_fmpy(name, tmp_path):
    """Inputs that change at every step, against softsoil_step."""
    model = tmp_path / "model.toml"
    model.write_text(declaration_toml(declared(name)), encoding="utf-8")
    done = CliRunner().invoke(app, ["generate", "--model", str(model), "--fmi", "--out", str(tmp_path / "c")])
    assert done.exit_code == 0, done.output
    unit = str(tmp_path / "c" / "softsoil.fmu")
    assert fmpy.read_model_description(unit).fmiVersion == "3.0"
    assert not fmpy.validation.validate_fmu(unit)

    lib = library(name)
    steps = 100
    t = STEP * np.arange(steps)
    u = np.tile([0.0, 0.0, 0.0, 15.0, 15.0, 15.0, 15.0], (steps, 1))
    u[:, 0], u[:, 1] = 0.2 * np.sin(2 * t), 0.4 * np.cos(2 * t)
    names = lib.names["states"]
    p = np.array([s["nominal"] for s in lib.formulation["parameters"]])
    x = np.array([s["nominal"] for s in lib.formulation["states"]])
    m, expected = lib.history(p, x, u[0]), []
    for row in u:
        x, m = lib.step(p, STEP, x, m, row)
        expected.append(x)
    found = run_unit(unit, lib.names["inputs"], names, t, u)
    assert np.abs(found - np.array(expected)).max() < SAME


def run_unit(path, inputs, outputs, t, u):
    """(N, n_x) outputs after each step."""
    from fmpy.fmi3 import FMU3Slave

    description = fmpy.read_model_description(path)
    reference = {v.name: v.valueReference for v in description.modelVariables}
    unit = FMU3Slave(
        guid=description.guid, unzipDirectory=fmpy.extract(path), modelIdentifier="softsoil", instanceName="vehicle"
    )
    unit.instantiate()
    unit.enterInitializationMode(startTime=0.0)
    unit.exitInitializationMode()
    rows = []
    for k, row in enumerate(u):
        unit.setFloat64([reference[n] for n in inputs], list(row))
        unit.doStep(currentCommunicationPoint=t[k], communicationStepSize=STEP)
        rows.append(unit.getFloat64([reference[n] for n in outputs]))
    unit.terminate()
    unit.freeInstance()
    return np.array(rows)


@pytest.mark.study
def test_the_docs_example_closes_the_loop_of_both_units(tmp_path):
    """Both units generated and run as the page says; tests/control/test_c_fmu.py runs the driver's against the library."""
    page = (PROJECT / "docs" / "reference" / "c-library.md").read_text(encoding="utf-8")
    steps = list(run_page(page, tmp_path))
    assert len(steps) == 2 and [fault for step in steps for fault in step.faults()] == []


def test_the_docs_name_the_length_of_the_units_arrays():
    page = (PROJECT / "docs" / "reference" / "c-library.md").read_text(encoding="utf-8")
    assert f"are {POINTS} points each" in page and f"is {5 * OBSTACLES}\n  numbers, {OBSTACLES} times" in page
    folder = (PROJECT / "codegen" / "c_library" / "templates" / "CONTROLLER.md.in").read_text(encoding="utf-8")
    places = f"({OBSTACLES} times x, y, radius and velocity: {5 * OBSTACLES} numbers"
    assert f"({POINTS} points each" in folder and places in folder
