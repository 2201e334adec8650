"""Exit codes and one-line errors, in one place for all commands: 0 done, 2 bad input, 1 a failure of the program's own."""

from __future__ import annotations

import os
import sys
from typing import Any

import typer
from typer.core import TyperGroup

BAD_INPUT = 2
OWN_FAILURE = 1


class Guarded(TyperGroup):
    """A group of commands whose faults end in one line and an exit code.

    ValueError and OSError are taken for bad input, as is a wrong option; anything else is the program's own failure.
    With SOFTSOIL_DEBUG set, the traceback is shown instead.
    """

    def main(self, *args: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        """Run; exit with the code of the outcome (`standalone_mode`), or return it."""
        code = self._run(args, extra)
        if standalone_mode:
            sys.exit(code)
        return code

    def _run(self, args: tuple[Any, ...], extra: dict[str, Any]) -> int:
        try:
            result = super().main(*args, **{**extra, "standalone_mode": False})
        except typer.Abort:
            return _fail("stopped by the user", OWN_FAILURE)
        except (ValueError, OSError) as error:
            return _bad_input(error)
        except Exception as error:
            if type(error).__name__ == "NoArgsIsHelpError":  # the help has been printed
                return BAD_INPUT
            if hasattr(error, "format_message"):  # a usage error of typer's: unknown option, wrong type
                return _bad_input(error, error.format_message())
            _show_traceback()
            return _fail(f"a failure of the program's own: {type(error).__name__}: {error}", OWN_FAILURE)
        return result if isinstance(result, int) else 0


def _bad_input(error: Exception, words: str | None = None) -> int:
    _show_traceback()
    return _fail(words or str(error) or type(error).__name__, BAD_INPUT)


def _fail(words: str, code: int) -> int:
    typer.echo("error: " + " ".join(words.split()), err=True)
    return code


def _show_traceback() -> None:
    if os.environ.get("SOFTSOIL_DEBUG"):
        raise
