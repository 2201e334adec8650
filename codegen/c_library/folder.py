"""The folder of a C library from the texts of its files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path


def write_library(folder: str | Path, texts: Mapping[str, str]) -> list[Path]:
    """Write the files that differ from what stands in `folder`; returns the paths of all, in order."""
    paths = []
    for name, text in texts.items():
        path = Path(folder) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")
        paths.append(path)
    return paths
