"""The texts of a C library, kept for the next time that the same is asked of the same code; and what identifies that code."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from softsoil.files.cache import cache_folder, scratch_folder
from softsoil.files.own_modules import own_code

WRITERS = (
    ("files", "*"), ("recording", "*"), ("checking", "*"), ("symbolic", "**/*"), ("declaration", "*"), ("codegen", "**/*"),
    ("windows", "*"), ("estimator", "*"), ("control", "*"), ("commands", "*generate*"), ("commands", "options_model*"),
)  # fmt: skip
"""Rooms that the texts come from or whose defaults say what is asked for, and which of their files."""
SUFFIXES = (".py", ".in", ".toml")

Said = str | float | bool | Path | None


def asked_for(*said: Said) -> bytes:
    """What identifies a request: each thing said as text, and the bytes of the file that a Path leads to."""
    parts = []
    for thing in said:
        parts.append(str(thing).encode())
        if isinstance(thing, Path) and thing.is_file():
            parts.append(thing.read_bytes())
    return b"\0".join(str(len(part)).encode() + b":" + part for part in parts)


def texts_from_cache(asked: bytes, make: Callable[[], dict[str, str]]) -> dict[str, str]:
    """Path inside the library's folder -> text: from the cache where the same was `asked` of the same code, else made anew."""
    texts = kept_texts(asked)
    if texts is None:
        texts = make()
        keep(_place(asked), json.dumps(texts))
    return texts


def kept_texts(asked: bytes) -> dict[str, str] | None:
    """The texts that the same code made of the same request before; None where there are none."""
    try:
        return json.loads(_place(asked).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def keep(path: Path, text: str) -> None:
    """Write a file of the cache so that another process never sees half of it; none where the cache cannot be written."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with scratch_folder(path.parent) as scratch:
            (scratch / path.name).write_text(text, encoding="utf-8")
            (scratch / path.name).replace(path)


def _place(asked: bytes) -> Path:
    return cache_folder() / f"clibrary_{_key(asked)}.json"


def _key(asked: bytes) -> str:
    return hashlib.sha256(asked + own_code() + code_digest(WRITERS)).hexdigest()[:24]


@lru_cache(maxsize=4)
def code_digest(writers: tuple[tuple[str, str], ...]) -> bytes:
    """What changes with the code of `writers` (pairs of a room and a pattern of its files), or with a version."""
    found = hashlib.sha256(version("casadi").encode() + version("softsoil").encode())
    for room, pattern in writers:
        found_files = (Path(str(files("softsoil"))) / room).glob(pattern)
        for path in sorted(path for path in found_files if path.suffix in SUFFIXES):
            found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.digest()
