"""Table of rms prediction errors in a report: per state and horizon, before and after."""

from __future__ import annotations

from collections.abc import Mapping

from softsoil.figures.labels import quantity, rms
from softsoil.figures.page_html import table
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.refinement.words import number, ratio

Errors = Mapping[str, Mapping[str, float]]
"""Horizon (s, as text) -> state -> mean squared error, SI."""


def rms_table(before: Errors, after: Errors | None) -> str:
    """Root mean square errors of each state in the units of figures; after: None where nothing changed, then one column each."""
    heads = ["rms error"] if after is None else ["before", "after", "before/after"]
    first = "".join(f'<th class="r" colspan="{len(heads)}">{horizon} s</th>' for horizon in before)
    second = "".join(f'<th class="r">{head}</th>' for head in heads) * len(before)
    rows = [f'<tr><th rowspan="2">state</th>{first}</tr><tr>{second}</tr>']
    for state in STATE_CHANNELS:
        shown = quantity(state)
        cells = [f"<td>{shown.words} <span class='sub'>({shown.unit})</span></td>"]
        for horizon in before:
            old = rms(state, before[horizon][state])
            cells.append(f'<td class="r">{number(old)}</td>')
            if after is not None:
                new = rms(state, after[horizon][state])
                mark = "better" if new < 0.97 * old else ("worse" if new > 1.03 * old else "")
                cells += [f'<td class="r {mark}">{number(new)}</td>', f'<td class="r">{ratio(old, new)}</td>']
        rows.append(f"<tr>{''.join(cells)}</tr>")
    return table(rows)
