"""Reference written from the code: `python -m benchmarks.guide.reference commands` prints one part, as Markdown.

A page under `docs/` says `<!-- generated: commands -->` where a part stands; the site fills it in when it is built
(`benchmarks/guide/site.py`), so that no page is older than the code.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping
from types import MappingProxyType

from benchmarks.guide.reference_c import c_reference
from benchmarks.guide.reference_commands import commands_reference
from benchmarks.guide.reference_effects import effects_reference
from benchmarks.guide.reference_tables import channels_reference, python_reference, soils_reference, vehicle_reference

PARTS: Mapping[str, Callable[[], str]] = MappingProxyType(
    {
        "commands": commands_reference,
        "vehicle-numbers": vehicle_reference,
        "soils": soils_reference,
        "channels": channels_reference,
        "effects": effects_reference,
        "c-api": c_reference,
        "python": python_reference,
    }
)
"""Name of a part -> what writes it."""
MARK = re.compile(r"<!-- generated: ([\w-]+) -->")


def filled(markdown: str) -> str:
    """The page with every mark replaced by its part; ValueError for a part that there is not."""

    def part(mark: re.Match[str]) -> str:
        if mark[1] not in PARTS:
            raise ValueError(f"generated: expected one of {', '.join(PARTS)}; found {mark[1]!r}")
        return PARTS[mark[1]]()

    return MARK.sub(part, markdown)


def main() -> None:
    """Print the parts named."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("parts", nargs="+", choices=PARTS)
    for name in options.parse_args().parts:
        print(PARTS[name]())


if __name__ == "__main__":
    main()
