"""What is installed works: the wheel in a new environment, used from another folder, with the defaults of its commands.

Nothing is downloaded: the wheel is built by the setuptools of the running environment, whose other packages the new one sees.
"""

import json
import os
import shutil
import site
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

import softsoil
from drives import CLAY_LOG, PROJECT

pytestmark = pytest.mark.slow
LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "build", "*.egg-info", "__pycache__", ".*_cache", "runs", "tests", "docs")


def run(*command, cwd: Path) -> str:
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel, built from a copy of the sources: a folder `build` of an earlier one would be swept in."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(PROJECT, folder / "source", symlinks=True, ignore=LEFT_OUT)
    options = ("--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "-w", folder)
    run(sys.executable, "-m", "pip", "wheel", folder / "source", *options, cwd=folder)
    (path,) = folder.glob("softsoil-*.whl")
    return path


@pytest.fixture(scope="module")
def home(wheel, tmp_path_factory) -> Path:
    """A folder with a new environment in `env`, in which the wheel is installed."""
    home = tmp_path_factory.mktemp("home")
    venv.create(home / "env", symlinks=True)
    purelib = Path(sysconfig.get_path("purelib", "venv", {"base": str(home / "env"), "platbase": str(home / "env")}))
    python = home / "env" / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps", "--no-index", wheel, cwd=home)
    # Read after the wheel's own folder; the .pth files in it, an editable softsoil's among them, are not.
    (purelib / "others.pth").write_text("\n".join(site.getsitepackages()) + "\n", encoding="utf-8")
    return home


def installed(home: Path) -> Path:
    return next(home.glob("env/lib/python*/site-packages/softsoil"))


def command(home: Path, *arguments) -> str:
    return run(home / "env" / "bin" / "softsoil", *arguments, cwd=home)


def read(path: Path) -> dict:
    return json.loads(path.read_text(encoding="utf-8"))


def test_the_wheel_installs_one_name(wheel):
    with zipfile.ZipFile(wheel) as archive:
        tops = {name.split("/")[0] for name in archive.namelist()}
        scripts = next(name for name in archive.namelist() if name.endswith("entry_points.txt"))
        assert "softsoil = softsoil.commands.start:main" in archive.read(scripts).decode()
    assert {top for top in tops if not top.endswith(".dist-info")} == {"softsoil"}


def test_every_public_name_is_there(home):
    code = "import softsoil; print(softsoil.__file__); print(all(hasattr(softsoil, name) for name in softsoil.__all__))"
    where, found = run(home / "env" / "bin" / "python", "-c", code, cwd=home).splitlines()
    assert found == "True" and Path(where).is_relative_to(home)


def test_version(home):
    said = f"softsoil {softsoil.__version__}"
    assert command(home, "--version").strip() == said
    assert run(home / "env" / "bin" / "python", "-m", "softsoil", "--version", cwd=home).strip() == said


def test_commands_run_from_another_folder_with_their_defaults(home):
    before = {path for path in installed(home).rglob("*") if path.suffix != ".pyc" and path.name != "__pycache__"}
    command(home, "study")
    studied = read(home / "runs/study/study.json")
    assert len(studied["logs"]) == len(softsoil.example_logs())
    assert studied["vehicle"]["file"] == "softsoil/vehicles/reference.toml"
    drive = softsoil.read_drive(CLAY_LOG).between(0.0, 8.0)
    softsoil.write_drive(drive, home / "short_clay.csv")
    for vehicle in ("paper", "reference"):
        command(home, "estimate", "short_clay.csv", "--soil", "clay", "--vehicle", vehicle)
    assert read(home / "runs/estimate/estimate.json")["software"]["version"] == softsoil.__version__
    command(home, "residual", "short_clay.csv")
    command(home, "refine", "short_clay.csv", "--soil", "clay")
    assert (home / "runs/refine/report.html").is_file()
    command(home, "estimate", "short_clay.csv", "--model", "runs/refine/refined.toml")
    command(home, "generate", "--soil", "clay")
    assert (home / "runs/generate/include/softsoil.h").is_file()
    after = {path for path in installed(home).rglob("*") if path.suffix != ".pyc" and path.name != "__pycache__"}
    assert before == after, "commands write into the installed package"
