"""The world: soil contact model, single-wheel rig, vehicle, manoeuvres and sensors; no equation of the estimator's in it.

Compiled kernels are cached per state of the whole package: numba compares only the file a kernel stands in, not those
it calls, so an edit elsewhere would leave stale machine code behind.
"""

import hashlib
from pathlib import Path

from numba.core import config


def source_hash() -> str:
    """Hash of every module of this package."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


if not config.CACHE_DIR:  # type: ignore[attr-defined]
    config.CACHE_DIR = str(Path(__file__).parent / "__pycache__" / f"numba-{source_hash()}")  # type: ignore[attr-defined]
