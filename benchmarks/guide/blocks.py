"""Code blocks of a page and how they are carried out: files are written, commands and Python run, outputs compared.

A block may say `title="name"`: then it is a file. `console` blocks hold commands after `$ ` and what they print; `...` stands
for lines left out. What a Python block prints stands in the `text` block after it. A comment `<!-- scatter: 5 % -->` before a
block says how far printed numbers may be from those of the page (2 % without it); `<!-- not run: reason -->` leaves it out.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^(?P<marks>(?:<!-- [^\n]*? -->\n)*)```(?P<kind>\w*)(?P<more>[^\n]*)\n(?P<body>.*?)^```$", re.M | re.S)
NUMBER = re.compile(r"(?<![\w.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w]|\.\d)", re.I)
BORDERS = re.compile(r"[─━┃│┏┓┗┛┡┩┳┻╇└┘┴┼├┤┬═]+")
SCATTER = 0.02
"""Share by which a printed number may differ from the page's where the page says nothing else."""
PROGRAMS = ("softsoil", "python", "cmake", "cat", "sed", "cc", "c++")
"""Programs that a page may call, besides those that it builds (`./name`)."""


@dataclass(frozen=True)
class Block:
    """One code block: kind (language), text, title (file name, or ""), scatter (share), left_out (reason, or ""), line, span."""

    kind: str
    text: str
    title: str
    scatter: float
    left_out: str
    line: int
    span: tuple[int, int]


def blocks(page: str) -> list[Block]:
    """The code blocks of a page of Markdown, in order."""
    found = []
    for match in FENCE.finditer(page):
        title = re.search(r'title="([^"]+)"', match["more"])
        scatter = re.search(r"<!-- scatter: ([\d.]+) % -->", match["marks"])
        out = re.search(r"<!-- not run: (.*?) -->", match["marks"])
        share = float(scatter[1]) / 100 if scatter else SCATTER
        line = page[: match.start("body")].count("\n") + 1
        found.append(
            Block(match["kind"], match["body"], title[1] if title else "", share, out[1] if out else "", line, match.span("body"))
        )
    return found


@dataclass(frozen=True)
class Printed:
    """What a step of a page should print and what it printed: block, expected and actual lines, code (exit code), errors."""

    block: Block
    words: str
    expected: tuple[str, ...]
    actual: tuple[str, ...]
    code: int
    errors: str

    def faults(self) -> list[str]:
        """Differences beyond the block's scatter, one sentence each; empty where the page is right."""
        if self.code not in (0, 2) or (self.code == 2 and not any(line.startswith("error: ") for line in self.expected)):
            return [f"line {self.block.line}: {self.words}: exit code {self.code}: {self.errors[-600:]}"]
        pairs = matched(self.expected, self.actual, self.block.scatter)
        return [f"line {self.block.line}: {self.words}: {line!r} is not printed" for line, found in pairs if found is None]


def run_page(page: str, folder: Path, python: Path | None = None) -> Iterator[Printed]:
    """Carry out a page's blocks in `folder`, where `data` leads to the example data, and say what each step printed.

    python: an interpreter with softsoil installed, in the place of the running one with this project. Raises ValueError for a
    program that a page may not call.
    """
    env = environment(python)
    interpreter = str(python or sys.executable)
    (folder / "data").symlink_to(PROJECT / "data")
    todo = blocks(page)
    for i, block in enumerate(todo):
        if block.left_out:
            continue
        if block.title:
            path = folder / block.title
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
        elif block.kind == "console":
            for words, expected in commands(block.text):
                yield _run(block, words, _argv(words, interpreter), expected, folder, env)
        elif block.kind == "python":
            after = todo[i + 1] if i + 1 < len(todo) and todo[i + 1].kind == "text" else None
            script = folder / f"block_{i}.py"
            script.write_text(block.text, encoding="utf-8")
            expected = tuple(after.text.splitlines()) if after else ()
            yield _run(after or block, script.name, [interpreter, script.name], expected, folder, env)


def commands(text: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """(command, expected lines) of a console block."""
    for part in re.split(r"^\$ ", text, flags=re.M)[1:]:
        words, *lines = re.sub(r"\\\n\s*", "", part).splitlines()
        yield words, tuple(line for line in lines if line.strip())


def _argv(words: str, interpreter: str) -> list[str]:
    argv = shlex.split(words, comments=True)
    if argv[0] not in PROGRAMS and not argv[0].startswith("./"):
        raise ValueError(f"console: expected one of {', '.join(PROGRAMS)} or ./program; found {argv[0]!r}")
    if argv[0] == "softsoil":
        return [interpreter, "-m", "softsoil", *argv[1:]]
    return [interpreter, *argv[1:]] if argv[0] == "python" else argv


def _run(
    block: Block, words: str, argv: list[str], expected: tuple[str, ...], folder: Path, env: Mapping[str, str]
) -> Printed:
    done = subprocess.run(argv, cwd=folder, env=env, capture_output=True, text=True, check=False)
    lines = tuple((done.stdout + done.stderr).splitlines())
    return Printed(block, words, expected, lines, done.returncode, done.stderr)


def environment(python: Path | None = None) -> dict[str, str]:
    """The environment of a page's commands: this project first, tools of this Python on the path, a wide terminal.

    python: an interpreter with softsoil installed; then the project is left out.
    """
    tools = str((python or Path(sys.executable)).parent)
    env = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    env |= {"COLUMNS": "140", "MPLBACKEND": "agg", "SOURCE_DATE_EPOCH": "0"}
    env["PATH"] = f"{tools}{os.pathsep}{env.get('PATH', '')}"
    return env if python else env | {"PYTHONPATH": str(PROJECT)}


def plain(line: str) -> str:
    """A line without the borders of a table and with single blanks."""
    return " ".join(BORDERS.sub(" ", line).split())


def same(expected: str, actual: str, scatter: float) -> bool:
    """Whether two lines have the same words and numbers within `scatter` (share), or one unit of the last digit.

    A whole number is a count, which must agree, but for a percentage.
    """
    a, b = plain(expected), plain(actual)
    if NUMBER.sub("#", a) != NUMBER.sub("#", b):
        return False
    for x, y in zip(NUMBER.finditer(a), NUMBER.finditer(b), strict=True):
        one, two = (float(match[0].replace("−", "-")) for match in (x, y))
        unit = last_digit(x[0]) or float(a[x.end() :].startswith(" %"))
        if abs(one - two) > scatter * max(abs(one), abs(two)) + 1.5 * unit:
            return False
    return True


def last_digit(text: str) -> float:
    """The size of one unit of a number's last digit."""
    mantissa, _, exponent = text.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals)) if decimals or exponent else 0.0


def matched(expected: tuple[str, ...], actual: tuple[str, ...], scatter: float) -> list[tuple[str, str | None]]:
    """Each expected line with the printed line that it agrees with, in order; None where none does.

    `...` agrees with itself, and a line that ends with it with any that begins so.
    """
    found: list[tuple[str, str | None]] = []
    at = 0
    for line in expected:
        if line.strip() == "..." or not plain(line):
            found.append((line, line))
            continue
        start = line.removesuffix("...") if line.endswith("...") else ""
        hit = next((k for k in range(at, len(actual)) if _agrees(line, start, actual[k], scatter)), None)
        found.append((line, None if hit is None else line if start else actual[hit]))
        at = at if hit is None else hit + 1
    return found


def _agrees(expected: str, start: str, actual: str, scatter: float) -> bool:
    return actual.startswith(start.rstrip()) if start else same(expected, actual, scatter)
