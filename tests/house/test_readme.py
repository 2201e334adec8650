"""What the documents say is there: links, paths, commands, and the code in them."""

import json
import re
from importlib import import_module
from pathlib import Path

import pytest
from typer.testing import CliRunner

import softsoil
from benchmarks.guide.blocks import blocks, run_page
from drives import PROJECT
from softsoil.commands.cli import COMMANDS, app

DOCUMENTS = [
    PROJECT / "README.md",
    PROJECT / "CONTRIBUTING.md",
    PROJECT / "CHANGELOG.md",
    *sorted(PROJECT.glob("docs/**/*.md")),
]
DOCUMENTS += sorted(PROJECT.glob("data/*.md"))
OWN = (".", "runs")  # what commands write is not there before they ran
ROOMS = tuple(path.name for path in PROJECT.iterdir() if path.is_dir() and not path.name.startswith(OWN))
GROUPS = ("case",)
SINGLE = sorted(set(COMMANDS) - set(GROUPS))


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_and_paths_exist(document):
    text = document.read_text(encoding="utf-8")
    prose = re.sub(r"(?ms)^```.*?^```|^ {4}.*?$", "", text)  # an index and a call in code look like a link
    for link in re.findall(r"\]\(([^)]+)\)", prose):
        if not link.startswith("http"):
            assert (document.parent / link.split("#")[0]).exists(), link
    for path in re.findall(r"`([\w./-]+)`", text):
        if path.split("/")[0] in ROOMS and "/" in path:
            assert (PROJECT / path).exists(), path


def test_every_document_is_in_the_index():
    index = (PROJECT / "docs" / "README.md").read_text(encoding="utf-8")
    for document in (PROJECT / "docs").rglob("*.md"):
        name = document.relative_to(PROJECT / "docs").as_posix()
        assert name == "README.md" or f"]({name})" in index


def test_every_command_that_the_readme_names_is_there():
    text = (PROJECT / "README.md").read_text(encoding="utf-8")
    named = set(re.findall(r"softsoil ([a-z][\w-]*)", text))
    assert named == set(COMMANDS)


@pytest.mark.parametrize("command", SINGLE)
def test_every_command_has_help_with_an_example(command):
    result = CliRunner().invoke(app, [command, "--help"])
    assert result.exit_code == 0 and f"softsoil {command}" in result.output


def readme_step(folder):
    """The Python of the README, run in `folder`."""
    page = (PROJECT / "README.md").read_text(encoding="utf-8")
    shown = [block for block in blocks(page) if block.kind in ("python", "text")]
    (step,) = run_page("\n".join(f"```{block.kind}\n{block.text}```\n" for block in shown), folder)
    return step


@pytest.mark.slow
def test_python_of_the_readme_prints_what_it_says(tmp_path):
    step = readme_step(tmp_path)
    assert step.expected and step.faults() == []


@pytest.mark.study
def test_python_of_the_readme_prints_what_the_command_prints(tmp_path):
    step = readme_step(tmp_path)
    log = PROJECT / "data" / "multi_clay_n0.50.parquet"
    arguments = ["estimate", str(log), "--soil", "clay", "--n0", "0.7", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    written = json.loads((tmp_path / "out" / "estimate.json").read_text(encoding="utf-8"))
    verdict, number = step.actual[:2]  # then what says that a model has been compiled, where none was
    assert verdict == written["verdict"] and f"\n{verdict}: " in result.output
    assert number == f"n {written['n_front']:.3f} ± {written['n_front_std']:.3f}"
    assert f"n front {written['n_front']:.3f} ± {written['n_front_std']:.3f}" in result.output


@pytest.mark.slow
def test_python_of_the_model_page_runs(tmp_path):
    page = (PROJECT / "docs" / "concepts" / "model.md").read_text(encoding="utf-8")
    shown = "".join(block.text for block in blocks(page) if block.kind == "python")
    (step,) = run_page(f"```python\n{shown}```\n", tmp_path)
    assert "rollout" in shown and step.faults() == []


def test_modules_that_are_public_as_well_have_what_the_page_says():
    page = (PROJECT / "docs" / "reference" / "python.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ((?:`[a-z_.]+`(?:, )?)+) \| (.*?) \|", page, re.M)
    assert len(rows) > 8
    for modules, names in rows:
        owners = [import_module(f"softsoil.{module}") for module in re.findall(r"`([\w.]+)`", modules)]
        for name in re.findall(r"`(\w+)`", names):
            assert any(hasattr(owner, name) for owner in owners), f"{modules}: {name}"


def test_python_in_the_documents_imports_the_public_face_first():
    """Examples start from `import softsoil`; what they import from inside is what the face does not offer."""
    for document in DOCUMENTS:
        if document.name == "add-an-effect.md":
            continue  # its file becomes a part of the package, which knows its own rooms
        text = document.read_text(encoding="utf-8")
        for module, names in re.findall(r"^\s*from (softsoil\.[\w.]+) import ([\w, ]+)", text, re.M):
            public = {name.strip() for name in names.split(",")} & set(softsoil.__all__)
            assert not public, f"{document.name}: {public} of {module}: expected softsoil.{public}"


def test_make_has_its_two_commands():
    text = (PROJECT / "Makefile").read_text(encoding="utf-8")
    assert re.search(r"^demo:", text, re.M) and re.search(r"^test:", text, re.M)
    assert "make test" in Path(PROJECT / ".ci" / "run").read_text(encoding="utf-8")
