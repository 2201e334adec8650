"""Tutorials and README from top to bottom: every block is carried out, and what is printed is compared with the page."""

import json

import pytest

from benchmarks.guide.blocks import blocks, commands, last_digit, matched, run_page, same
from benchmarks.guide.json_page import PAGE, keys, undescribed
from drives import PROJECT

TUTORIALS = sorted(PROJECT.glob("docs/tutorials/*.md"))
BUILT = ("build", "library", "data")
"""Folders of C and of the example data."""
ELSEWHERE = {"add-an-effect"}
"""Followed in a copy of the project by test_add_an_effect.py."""
CARRIED_OUT = [pytest.param(page, id=page.stem) for page in TUTORIALS if page.stem not in ELSEWHERE]
"""Minutes of computing, with commands that other tests run on less."""


@pytest.mark.study
@pytest.mark.compiler
@pytest.mark.parametrize("page", CARRIED_OUT)
def test_a_tutorial_runs_and_prints_what_it_says(page, tmp_path, installed):
    """With the installed wheel, as a newcomer would."""
    steps = list(run_page(page.read_text(encoding="utf-8"), tmp_path, installed.python))
    assert any(step.expected for step in steps), "expected a block with output"
    assert [fault for step in steps for fault in step.faults()] == []
    for path in (path for folder in tmp_path.iterdir() if folder.name not in BUILT for path in folder.rglob("*.json")):
        assert undescribed(path.name, json.loads(path.read_text(encoding="utf-8"))) == [], f"{path.name}: {PAGE.name} lacks keys"


def test_what_the_readme_runs_is_a_tutorial():
    """Its commands and what they print stand in docs/tutorials/my-log.md, which is carried out above."""
    (tutorial,) = (page for page in TUTORIALS if page.stem == "my-log")
    shown = [block for block in blocks((PROJECT / "README.md").read_text(encoding="utf-8")) if block.kind == "console"]
    carried_out = [block for block in blocks(tutorial.read_text(encoding="utf-8")) if block.kind == "console"]
    printed = {words: lines for block in carried_out for words, lines in commands(block.text)}
    found = [(words.partition("   #")[0], lines) for block in shown for words, lines in commands(block.text)]
    assert len(found) >= 4
    for words, lines in found:
        assert words in printed
        assert set(lines) <= {*printed[words], "..."}, words


@pytest.mark.parametrize("page", [PROJECT / "README.md", *TUTORIALS], ids=lambda path: path.stem)
def test_every_block_is_a_step_a_file_or_says_why_not(page):
    """No console or Python block of these pages escapes the run; what an indented or unmarked block shows is prose."""
    for block in blocks(page.read_text(encoding="utf-8")):
        assert block.kind in ("console", "python", "text", "toml", "cpp", "cmake", "make", ""), f"{page.name}: line {block.line}"
        if block.kind in ("toml", "cpp", "cmake"):
            assert block.title, f"{page.name}: line {block.line}: expected title= for a file"


def test_lines_agree_within_scatter_only():
    assert same("n 0.500 ± 0.021", "n 0.503 ± 0.021", 0.02)
    assert not same("n 0.500 ± 0.021", "n 0.530 ± 0.021", 0.02)
    assert not same("n 0.500 m", "n 0.500 s", 0.02)
    assert same("n to ± 3 %", "n to ± 4 %", 0.02) and not same("25 of 25 checks", "24 of 25 checks", 0.02)
    assert same("│ clay  │ 0.50 │", "clay 0.50", 0.0)
    assert last_digit("0.50") == pytest.approx(0.01) and last_digit("12") == 0.0


def test_lines_are_looked_for_in_order():
    pairs = matched(("b 2", "a 1"), ("a 1", "b 2"), 0.0)
    assert [found for _, found in pairs] == ["b 2", None]
    assert matched(("...", "error: ..."), ("x", "error: gone wrong"), 0.0)[1][1] == "error: ..."


def test_a_page_that_prints_something_else_is_reported(tmp_path):
    page = "```python\nprint('n', 0.5)\n```\n\n```text\nn 0.7\n```\n"
    (step,) = run_page(page, tmp_path)
    assert step.faults() and "'n 0.7' is not printed" in step.faults()[0]


def test_keys_that_the_json_page_lacks_are_named():
    assert list(keys({"a": {"b": [{"c": 1}]}, "d": []})) == ["a.b[].c", "d[]"]
    assert undescribed("estimate.json", {"verdict": "identified", "vehicle": None, "speed": 1.0}) == ["speed"]
