"""The run of a command: its command line as typed, where it writes, and what an interruption leaves behind."""

from __future__ import annotations

import shlex
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path


@dataclass
class Invocation:
    """arguments: as typed after `softsoil`; began: time of the clock (s); folder: where the command writes, once it is
    chosen, and writes: the names that its files have there; resumes: file of results from which the same command goes on
    after an interruption.
    """

    arguments: tuple[str, ...] = ()
    began: float = field(default_factory=time.time)
    folder: Path | None = None
    writes: tuple[str, ...] = ()
    resumes: Path | None = None

    def given(self) -> set[Path]:
        """What the arguments may name of files, with or without an option's name before them."""
        return {Path(word).resolve() for argument in self.arguments for word in (argument, argument.partition("=")[2]) if word}

    def left_behind(self) -> str:
        """What an interruption keeps, as the end of a sentence."""
        if self.resumes is not None and self.resumes.is_file():
            return f"finished results are kept in {self.resumes}, and the same command resumes there"
        if self.folder is None or not self.folder.is_dir():
            return "nothing was written"
        # Files of this run; the clocks of some file systems count whole seconds.
        kept = [path for path in self.folder.rglob("*") if path.is_file() and path.stat().st_mtime >= self.began - 1.0]
        return f"{len(kept)} files written before are kept in {self.folder}" if kept else "nothing was written"

    def earlier_results(self) -> str:
        """What the folder holds of an earlier run of a command that was refused, as the end of its message, or nothing."""
        if self.resumes is not None or self.folder is None or not self.folder.is_dir():
            return ""
        results = [path.stat().st_mtime for path in self.folder.glob("*.json")]
        earlier = results and max(results) < self.began - 1.0
        return f"; {self.folder} still holds the results of an earlier run" if earlier else ""


_CURRENT: ContextVar[Invocation | None] = ContextVar("invocation", default=None)


@contextmanager
def invoked(arguments: Sequence[str]) -> Iterator[Invocation]:
    """The invocation with these arguments, current inside the block."""
    invocation = Invocation(tuple(arguments))
    token = _CURRENT.set(invocation)
    try:
        yield invocation
    finally:
        _CURRENT.reset(token)


def current() -> Invocation:
    """The invocation of the command that runs; one without arguments where none does."""
    return _CURRENT.get() or Invocation()


def software() -> dict[str, str]:
    """Version and command line of what runs, for JSON and reports."""
    return {"version": version("softsoil"), "command": shlex.join(["softsoil", *current().arguments])}
