"""Exit codes, one-line errors and warnings, in one place for all commands: 0 done, 2 bad input, 1 an internal failure."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from typer.core import TyperGroup

from softsoil.commands.invocation import Invocation, invoked

BAD_INPUT = 2
OWN_FAILURE = 1
SHOWN = (UserWarning, RuntimeWarning)
"""Warnings that concern a user; deprecations are the developers' own."""


class Guarded(TyperGroup):
    """A group of commands whose faults end in one line and an exit code.

    ValueError and OSError are taken for bad input, as is a wrong option; anything else is the program's own failure.
    With SOFTSOIL_DEBUG set, the traceback is shown instead.
    """

    def main(self, args: Any = None, *more: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        """Run on the arguments `args` (default: the process's); exit with the code of the outcome (`standalone_mode`),
        or return it."""
        arguments = list(sys.argv[1:] if args is None else args)
        with invoked(arguments) as invocation, plain_warnings():
            code = self._run(arguments, more, extra, invocation)
        if standalone_mode:
            sys.exit(code)
        return code

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an interruption ends as an abort, which typer would otherwise turn into a bare exit code."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise typer.Abort from None

    def _run(self, arguments: list[str], more: tuple[Any, ...], extra: dict[str, Any], invocation: Invocation) -> int:
        try:
            result = super().main(arguments, *more, **{**extra, "standalone_mode": False})
        except typer.Abort:
            return _fail(f"stopped by the user; {invocation.left_behind()}", OWN_FAILURE)
        except (ValueError, OSError) as error:
            if type(error).__name__ == "LinAlgError":  # a ValueError of NumPy's, and no input that could be mended
                return _own_failure(error)
            return _bad_input(f"{str(error) or type(error).__name__}{invocation.earlier_results()}")
        except Exception as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # the help has been printed
                return BAD_INPUT
            if hasattr(error, "format_message"):  # a usage error of typer's: unknown option, wrong type
                return _bad_input(error.format_message())
            return _own_failure(error)
        return result if isinstance(result, int) else 0


@contextmanager
def plain_warnings() -> Iterator[None]:
    """Warnings inside the block as one plain line each, once, without file names and code."""
    said: set[str] = set()

    def show(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
        text = " ".join(str(message).split())
        if issubclass(category, SHOWN) and text not in said:
            said.add(text)
            typer.echo(f"warning: {text}", err=True)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def _own_failure(error: Exception) -> int:
    _show_traceback()
    return _fail(f"a failure of the program's own: {type(error).__name__}: {error}", OWN_FAILURE)


def _bad_input(words: str) -> int:
    _show_traceback()
    return _fail(words, BAD_INPUT)


def _fail(words: str, code: int) -> int:
    typer.echo("error: " + " ".join(words.split()), err=True)
    return code


def _show_traceback() -> None:
    if os.environ.get("SOFTSOIL_DEBUG"):
        raise
