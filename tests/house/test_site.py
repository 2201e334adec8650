"""The documentation as a site: it builds strictly, loads nothing from a network, and shows every effect and command."""

import json
import re
import subprocess
import sys

import pytest

from benchmarks.guide.blocks import environment
from benchmarks.guide.docstrings import readable
from benchmarks.guide.reference import MARK, PARTS, filled
from benchmarks.guide.reference_effects import PICTURES
from drives import PROJECT
from softsoil.commands.cli import COMMANDS
from softsoil.recording.drive import CHANNEL_UNITS
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.soil import SOIL_SIGNALS
from softsoil.symbolic.vehicle import NUMBERS, load_vehicle

LOADED = re.compile(r"<(?:link|script|img|source|iframe)\b[^>]*?(?:href|src)=\"(https?:)?//", re.I)
PAGES = sorted((PROJECT / "docs").rglob("*.md"))


@pytest.mark.slow
def test_the_site_builds_strictly_and_loads_nothing_from_a_network(tmp_path):
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path)]
    quiet = {**environment(), "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(words, cwd=PROJECT, env=quiet, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    pages = list(tmp_path.rglob("*.html"))
    assert len(pages) > len(PAGES)
    for page in pages:
        assert not LOADED.search(page.read_text(encoding="utf-8")), page.name
    for sheet in tmp_path.rglob("*.css"):
        assert not re.search(r"@import|url\(\s*['\"]?https?:", sheet.read_text(encoding="utf-8")), sheet.name
    python = (tmp_path / "reference" / "python.html").read_text(encoding="utf-8")
    assert 'id="softsoil.estimate"' in python and 'id="softsoil.refine"' in python
    assert "<p>&gt;&gt;&gt;" not in python and "Example:" not in python  # examples stand as code
    index = (tmp_path / "search" / "search_index.js").read_text(encoding="utf-8")
    assert json.loads(index.removeprefix("var __index = "))["docs"]  # what a page opened from the disk searches in
    start = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert re.search(r'<a class="picture" href="pictures/study.png"><img ', start)


def test_a_docstring_becomes_a_list_of_arguments_and_a_block_of_code():
    text = "The sum.\n\na, b: numbers\n(m); scale: factor. Raises ValueError for none.\n\nExample:\n    >>> add(1, 2)\n    3\n"
    shown = readable(text, ["a", "b", "scale"])
    assert shown.split("\n\n") == [
        "The sum.",
        "- `a`, `b`: numbers (m)\n- `scale`: factor",
        "Raises ValueError for none.",
        "```python\n>>> add(1, 2)\n3\n```",
    ]
    assert readable("No arguments: nothing changes.", []) == "No arguments: nothing changes."


def test_every_page_is_in_the_navigation():
    text = (PROJECT / "mkdocs.yml").read_text(encoding="utf-8")
    for page in PAGES:
        assert f" {page.relative_to(PROJECT / 'docs').as_posix()}\n" in text


def test_every_part_of_reference_has_its_page_and_every_mark_its_part():
    marks = [mark for page in PAGES for mark in MARK.findall(page.read_text(encoding="utf-8"))]
    assert sorted(marks) == sorted(PARTS)
    with pytest.raises(ValueError, match="expected one of"):
        filled("<!-- generated: nothing -->")


@pytest.mark.parametrize(
    ("part", "names"),
    [
        ("commands", COMMANDS),
        ("vehicle-numbers", [f"`{n.name}`" for n in NUMBERS]),
        ("soils", [f"`{s.name}`" for s in SOIL_SIGNALS]),
        ("channels", [f"`{name}`" for name in CHANNEL_UNITS]),
        ("c-api", ["softsoil_predict", "SOFTSOIL_INCONSISTENT", "gate_patience"]),
    ],
)
def test_reference_names_everything(part, names):
    text = PARTS[part]()
    assert [name for name in names if name not in text] == []


def test_every_effect_has_its_section_and_picture():
    text = PARTS["effects"]()
    for effect in catalogue(load_vehicle("reference")).values():
        assert f"{{#{effect.name}}}" in text and effect.doc in text
        missing = f"run: python -m benchmarks.guide.signatures {effect.name}"
        assert (PICTURES / f"{effect.name}.png").exists(), missing


def test_every_picture_of_a_page_has_an_alternative_text():
    for page in PAGES:
        for alt in re.findall(r"!\[([^\]]*)\]\(", page.read_text(encoding="utf-8")):
            assert len(alt) > 8, f"{page.name}: {alt!r}"
