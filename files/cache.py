"""Disk cache of compiled functions and generated texts."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder() -> Path:
    """Folder of the cache: $SOFTSOIL_CACHE, else `softsoil` in the user's cache folder."""
    chosen = os.environ.get("SOFTSOIL_CACHE")
    return Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "softsoil"
