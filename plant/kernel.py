"""Compilation of the plant's kernels, cached on disk per state of the whole package.

numba compares only the file a kernel stands in, not those it calls, so an edit elsewhere would leave stale machine code
behind: the folder of the cache is named by a hash of all files. It stands in the project's cache, since an installed package
may be read-only.
"""

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import config

from softsoil.files.cache import writable_cache

_OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy"}
_INNER: dict[str, Any] = {**_OPTIONS, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


@lru_cache(maxsize=1)
def source_hash() -> str:
    """Hash of every module of this package."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def kernel_cache() -> Path:
    """Folder of the compiled kernels: $NUMBA_CACHE_DIR where it is set, else in the project's cache."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return Path(chosen) if chosen else writable_cache() / f"numba-{source_hash()}"


@contextmanager
def _cached_here() -> Iterator[None]:
    """numba reads its folder when a function is decorated: set for that moment only, for other users of numba it stays."""
    before = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(kernel_cache())  # type: ignore[attr-defined]
    try:
        yield
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]


def _compiled(options: dict[str, Any]) -> Callable[[Callable[..., Any]], Any]:
    def decorate(function: Callable[..., Any]) -> Any:
        with _cached_here():
            return njit(**options)(function)

    return decorate


kernel = _compiled(_OPTIONS)
"""A compiled function that Python may call; division by zero gives inf, as in numpy."""

inner = _compiled(_INNER)
"""A compiled function that only compiled ones call: without its Python side, which takes long to compile."""

geometry = _compiled({**_INNER, "fastmath": True})
"""As `inner`, free to reorder sums and to divide by multiplying: for finite geometry whose last bit does not matter."""
