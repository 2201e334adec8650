"""Words of the field: marks of an older style in docstrings, comments, messages and pages do not grow in number.

"expected ..., found ..." is the form of every message of bad input and is not counted, nor is code in a docstring.
"""

import io
import re
import tokenize

import pytest

from benchmarks.judges.house import ORDER
from drives import PROJECT

MARKS = re.compile(r"\b(?:told|apart|what is told|(?:go|goes|going|went) with)\b|\bfound\b(?![.\[(])")
MESSAGE = re.compile(r"expected|; found|, found|found \{|found none|>>>")
MOST = {
    "files": 0, "recording": 2, "checking": 2, "importing": 1, "symbolic": 3, "declaration": 0, "codegen": 1, "windows": 2,
    "estimator": 2, "plant": 1, "control": 1, "mapping": 0, "calibration": 0, "refinement": 1, "identification": 0, "cases": 0,
    "mpc_demo": 2, "figures": 0, "commands": 1, "benchmarks": 1, "docs": 0,
}  # fmt: skip
"""Marks that a room still has: lower the number where some are replaced, never raise it."""


CODE = re.compile(r"`[^`]*`|\{[^{}]*\}")


def holds(line: str) -> bool:
    """Whether a line of prose has a mark; code in it, and the form of a message, do not count."""
    return bool(MARKS.search(CODE.sub("", line))) and not MESSAGE.search(line)


def marked(text: str) -> list[str]:
    """Lines of a file's docstrings, comments and strings that hold a mark."""
    lines = []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in (tokenize.STRING, tokenize.COMMENT):
            lines += [line.strip() for line in token.string.splitlines() if holds(line)]
    return lines


def marks_of(room: str) -> list[str]:
    """Lines with marks in a room's Python, or in the pages of docs other than the findings."""
    if room == "docs":
        pages = [p for p in sorted((PROJECT / "docs").rglob("*.md")) if "findings" not in p.parts]
        lines = [(p, line) for p in pages for line in p.read_text(encoding="utf-8").splitlines()]
        return [f"{p.name}: {line}" for p, line in lines if holds(line)]
    files = sorted((PROJECT / room).rglob("*.py"))
    return [f"{path.name}: {line}" for path in files for line in marked(path.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("room", MOST)
def test_no_room_gains_marks_of_the_older_style(room):
    lines = marks_of(room)
    assert len(lines) <= MOST[room], "\n".join(lines)


def test_every_room_is_counted():
    assert set(ORDER) <= set(MOST)


def test_a_mark_is_seen_and_a_message_is_not():
    assert marked('"""What the filter is told."""\n') == ['"""What the filter is told."""']
    assert marked('raise ValueError("mass: expected a number, found none")\n') == []
