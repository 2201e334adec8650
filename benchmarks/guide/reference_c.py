"""The C interface, from the generated header."""

from __future__ import annotations

import re
from pathlib import Path

from benchmarks.guide.markdown import code, table

HEADER = Path(__file__).resolve().parents[2] / "generated" / "include" / "softsoil.h"


def c_reference() -> str:
    """Functions with their comments, status codes, options and the filter's fields, from `generated/include/softsoil.h`.

    Raises ValueError where the header has no function that can be read.
    """
    text = HEADER.read_text(encoding="utf-8")
    functions = re.findall(r"/\*((?:(?!\*/).)*?)\*/\n((?:[\w ]+[ *]+softsoil_\w+\([^;]*?\);\n)+)", text, re.S)
    if not functions:
        raise ValueError(f"{HEADER.name}: expected commented prototypes, found none")
    states = re.findall(r"^  (SOFTSOIL_\w+), /\* (.*?) \*/", text, re.M)
    parts = ["## Functions\n"]
    for comment, prototypes in functions:
        words = re.sub(r"\s*\n \* ?", " ", comment).strip()
        parts.append(f"```c\n{prototypes.strip()}\n```\n\n{words}\n")
    parts += ["## Status codes\n", table(("code", "meaning"), [(code(name), words) for name, words in states]), ""]
    for name, title in (("softsoil_options_t", "Options"), ("softsoil_t", "The filter's fields")):
        rows = _fields(text, name)
        parts += [f"## {title}\n", f"`{name}`\n", table(("field", "type", "meaning"), rows), ""]
    return "\n".join(parts)


def _fields(text: str, name: str) -> list[tuple[str, str, str]]:
    """(fields, type, comment) of a struct's commented lines."""
    (body,) = re.findall(r"typedef struct \{\n((?:(?!typedef).)*?)\} " + name + ";", text, re.S)
    return [
        (code(fields), code(kind), words)
        for kind, fields, words in re.findall(r"^  ([\w ]+?) ([\w ,\[\]>?:0-9]+); +/\* (.*?) \*/", body, re.M)
    ]
