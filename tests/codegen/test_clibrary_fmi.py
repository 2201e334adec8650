"""The FMI unit, run in FMPy against the model's own steps."""

import numpy as np
import pytest
from typer.testing import CliRunner

from c_folders import declared, library
from softsoil.codegen.sampling import STEP
from softsoil.commands.cli import app
from softsoil.symbolic.declaration import declaration_toml

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.compiler
SAME = 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plain", "tracks"])
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
