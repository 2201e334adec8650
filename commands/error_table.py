"""Table of rms prediction errors on the terminal: per state and horizon, before and after."""

from __future__ import annotations

from rich.table import Table

from softsoil.figures.error_table import Errors
from softsoil.figures.labels import quantity, rms
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.refinement.words import number, ratio


def error_table(title: str, before: Errors, after: Errors | None = None) -> Table:
    """Root mean square error of each state over each horizon, in its own unit; after: None for one column per horizon."""
    table = Table(title=title, title_justify="left")
    table.add_column("state")
    for horizon in before:
        headings = (f"{horizon} s",) if after is None else (f"{horizon} s\nbefore", "\nafter", "\nratio")
        for heading in headings:
            table.add_column(heading, justify="right")
    for state in STATE_CHANNELS:
        cells = []
        for horizon in before:
            old = rms(state, before[horizon][state])
            cells.append(number(old))
            if after is not None:
                new = rms(state, after[horizon][state])
                cells += [number(new), ratio(old, new)]
        table.add_row(quantity(state).label, *cells)
    return table
