"""What is installed works: the wheel in a new environment, used from another folder, with the defaults of its commands."""

import json
import subprocess
import zipfile
from pathlib import Path

import pytest

import softsoil
from drives import CLAY_LOG

pytestmark = pytest.mark.slow


def test_the_wheel_installs_one_name(wheel):
    with zipfile.ZipFile(wheel) as archive:
        tops = {name.split("/")[0] for name in archive.namelist()}
        scripts = next(name for name in archive.namelist() if name.endswith("entry_points.txt"))
        assert "softsoil = softsoil.commands.start:main" in archive.read(scripts).decode()
    assert {top for top in tops if not top.endswith(".dist-info")} == {"softsoil"}


def said_by(installed, *arguments) -> str:
    words = [str(installed.python), *arguments]
    return subprocess.run(words, cwd=installed.folder, capture_output=True, text=True, check=True).stdout


def test_every_public_name_is_there(installed):
    code = "import softsoil; print(softsoil.__file__); print(all(hasattr(softsoil, name) for name in softsoil.__all__))"
    where, found = said_by(installed, "-c", code).splitlines()
    assert found == "True" and Path(where).is_relative_to(installed.folder)


def test_version(installed):
    said = f"softsoil {softsoil.__version__}"
    assert installed.command("--version").strip() == said
    assert said_by(installed, "-m", "softsoil", "--version").strip() == said


def test_commands_find_what_comes_with_the_package(installed):
    """Vehicles, soils and coefficients by their names and by default; tutorials run the other commands."""
    drive = softsoil.read_drive(CLAY_LOG).between(0.0, 8.0)
    softsoil.write_drive(drive, installed.folder / "short_clay.csv")
    for vehicle, command, options in (("paper", "estimate", ("--vehicle", "paper")), ("reference", "residual", ())):
        installed.command(command, "short_clay.csv", "--soil", "clay", *options)
        written = json.loads((installed.folder / f"runs/{command}/{command}.json").read_text(encoding="utf-8"))
        assert written["vehicle"]["file"] == f"softsoil/vehicles/{vehicle}.toml"
        assert written["software"]["version"] == softsoil.__version__
    installed.command("generate", "--soil", "clay")
    assert (installed.folder / "runs/generate/include/softsoil.h").is_file()
