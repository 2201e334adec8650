"""Docstrings as a reader of the site wants them: arguments as a list, examples as code."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import griffe

EXAMPLE = re.compile(r"\bExample:\s+(.*)\Z", re.S)
SENTENCE = re.compile(r"(?<=[.;]) (?=[A-Z])")


class Readable(griffe.Extension):
    """Rewrites docstrings while the site is built; the sources stay as they are."""

    def on_object(self, *, obj: Any, loader: Any, **more: Any) -> None:
        """Rewrite the docstring of a function or class (arguments as griffe gives them)."""
        if isinstance(obj, griffe.Function | griffe.Class) and obj.docstring is not None:
            obj.docstring.value = readable(obj.docstring.value, [p.name for p in obj.parameters])


def readable(text: str, names: Sequence[str]) -> str:
    """The docstring with `name: meaning` of its arguments `names` as a list, and what follows `Example:` as a block of code."""
    example = EXAMPLE.search(text)
    prose = text[: example.start()] if example else text
    parts = [listed(" ".join(part.split()), names) for part in prose.strip().split("\n\n")]
    if example:
        parts.append(f"```python\n{without_margin(example[1])}\n```")
    return "\n\n".join(part for part in parts if part)


def listed(text: str, names: Sequence[str]) -> str:
    """A paragraph in which `a: ...; b, c: ... Raises ...` becomes a list and the sentences after it; others unchanged."""
    one = "|".join(map(re.escape, names))
    heads = list(re.finditer(rf"(?:^|(?<=[;.]) )((?:{one})(?:, (?:{one}))*): ", text)) if names else []
    if not heads:
        return text
    ends = [*(head.start() for head in heads[1:]), len(text)]
    meanings = [text[head.end() : end] for head, end in zip(heads, ends, strict=True)]
    meanings[-1], *after = SENTENCE.split(meanings[-1], maxsplit=1)
    items = (
        f"- {', '.join(f'`{name}`' for name in head[1].split(', '))}: {meaning.strip().rstrip(';.')}"
        for head, meaning in zip(heads, meanings, strict=True)
    )
    return "\n\n".join(part for part in (text[: heads[0].start()], "\n".join(items), *after) if part)


def without_margin(code: str) -> str:
    """An example without the indentation of its docstring."""
    first, *rest = code.strip().splitlines()
    margin = min((len(line) - len(line.lstrip()) for line in rest if line.strip()), default=0)
    return "\n".join([first.strip(), *(line[margin:].rstrip() for line in rest)])
