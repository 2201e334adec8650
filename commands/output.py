"""What every command writes: results with their provenance, under one folder, and the list of paths at the end."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from softsoil.commands.invocation import current, software
from softsoil.files.json_file import write_json

RUNS = Path("runs")
WIDTH_IN_A_FILE = 1000
"""Columns where there is no terminal: tables are as wide as their content, never cut off."""
console = Console(width=None if sys.stdout.isatty() else WIDTH_IN_A_FILE, markup=False)
"""Where tables and progress go; brackets are text, as in the keys of maps and vehicle files."""
SILENT = 30.0
"""s after which a command without a terminal says on stderr how far it is."""


@dataclass(frozen=True)
class OutputFolder(os.PathLike[str]):
    """A folder that a command writes in, made when the first file in it is named: a run that fails leaves none behind."""

    path: Path

    def __truediv__(self, name: str) -> Path:
        self.path.mkdir(parents=True, exist_ok=True)
        return self.path / name

    def __fspath__(self) -> str:
        return str(self.path)

    def __str__(self) -> str:
        return str(self.path)


def output_folder(out: Path | None, command: str, writes: Sequence[str] = ()) -> OutputFolder:
    """The folder that a command writes in: `out`, or runs/<command>; checked before any work, made with its first file.

    writes: names that its files may have there: what an earlier run left of them goes once this one has written its own. Raises
    ValueError where it is a file or cannot be written, or where an input would be written over.
    """
    folder = out if out is not None else RUNS / command
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"--out: expected a folder, found a file at {folder}")
    for name in writes:
        if (folder / name).is_file() and (folder / name).resolve() in current().given():
            raise ValueError(f"--out: expected a folder where no input is written over, found {folder / name}: name another one")
    _check_writable(folder)
    current().folder, current().writes = folder, tuple(writes)
    return OutputFolder(folder)


def _check_writable(folder: Path) -> None:
    """Make the folder and a file in it, and take away what was made: what a system allows is known by trying alone."""
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        reason = error.strerror or str(error)
        raise ValueError(f"--out: expected a folder that can be written, found {folder}: {reason}") from None
    finally:
        for path in made:
            with suppress(OSError):  # not there, or no longer empty
                path.rmdir()


def write_result(path: Path, content: Mapping[str, Any], vehicle: Mapping[str, str] | None = None) -> Path:
    """Write the JSON of a command with its provenance: software (version, command line) and vehicle (name, file).

    content: the result; vehicle: null in the file where the command has none. Returns the path.
    """
    return write_json(path, {"software": software(), "vehicle": vehicle, **content})


def say_written(paths: Sequence[Path]) -> None:
    """The last lines of a command: what it wrote. What an earlier run wrote and this one did not is taken away: it would be read
    as this one's."""
    folder, names = current().folder, current().writes
    if folder is not None:
        for path in (folder / name for name in names):
            if path not in paths:
                path.unlink(missing_ok=True)
    for path in paths:
        # Not wrapped at the width of the terminal: paths are copied from here.
        console.print(f"wrote {path}", soft_wrap=True, highlight=False)


@contextmanager
def progress(label: str) -> Iterator[Callable[[float], None]]:
    """A progress bar that disappears when done; yields its setter, shares 0 to 1.

    Where there is no terminal, one line, and another on stderr where 30 s were silent: the log of a cluster shows how far it is.
    """
    if not console.is_terminal:
        console.print(f"{label} ...", highlight=False)
        yield _on_stderr(label)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(label, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def _on_stderr(label: str) -> Callable[[float], None]:
    """Setter of shares that writes a line on stderr where it was silent for `SILENT` seconds."""
    began = said = time.monotonic()

    def tell(share: float) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= SILENT:
            said = now
            print(f"{label}: {share:.0%} after {now - began:.0f} s", file=sys.stderr, flush=True)

    return tell
