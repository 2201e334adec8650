"""The folder of a C library from the texts of its files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

OWN = ("include/softsoil*.h", "src/softsoil*.[ch]", "fmi/fmu*.[ch]", "fmi/*Description.xml", "softsoil*.fmu", "example_drive.c",
       "CONTROLLER.md")  # fmt: skip
"""Files of a library's folder that another declaration or other options leave out: builds take what is there."""


def write_library(folder: str | Path, texts: Mapping[str, str]) -> list[Path]:
    """Write the files that differ from what stands in `folder`, and take away what an earlier library left there (OWN).

    Returns the paths of all, in order.
    """
    paths = []
    for old in sorted({path for pattern in OWN for path in Path(folder).glob(pattern)}):
        if old.relative_to(folder).as_posix() not in texts:
            old.unlink()
    for name, text in texts.items():
        path = Path(folder) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")
        paths.append(path)
    return paths
