"""Names of logs: one for each of several; soil class and true n that a name tells, as the project's own runs are called."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from softsoil.recording.drive import Recording

_TRUE_N = re.compile(r"_n(\d+\.\d+)(?!.*_to_)")
_SOILS = (("sandyloam", "sandy_loam"), ("sandy_loam", "sandy_loam"), ("clay", "clay"), ("sand", "sand"))


def log_name(path: Path) -> str:
    """The name of a log that says none itself: that of its file without endings."""
    name = path.name
    for suffix in (".gz", ".csv", ".parquet"):
        name = name.removesuffix(suffix)
    return name


def distinct(drives: Iterable[Recording]) -> list[Recording]:
    """The drives, those that share a name called by their folders too, "run (monday)", or numbered where that does not help."""
    found = list(drives)
    for name in [name for name, count in Counter(drive.name for drive in found).items() if count > 1]:
        alike = [i for i, drive in enumerate(found) if drive.name == name]
        folders = [Path(found[i].meta.get("path", "")).resolve().parent.name for i in alike]
        marks = folders if len({*folders}) == len(folders) else range(1, len(alike) + 1)
        for i, mark in zip(alike, marks, strict=True):
            found[i] = replace(found[i], name=f"{name} ({mark})")
    return found


def named_n(name: str) -> float | None:
    """True n of a log called e.g. `paper_clay_n0.50`; None where the name has none, or says that it changes."""
    found = _TRUE_N.search(name)
    return float(found.group(1)) if found else None


def named_soil(name: str) -> str | None:
    """Soil class of a log called e.g. `paper_sandyloam_n0.70`; None where the name has none."""
    parts = f"_{name}_"
    return next((soil for word, soil in _SOILS if f"_{word}_" in parts), None)
