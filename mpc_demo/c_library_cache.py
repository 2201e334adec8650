"""The texts of a C library, generated once for each declaration and each state of the code."""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import version
from pathlib import Path

import symbolic
from estimator.compiled import cache_folder
from mpc_demo import c_library
from symbolic.declaration import Declaration, declaration_toml


def texts_from_cache(declared: Declaration, dt: float, fmi: bool = False) -> dict[str, str]:
    """`c_library_texts`, from the cache where neither the declaration nor any file that writes them has changed."""
    path = cache_folder() / f"clibrary_{_key(declared, dt, fmi)}.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        texts = c_library.c_library_texts(declared, dt, fmi)
    path.parent.mkdir(parents=True, exist_ok=True)
    scratch = path.with_suffix(f".{hashlib.sha256(repr(id(texts)).encode()).hexdigest()[:8]}")
    scratch.write_text(json.dumps(texts), encoding="utf-8")
    scratch.replace(path)
    return texts


def _key(declared: Declaration, dt: float, fmi: bool) -> str:
    found = hashlib.sha256(f"{declaration_toml(declared)}{dt!r}{fmi}{version('casadi')}".encode())
    package = Path(symbolic.__path__[0])
    sources = [path for path in sorted(package.rglob("*")) if path.suffix in (".py", ".in", ".toml")]
    for path in [*sources, Path(c_library.__file__), package.parent / "estimator" / "terrain.py"]:
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()[:24]
