"""The wheel, built and installed in a new environment: what tutorials and tests of the installed package run in.

Nothing is downloaded: the wheel is built by the setuptools of the running environment, whose other packages the new one sees.
"""

import os
import shutil
import site
import subprocess
import sys
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path

import pytest

from drives import PROJECT

LEFT_OUT = shutil.ignore_patterns(".git", ".venv", "build", "*.egg-info", "__pycache__", ".*_cache", "runs", "tests", "docs")


@dataclass(frozen=True)
class Installed:
    """A folder to work in, with the environment in which the wheel is installed as its subfolder `env`."""

    folder: Path

    @property
    def python(self) -> Path:
        return self.folder / "env" / "bin" / "python"

    @property
    def package(self) -> Path:
        return next(self.folder.glob("env/lib/python*/site-packages/softsoil"))

    def files(self) -> set[Path]:
        """What the package consists of; compiled Python is left out."""
        return {path for path in self.package.rglob("*") if path.suffix != ".pyc" and path.name != "__pycache__"}

    def command(self, *arguments) -> str:
        """What the console script prints; a failure fails the test."""
        return run(self.python.parent / "softsoil", *arguments, cwd=self.folder)


def run(*command, cwd: Path) -> str:
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def wheel(tmp_path_factory) -> Path:
    """The wheel, built from a copy of the sources: a folder `build` of an earlier one would be swept in."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(PROJECT, folder / "source", symlinks=True, ignore=LEFT_OUT)
    options = ("--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "-w", folder)
    run(sys.executable, "-m", "pip", "wheel", folder / "source", *options, cwd=folder)
    (path,) = folder.glob("softsoil-*.whl")
    return path


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """The installed wheel; at the end, no command may have written into it."""
    home = tmp_path_factory.mktemp("home")
    venv.create(home / "env", symlinks=True)
    purelib = Path(sysconfig.get_path("purelib", "venv", {"base": str(home / "env"), "platbase": str(home / "env")}))
    python = home / "env" / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps", "--no-index", wheel, cwd=home)
    # Read after the wheel's own folder; the .pth files in it, an editable softsoil's among them, are not.
    (purelib / "others.pth").write_text("\n".join(site.getsitepackages()) + "\n", encoding="utf-8")
    found = Installed(home)
    before = found.files()
    yield found
    assert found.files() == before, "commands write into the installed package"
