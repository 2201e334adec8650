"""`softsoil inspect`: what a recording holds, and a draft of the map that imports it."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from softsoil.commands.options_model import OutOption
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.importing.bring_in import inspect_sources
from softsoil.importing.draft_map import draft, offers
from softsoil.importing.sources import Holding

MOST_FIELDS = 12
"""Fields of a source that the terminal shows; inspect.json has all."""
FIELDS_WIDTH = 72
"""Characters of their column, also where the output goes to a file."""


def inspect(
    sources: Annotated[
        list[Path], typer.Argument(metavar="SOURCE...", help="Bags (file or folder) and tables.", show_default=False)
    ],
    out: OutOption = None,
) -> None:
    """Topics or columns of bags and tables, their rates and clocks, units guessed; writes a draft of the map.

    Example: softsoil inspect my_bag/ gps.csv --out runs/my_log
    """
    with progress(", ".join(path.name for path in sources)) as told:
        holdings = inspect_sources(sources, told)
    console.print(source_table(holdings))
    for offer in sorted(offers(holdings), key=lambda offer: (offer.channel, -offer.score)):
        fields = " and ".join((offer.path, *offer.beside)) + (" (rate)" if offer.rate else "")
        unit = f" [{offer.unit}]" if offer.unit else ""
        console.print(f"{offer.channel}: {offer.source}:{fields}{unit}, by {offer.why}", highlight=False)
    folder = output_folder(out, "inspect", ("inspect.json",))
    toml, text = folder / "map.toml", draft(holdings)
    if toml.is_file() and toml.read_text(encoding="utf-8") != text:
        earlier = toml.replace(_free(folder / "map.before.toml"))  # somebody may have edited it
        console.print(f"the earlier {toml} is now {earlier}", highlight=False)
    toml.write_text(text, encoding="utf-8")
    content = {"sources": [holding.as_json() for holding in holdings]}
    say_written([toml, write_result(folder / "inspect.json", content)])


def _free(path: Path) -> Path:
    """That path, or the first of its name with a number that no file has."""
    numbered = (path.with_name(f"{path.stem}.{k}{path.suffix}") for k in count(2))
    return path if not path.exists() else next(other for other in numbered if not other.exists())


def source_table(holdings: list[Holding]) -> Table:
    """One row per source: kind, count, rate, span, clock, fields."""
    table = Table(title="Sources", title_justify="left")
    for heading in ("source", "kind", "count", "Hz", "s", "clock", "fields"):
        width = FIELDS_WIDTH if heading == "fields" else None
        table.add_column(
            heading, justify="right" if heading in ("count", "Hz", "s") else "left", overflow="fold", max_width=width
        )
    for h in holdings:
        names = list(h.fields)
        more = f" and {len(names) - MOST_FIELDS} more" if len(names) > MOST_FIELDS else ""
        span = f"{h.stop_s - h.start_s:.1f}"
        table.add_row(
            h.name, h.kind, str(h.count), f"{h.rate_hz:.4g}", span, h.clock, ", ".join(names[:MOST_FIELDS]) + more
        )
    return table
