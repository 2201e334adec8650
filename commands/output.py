"""What every command writes: JSON with finite numbers, under one folder, and the list of paths at the end."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

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
