"""Markdown tables and rows from plain cells."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Page = str
"""The text of a page."""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table of `head` and `rows`, cells escaped so that a bar inside one does not end it."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in line) + " |" for line in lines)


def code(text: str) -> str:
    """Inline code; nothing for an empty text."""
    return f"`{text}`" if text else ""


def unit_of(text: str) -> str:
    """A unit as a reader expects it: 1 for a pure number, superscripts in place of ^2."""
    return (text or "1").replace("^2", "²").replace("^3", "³")


def number(value: float) -> str:
    """A number with at most six digits."""
    return f"{value:.6g}"
