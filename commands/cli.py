"""The command line: one console script, `softsoil`; each command stands in its own module, loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import version
from types import MappingProxyType
from typing import Annotated, Any

import typer

from softsoil.commands.guard import Guarded

COMMANDS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "inspect": ("softsoil.commands.inspect", "inspect"),
        "import": ("softsoil.commands.import_log", "import_log"),
        "study": ("softsoil.commands.study", "study"),
        "estimate": ("softsoil.commands.estimate", "estimate"),
        "map": ("softsoil.commands.map", "map_soil"),
        "residual": ("softsoil.commands.residual", "residual"),
        "identify": ("softsoil.commands.identify", "identify_command"),
        "soil": ("softsoil.commands.soil", "soil_command"),
        "refine": ("softsoil.commands.refine", "refine_command"),
        "generate": ("softsoil.commands.generate", "generate"),
        "drive": ("softsoil.commands.drive", "drive"),
        "calibrate": ("softsoil.commands.calibrate", "calibrate"),
        "sweep": ("softsoil.commands.sweep", "sweep"),
        "blind-test": ("softsoil.commands.blind", "blind_test"),
        "case": ("softsoil.commands.case", "case_app"),
        "bench": ("softsoil.commands.bench", "bench"),
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


def _say_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"softsoil {version('softsoil')}")
        raise typer.Exit


@app.callback()
def softsoil(
    version: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Vehicles on deformable soil: terrain estimated, states predicted, models refined from logs."""
