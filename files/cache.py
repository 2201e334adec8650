"""Where what is made once is kept for the next run."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder() -> Path:
    """Where what is made once is kept: $SOFTSOIL_CACHE, else the user's cache folder."""
    chosen = os.environ.get("SOFTSOIL_CACHE")
    return Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "softsoil"
