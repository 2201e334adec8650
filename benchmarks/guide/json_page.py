"""The keys of JSON files against the page that describes them, `docs/reference/json.md`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "json.md"
EVERY = "Every file"


def keys(content: Any, key: str = "") -> Iterator[str]:
    """Dotted keys of a JSON's content; [] stands for the entries of a list, of which the first shows the keys.

    An empty table has none.
    """
    if isinstance(content, dict):
        for name, value in content.items():
            yield from keys(value, f"{key}.{name}" if key else name)
    elif isinstance(content, list):
        yield from keys(content[0], f"{key}[]") if content and isinstance(content[0], dict | list) else (f"{key}[]",)
    else:
        yield key


def patterns(file: str) -> list[re.Pattern[str]]:
    """Keys that the page describes for a file, as expressions: <name> stands for any name.

    Raises ValueError for a file without section.
    """
    text = PAGE.read_text(encoding="utf-8")
    sections = dict(re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", text, re.M | re.S))
    if file not in sections:
        raise ValueError(f"{PAGE.name}: expected a section {file!r}, found {', '.join(sections)}")
    rows = re.findall(r"^\| (.*?) \|", sections[EVERY] + sections[file], re.M)
    described = [key for row in rows for key in re.findall(r"`([^`]+)`", row)]
    return [re.compile(r".+".join(re.escape(part) for part in re.split(r"<\w+>", key))) for key in described]


def undescribed(file: str, content: Any) -> list[str]:
    """Keys of a file's content that the page does not describe; a table that is null needs its entries described."""
    known = patterns(file)

    def described(key: str) -> bool:
        tables = (p.pattern.startswith(re.escape(f"{key}.")) for p in known)
        return any(p.fullmatch(key) or p.fullmatch(key.removesuffix("[]")) for p in known) or any(tables)

    return [key for key in keys(content) if not described(key)]
