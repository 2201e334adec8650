"""What every command writes: JSON with finite numbers, under one folder, and the list of paths at the end."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

RUNS = Path("runs")
WIDTH_IN_A_FILE = 110
console = Console(width=None if sys.stdout.isatty() else WIDTH_IN_A_FILE)
"""Where tables and progress go."""


def output_folder(out: Path | None, command: str) -> Path:
    """The folder that a command writes in, made if need be: `out`, or runs/<command>. ValueError where it is a file."""
    folder = out if out is not None else RUNS / command
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"--out: expected a folder, found a file at {folder}")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def plain(value: Any) -> Any:
    """`value` as JSON has it: NumPy scalars and arrays as numbers and lists, null for what is not finite."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if hasattr(value, "tolist"):  # NumPy's
        return plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(entry) for entry in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def write_json(path: Path, data: Mapping[str, Any]) -> Path:
    """Write `data` as UTF-8 JSON with finite numbers only (null where there is none); returns the path."""
    text = json.dumps(plain(data), indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")
    return path


def say_written(paths: Sequence[Path]) -> None:
    """The last lines of a command: what it wrote."""
    for path in paths:
        # Not wrapped at the width of the terminal: paths are copied from here.
        console.print(f"wrote {path}", soft_wrap=True, highlight=False, markup=False)


@contextmanager
def progress(label: str) -> Iterator[Callable[[float], None]]:
    """A progress bar that goes away when done (one line where there is no terminal); yields what is told the share, 0 to 1."""
    if not console.is_terminal:
        console.print(f"{label} ...", highlight=False)
        yield lambda share: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(label, total=1.0)
        yield lambda share: bar.update(task, completed=share)
