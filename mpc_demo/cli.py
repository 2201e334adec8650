"""The command line: one console script, `softsoil`; each command stands in its own module, loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Any

import typer

from mpc_demo.guard import Guarded

COMMANDS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "study": ("mpc_demo.commands_study", "study"),
        "estimate": ("mpc_demo.commands_estimate", "estimate"),
        "residual": ("mpc_demo.commands_residual", "residual"),
        "refine": ("mpc_demo.commands_refine", "refine_command"),
        "generate": ("mpc_demo.commands_generate", "generate"),
        "drive": ("mpc_demo.commands_drive", "drive"),
        "calibrate": ("mpc_demo.commands_calibrate", "calibrate"),
        "sweep": ("mpc_demo.commands_sweep", "sweep"),
        "blind-test": ("mpc_demo.commands_blind", "blind_test"),
        "case": ("mpc_demo.commands_case", "case_app"),
        "bench": ("mpc_demo.commands_bench", "bench"),
    }
)
"""Name -> module and what it holds: a function, or an app with commands of its own."""


class Commands(Guarded):
    """The commands by name; the modules of the others stay unread, and what they import with them."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names, in the order of their use."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, name: str) -> Any:
        """The command called `name`, None for one that there is not."""
        if name not in COMMANDS:
            return None
        module, attribute = COMMANDS[name]
        held = getattr(import_module(module), attribute)
        if not isinstance(held, typer.Typer):
            single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
            single.command(name)(held)
            held = single
        command = typer.main.get_command(held)
        command.name = name
        return command


app = typer.Typer(
    cls=Commands, name="softsoil", no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False
)


@app.callback()
def softsoil() -> None:
    """Vehicles on deformable soil: terrain estimated, states predicted, models refined from logs."""
