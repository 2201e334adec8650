"""Which figures and numbers of the documentation changed beyond their scatter.

    python -m benchmarks.figures_of_docs [--slow] [--only TEXT] [--write]

Carries out the commands of `docs/figures.toml`, the tutorials and the README, and compares what they make with the pages:
numbers within their scatter, pictures by the share of pixels that differ. --slow: also what takes longer than a minute; --only:
entries whose page, picture or command contains TEXT; --write: bring pictures and printed lines up to date (numbers in prose are
named, not rewritten). Exit code 1 where something changed.
"""

from __future__ import annotations

import argparse
import base64
import io
import json
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np

from benchmarks.guide.blocks import NUMBER, PROJECT, environment, plain, run_page

TABLE = PROJECT / "docs" / "figures.toml"
PICTURES = PROJECT / "docs" / "pictures"
PAGES = (PROJECT / "README.md", *sorted((PROJECT / "docs" / "tutorials").glob("*.md")))
SLOW_PAGES = ("my-vehicle", "missing-effect")
ELSEWHERE = ("add-an-effect",)
"""Followed by its own test, in a copy of the project."""
PIXELS = 0.02
"""Share of a picture's pixels that may differ: another version of a font, the last digit of a title."""
TONE = 0.1
"""From which difference of a tone (of 1) on a pixel differs."""


def main() -> int:
    """Print one line per figure, number and page; 1 where one changed."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--slow", action="store_true", help="also what takes longer than a minute")
    options.add_argument("--only", default="", metavar="TEXT", help="entries that contain TEXT")
    options.add_argument("--write", action="store_true", help="bring pictures and printed lines up to date")
    chosen = options.parse_args()
    changed = 0
    for name, verdict in (*judged_entries(chosen), *judged_pages(chosen)):
        changed += verdict.startswith("changed")
        print(f"{name}: {verdict}", flush=True)
    return 1 if changed else 0


def judged_entries(chosen: argparse.Namespace) -> Iterator[tuple[str, str]]:
    """(name, verdict) of the table's figures and numbers."""
    table = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as folder:

        @cache
        def run(command: str) -> tuple[Path, str]:
            return carry_out(command, Path(tempfile.mkdtemp(dir=folder)))

        for entry in (*table["figure"], *table["number"]):
            name = entry.get("picture") or f"{entry['page']}, {entry['shown']!r}"
            if chosen.only not in f"{name} {entry['command']}":
                continue
            if entry.get("slow") and not chosen.slow:
                yield name, "left out: slow"
            elif "data" in entry and not (PROJECT / entry["data"]).exists():
                yield name, f"left out: needs {entry['data']}"
            else:
                out, printed = run(entry["command"])
                yield name, (figure if "picture" in entry else number)(entry, out, printed, chosen.write)


def carry_out(command: str, out: Path) -> tuple[Path, str]:
    """Run a command of the table in the project; what it wrote stands in `out`. Returns that folder and what it printed.

    Raises ValueError for a command that fails.
    """
    argv = shlex.split(command.replace("{out}", str(out)))
    start = ["-m", "softsoil.commands.start"] if argv[0] == "softsoil" else []
    done = subprocess.run([sys.executable, *start, *argv[1:]], cwd=PROJECT, env=environment(), capture_output=True, text=True)
    if done.returncode:
        raise ValueError(f"{command}: expected exit code 0, found {done.returncode}: {done.stderr[-300:]}")
    return out, done.stdout


def figure(entry: Mapping[str, Any], out: Path, printed: str, write: bool) -> str:
    """Verdict on a picture, or on a folder of pictures."""
    stored = PICTURES / entry["picture"]
    names = sorted(path.name for path in out.glob("*.png")) if stored.is_dir() else [""]
    verdicts = []
    for name in names:
        made = out / name if name else out / entry.get("made", entry["picture"])
        target = stored / name if name else stored
        share = difference(target, picture(made, entry.get("number", 0)))
        if share > PIXELS:
            verdicts.append(f"changed: {name} {100 * share:.0f} % of the pixels".replace("  ", " "))
        if write and (share > PIXELS or not target.exists()):
            target.write_bytes(picture(made, entry.get("number", 0)))
    return "; ".join(verdicts) or "as before"


