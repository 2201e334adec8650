"""A `softsoil generate` that was answered before, answered without the libraries that the command line loads.

What was said, and where, leads to what was asked for and to the folder; what was asked for, with its files as they stand and
the code as it stands, leads to the texts (`text_cache`). A change in any of them leads to none, and the command runs.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.text_cache import Said, asked_for, keep, kept_texts
from softsoil.files.cache import cache_folder


def remember(arguments: Sequence[str], said: Sequence[Said], folder: Path, first: str = "", more: Sequence[str] = ()) -> None:
    """Keep what a command line, given in this working folder, asked for, where it was written, what the command said first, and
    `more`, its warnings; of softsoil's own alone."""
    if list(arguments[:1]) != ["generate"]:
        return
    told = [["file", str(thing)] if isinstance(thing, Path) else ["text", str(thing)] for thing in said]
    keep(_place(arguments), json.dumps({"said": told, "folder": str(folder), "first": first, "more": list(more)}))


def generated_again(arguments: Sequence[str]) -> bool:
    """Whether the same arguments were answered before and all is as it was: then the library is written, and said."""
    try:
        found = json.loads(_place(arguments).read_text(encoding="utf-8"))
        said = [Path(text) if kind == "file" else text for kind, text in found["said"]]
        texts = kept_texts(asked_for(*said))
        if texts is None:
            return False
        folder, first, more = Path(found["folder"]), str(found["first"]), [str(words) for words in found["more"]]
        folder.mkdir(parents=True, exist_ok=True)
        paths = write_library(folder, texts)
    except (OSError, ValueError, KeyError, TypeError):  # whatever is wrong, the command says it
        return False
    if first:
        print(first)
    for words in more:
        print(words, file=sys.stderr)
    for path in paths:
        print(f"wrote {path}")
    return True


def _place(arguments: Sequence[str]) -> Path:
    told = json.dumps([str(Path.cwd()), *arguments])
    return cache_folder() / f"generate_{hashlib.sha256(told.encode()).hexdigest()[:24]}.json"
