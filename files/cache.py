"""Disk cache of compiled functions and generated texts."""

from __future__ import annotations

import os
import platform
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

SCRATCH = "scratch_"
ABANDONED = 86400.0
"""s: a scratch folder older than this belongs to no process, on whichever machine it was made."""


def cache_folder() -> Path:
    """Folder of the cache: $SOFTSOIL_CACHE, else `softsoil` in the user's cache folder; one of this process alone for a user
    without a home."""
    chosen, caches = os.environ.get("SOFTSOIL_CACHE"), os.environ.get("XDG_CACHE_HOME")
    if chosen:
        return Path(chosen)
    try:
        return (Path(caches) if caches else Path.home() / ".cache") / "softsoil"
    except RuntimeError:
        return Path(_own_folder().name)


def writable_cache() -> Path:
    """The cache folder, made if need be; a folder of this process alone where it cannot be written."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return Path(_own_folder().name)
    return folder if os.access(folder, os.W_OK) else Path(_own_folder().name)


@lru_cache(maxsize=1)
def _own_folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="softsoil_")


@contextmanager
def scratch_folder(cache: Path) -> Iterator[Path]:
    """A folder inside the folder `cache` to build in, removed afterwards; what killed processes left there is removed first.

    A finished file is moved from it into the cache, so that no other process sees half of one.
    """
    _remove_abandoned(cache)
    with tempfile.TemporaryDirectory(dir=cache, prefix=f"{_here()}{os.getpid()}_") as name:
        yield Path(name)


def _remove_abandoned(cache: Path) -> None:
    for path in cache.glob(f"{SCRATCH}*"):
        try:
            if not _alive(path.name) or time.time() - path.stat().st_mtime > ABANDONED:
                shutil.rmtree(path, ignore_errors=True)
        except OSError:  # another process removed it
            continue


def _here() -> str:
    """Prefix of the scratch folders of this host and process namespace: containers of one host name do not see each other's
    processes."""
    try:
        numbers = "".join(filter(str.isdigit, str(Path("/proc/self/ns/pid").readlink())))  # of Linux
    except OSError:
        numbers = "0"
    return f"{SCRATCH}{platform.node()}_pids{numbers}_"


def _alive(name: str) -> bool:
    """Whether the process that made the scratch folder `name` may still run: on another machine nobody can say."""
    here = _here()
    number = name.removeprefix(here).split("_")[0]  # what follows it is random, underscores included
    if not name.startswith(here) or not number.isdigit() or os.name == "nt":
        return True
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True