def picture(made: Path, index: int) -> bytes:
    """The bytes of a picture: the file itself, or picture `index`, from 1, inside an HTML report."""
    if made.suffix != ".html":
        return made.read_bytes()
    inside = re.findall(r'src="data:image/png;base64,([^"]+)"', made.read_text(encoding="utf-8"))
    return base64.b64decode(inside[index - 1])


def difference(stored: Path, made: bytes) -> float:
    """Share of the pixels that differ; 1 for another size or no stored picture."""
    if not stored.exists():
        return 1.0
    one, two = matplotlib.image.imread(stored), matplotlib.image.imread(io.BytesIO(made))
    if one.shape[:2] != two.shape[:2]:
        return 1.0
    return float(np.mean(np.abs(one[..., :3] - two[..., :3]).max(axis=2) > TONE))


def number(entry: Mapping[str, Any], out: Path, printed: str, write: bool) -> str:
    """Verdict on a number in prose: whether the page has it, and whether the command still prints it."""
    if entry["shown"] not in (PROJECT / entry["page"]).read_text(encoding="utf-8"):
        return f"changed: the page no longer says {entry['shown']!r}"
    said = float(NUMBER.findall(entry["shown"])[0])
    if "key" in entry:
        value = float(value_at(json.loads((out / entry["file"]).read_text(encoding="utf-8")), entry["key"]))
    else:
        match = re.search(entry["pattern"], printed)
        if match is None:
            return f"changed: the command prints nothing like {entry['pattern']!r}"
        value = float(match[1])
    allowed = entry.get("scatter", 0.01) * abs(said)
    return f"as before, {value:g}" if abs(value - said) <= allowed else f"changed: {value:g}"


def value_at(content: Any, key: str) -> Any:
    """The value under a dotted key; an entry of a list is named by its `name`."""
    for part in key.split("."):
        content = content[part] if isinstance(content, dict) else next(item for item in content if item["name"] == part)
    return content


def judged_pages(chosen: argparse.Namespace) -> Iterator[tuple[str, str]]:
    """(name, verdict) of the pages whose blocks are carried out."""
    for page in PAGES:
        name = page.relative_to(PROJECT).as_posix()
        if page.stem in ELSEWHERE or chosen.only not in name:
            continue
        if page.stem in SLOW_PAGES and not chosen.slow:
            yield name, "left out: slow"
            continue
        text = page.read_text(encoding="utf-8")
        folder = Path(tempfile.mkdtemp())
        try:
            steps = list(run_page(text, folder))
        finally:
            shutil.rmtree(folder)
        faults = [fault for step in steps for fault in step.faults()]
        if chosen.write:
            page.write_text(updated(text, steps), encoding="utf-8")
        yield name, f"changed: {'; '.join(faults)}" if faults else "as before"


def updated(text: str, steps: list[Any]) -> str:
    """The page with every printed line as it is printed now; a line that nothing like is printed for stays."""
    for step in reversed(steps):
        begin, end = step.block.span
        body = text[begin:end]
        for line in step.expected:
            now = nearest(line, step.actual)
            if now is not None and now != line:
                body = body.replace(line, now.rstrip(), 1)
        text = text[:begin] + body + text[end:]
    return text


def nearest(line: str, actual: tuple[str, ...]) -> str | None:
    """The printed line with the same words whose numbers are nearest to those of `line`; None without one, or for `...`."""
    if line.strip().endswith("..."):
        return None

    def far(other: str) -> float:
        pairs = zip(NUMBER.findall(plain(line)), NUMBER.findall(plain(other)), strict=True)
        values = [(float(a.replace("−", "-")), float(b.replace("−", "-"))) for a, b in pairs]
        return sum(abs(a - b) / max(abs(a), abs(b), 1e-12) for a, b in values)

    like = [other for other in actual if NUMBER.sub("#", plain(other)) == NUMBER.sub("#", plain(line))]
    return min(like, key=far, default=None)


if __name__ == "__main__":
    raise SystemExit(main())
