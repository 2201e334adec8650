"""Sections of the commands, from their own help: docstrings, options and defaults as declared."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, get_type_hints

import typer
from typer.models import ArgumentInfo, OptionInfo

from benchmarks.guide.markdown import code, table
from softsoil.commands.cli import COMMANDS


def commands_reference() -> str:
    """Every command with its sentence, example, arguments and options."""
    return "\n".join(_section(name, function) for name, function in commands())


def commands() -> Iterator[tuple[str, Callable[..., Any]]]:
    """(name as typed, function) of every command, those of a group one by one."""
    for name, (module, attribute) in COMMANDS.items():
        held = getattr(import_module(module), attribute)
        if isinstance(held, typer.Typer):
            for inner in held.registered_commands:
                if inner.callback is not None:
                    yield f"{name} {inner.name or inner.callback.__name__.replace('_', '-')}", inner.callback
        else:
            yield name, held


def _section(name: str, function: Callable[..., Any]) -> str:
    text: list[str] = []
    examples: list[str] = []
    for paragraph in inspect.cleandoc(function.__doc__ or "").split("\n\n"):
        found = re.match(r"([^:]*): (softsoil .*)", paragraph.replace("\n", " "))
        (examples if found else text).append(found[2] if found else paragraph)
    lines = [f"## softsoil {name}\n", "\n\n".join(text), ""]
    if examples:
        lines += ["```", *examples, "```", ""]
    hints = get_type_hints(function, include_extras=True)
    rows = [_row(p, hints[p.name]) for p in inspect.signature(function).parameters.values()]
    return "\n".join([*lines, table(("option", "what it is", "default"), rows), ""])


def _row(parameter: inspect.Parameter, hint: Any) -> tuple[str, str, str]:
    """Name as typed, help and default of one parameter."""
    info = next(i for i in hint.__metadata__ if isinstance(i, ArgumentInfo | OptionInfo))
    name = parameter.name.replace("_", "-")
    declared = [word for word in (info.default, *(info.param_decls or ())) if isinstance(word, str) and word.startswith("-")]
    typed = name.upper() if isinstance(info, ArgumentInfo) else ", ".join(declared or [f"--{name}"])
    given = parameter.default
    said = "must be given" if given is inspect.Parameter.empty else "" if given in (None, False) else code(str(given))
    return code(typed), (info.help or "").strip().replace("<", "&lt;"), said
