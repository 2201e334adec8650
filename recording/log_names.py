"""What a log's name tells: its soil class and its true n, as the reference runs and the project's own write them."""

from __future__ import annotations

import re

_TRUE_N = re.compile(r"_n(\d+\.\d+)(?!.*_to_)")
_SOILS = (("sandyloam", "sandy_loam"), ("sandy_loam", "sandy_loam"), ("clay", "clay"), ("sand", "sand"))


def named_n(name: str) -> float | None:
    """True n of a log called e.g. `paper_clay_n0.50`; None where the name has none, or says that it changes."""
    found = _TRUE_N.search(name)
    return float(found.group(1)) if found else None


def named_soil(name: str) -> str | None:
    """Soil class of a log called e.g. `paper_sandyloam_n0.70`; None where the name has none."""
    parts = f"_{name}_"
    return next((soil for word, soil in _SOILS if f"_{word}_" in parts), None)
