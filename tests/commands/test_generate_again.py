"""softsoil generate asked again: at once where nothing changed, anew where anything did."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.judges.house import imported
from drives import PROJECT, reference_vehicle
from softsoil.codegen.text_cache import WRITERS
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.symbolic.soil import CLAY

RUN = """
import sys
from softsoil.commands.start import main
try:
    main()
except SystemExit as end:
    assert not end.code
print("loaded" if "typer" in sys.modules else "at once")
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "refined.toml"
    path.write_text(declaration_toml(Declaration(reference_vehicle().with_(effects={}), CLAY)), encoding="utf-8")
    return path


def softsoil(home: Path, *arguments: str) -> tuple[str, list[str]]:
    """How the command was answered, and the lines before that."""
    done = run(home, *arguments)
    *lines, how = done.stdout.splitlines()
    return how, lines


def said(home: Path, *arguments: str) -> tuple[str, str]:
    """What the command said beside its answer, and how it was answered."""
    done = run(home, *arguments)
    return done.stderr, done.stdout.splitlines()[-1]


def run(home: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"SOFTSOIL_CACHE": str(home / "cache"), "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-c", RUN, "generate", *arguments]
    return subprocess.run(command, cwd=home, env=environment, capture_output=True, text=True, check=True)


def test_what_has_not_changed_is_written_at_once(tmp_path: Path, model: Path) -> None:
    first = softsoil(tmp_path, "c", "--model", "refined.toml")
    texts = {path: path.read_bytes() for path in sorted((tmp_path / "c").rglob("*")) if path.is_file()}
    assert first[0] == "loaded" and len(texts) > 5
    lost = next(iter(texts))
    lost.unlink()
    again = softsoil(tmp_path, "c", "--model", "refined.toml")
    assert again == ("at once", first[1])
    assert {path: path.read_bytes() for path in texts} == texts


@pytest.mark.study
def test_its_warnings_are_said_every_time(tmp_path: Path) -> None:
    soil = "".join(f"{name} = {getattr(CLAY, name)}\n" for name in ("k_phi", "k_c", "n", "c", "phi", "k", "K", "R"))
    (tmp_path / "field.toml").write_text(f'name = "field"\n{soil}verdict = "needs_data"\n', encoding="utf-8")
    for folder in ("c", "c", "d"):
        warned, how = said(tmp_path, folder, "--soil", "field.toml")
        assert "'needs_data' of its file: not to be used yet" in warned, (folder, how)
    assert said(tmp_path, "d", "--soil", "field.toml")[1] == "at once"


def test_every_room_whose_numbers_go_into_c_counts() -> None:
    """A change of any of them makes the texts anew."""
    rooms, ahead = set(), {"control.c_estimator", "control.c_folder"}
    seen: set[str] = set()
    while ahead - seen:
        name = (ahead - seen).pop()
        seen.add(name)
        path = PROJECT / f"{name.replace('.', '/')}.py"
        if path.is_file():
            rooms.add(name.split(".")[0])
            ahead |= {".".join(found.split(".")[:k]) for found in imported(path) for k in (2, 3)}
    assert rooms <= {room for room, _ in WRITERS}


@pytest.mark.study
def test_another_model_folder_or_option_is_generated(tmp_path: Path, model: Path) -> None:
    softsoil(tmp_path, "c", "--model", "refined.toml")
    before = (tmp_path / "c" / "formulation.json").read_text(encoding="utf-8")
    assert softsoil(tmp_path, "d", "--model", "refined.toml")[0] == "loaded"
    model.write_text(model.read_text(encoding="utf-8").replace("n = 0.5", "n = 0.6"), encoding="utf-8")
    assert softsoil(tmp_path, "c", "--model", "refined.toml")[0] == "loaded"
    assert (tmp_path / "c" / "formulation.json").read_text(encoding="utf-8") != before
