"""What `softsoil identify` says of a vehicle file and `softsoil soil` of a soil file, as the file keeps it: its key `verdict`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

VERDICTS = ("identified", "needs_data", "contradicts_given")
IDENTIFIED, CONTRADICTED = VERDICTS[0], VERDICTS[-1]


def verdict_from_table(table: Mapping[str, Any], where: str) -> str:
    """The verdict in a parsed TOML table, empty where there is none; ValueError naming `where`, what was expected and found."""
    verdict = table.get("verdict", "")
    if verdict not in ("", *VERDICTS):
        raise ValueError(f"{where}: key 'verdict': expected one of {', '.join(VERDICTS)}; found {verdict!r}")
    return str(verdict)
