"""The public face: names loaded on demand, each with an example that runs; nothing heavy at the first import."""

import ast
import doctest
import os
import re
import subprocess
import sys

import pytest
from typer.testing import CliRunner

import softsoil
from drives import MULTI_LOG, PROJECT
from softsoil.commands.cli import app
from softsoil.recording.read import read_drive

SLOW = ("Nmpc", "estimate", "generate", "predict", "residual", "simulate", "to_do_mpc")
STUDIES = ("identify", "identify_soil", "late_clocks", "refine")
NAMES = [name for name in softsoil.__all__ if name != "__version__"]
MARKS = dict.fromkeys(SLOW, pytest.mark.slow) | dict.fromkeys(STUDIES, pytest.mark.study)


def python(code: str) -> str:
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False)
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


@pytest.mark.parametrize("name", [pytest.param(n, marks=MARKS.get(n, ())) for n in NAMES])
def test_every_public_name_has_an_example_that_runs(name, tmp_path, monkeypatch):
    """One line that is true, or a session as Python prints it."""
    if name == "to_do_mpc":
        pytest.importorskip("do_mpc")
    text = getattr(softsoil, name).__doc__
    assert "Example:" in text
    facts = re.findall(r"^\s*Example: (.+)$", text, re.M)
    if facts:
        # Evaluated for a vehicle and its model where a refined.toml stands, as after `softsoil refine`.
        declared = softsoil.Declaration(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        (tmp_path / "refined.toml").write_text(softsoil.declaration_toml(declared), encoding="utf-8")
        monkeypatch.chdir(tmp_path)
        given = {"softsoil": softsoil, "vehicle": declared.vehicle, "model": declared.build()}
        assert [eval(fact, given) for fact in facts] == [True]
        return
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    assert test.examples
    said: list[str] = []
    doctest.DocTestRunner(verbose=False).run(test, out=said.append)
    assert not said, "".join(said)


def test_names_for_tools_are_the_names_at_run_time():
    tree = ast.parse((PROJECT / "softsoil" / "__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {}
    for node in block.body:
        if isinstance(node, ast.ImportFrom):
            seen |= {alias.asname or alias.name: (node.module, alias.name) for alias in node.names}
    assert seen == softsoil._WHERE and sorted([*seen, "__version__"]) == sorted(softsoil.__all__) == dir(softsoil)


def test_the_first_import_is_quick_and_loads_no_library():
    code = "import sys, time; t = time.perf_counter(); import softsoil; took = time.perf_counter() - t\n"
    code += "print(took < 0.3, {'casadi', 'numpy', 'pandas', 'numba'} & set(sys.modules))"
    assert python(code) == "True set()"


def test_an_estimator_and_a_controller_load_no_plant():
    uses = (PROJECT / "control").glob("*.py")
    names = ["estimate", "predict", "refine", "generate", "Declaration"]
    # The solver's own kernels are numba's for now; without them a controller is held to the same.
    controller_is_free = not any("import njit" in path.read_text(encoding="utf-8") for path in uses)
    names += ["Nmpc", "Ocp"] if controller_is_free else []
    code = f"import sys, softsoil; [getattr(softsoil, name) for name in {names}]\n"
    code += "print('numba' in sys.modules, [m for m in sys.modules if m.startswith('softsoil.plant')])"
    assert python(code) == "False []"
    code = "import sys, softsoil; softsoil.Nmpc; print([m for m in sys.modules if m.startswith('softsoil.plant')])"
    assert python(code) == "[]"


def test_a_name_that_is_none_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'estimat'; it offers Declaration"):
        softsoil.estimat  # noqa: B018


def test_the_version_is_the_installed_one():
    assert softsoil.__version__ == python("from importlib.metadata import version; print(version('softsoil'))")


def test_a_drive_and_its_file_give_the_same():
    model = softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))
    from_file, from_drive = (softsoil.predict(log, model, 0.5, 0.5).mse for log in (MULTI_LOG, read_drive(MULTI_LOG)))
    assert from_file == from_drive


def test_predict_takes_n_of_each_axle():
    model = softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))
    drive = read_drive(MULTI_LOG).between(0, 8)
    both, each = (softsoil.predict(drive, model, n, 0.5).predicted for n in (0.6, (0.6, 0.6)))
    assert (both == each).all() and not (both == softsoil.predict(drive, model, (0.6, 0.5), 0.5).predicted).all()


def test_generate_writes_what_the_command_writes(tmp_path):
    arguments = ["generate", str(tmp_path / "command"), "--vehicle", "paper", "--soil", "clay"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    declared = softsoil.Declaration(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))
    paths = softsoil.generate(declared, tmp_path / "python")
    for path in paths:
        assert path.read_bytes() == (tmp_path / "command" / path.relative_to(tmp_path / "python")).read_bytes()
