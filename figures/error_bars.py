"""Picture of prediction errors before and after."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from softsoil.figures.error_table import Errors
from softsoil.figures.labels import SYMBOLS, quantity
from softsoil.figures.style import ESTIMATED, INITIAL, page
from softsoil.recording.drive import STATE_CHANNELS


def draw_errors(title: str, before: Errors, after: Errors, path: Path) -> Path:
    """Root mean square error before and after, per horizon and state; title: what was predicted; returns the path."""
    horizons = list(before)
    with page(path, f"{title}: prediction errors before and after", 10.0, 3.4, 1, len(horizons)) as axes:
        at = np.arange(len(STATE_CHANNELS))
        for axis, horizon in zip(axes, horizons, strict=True):
            pairs = ((before, INITIAL, "before", -0.2), (after, ESTIMATED, "after", 0.2))
            for table, colour, label, shift in pairs:
                values = [quantity(s).factor * np.sqrt(table[horizon][s]) for s in STATE_CHANNELS]
                axis.bar(at + shift, values, 0.38, color=colour, label=label)
            axis.set_yscale("log")
            axis.set_xticks(at, [f"{SYMBOLS[s]}\n{quantity(s).unit}" for s in STATE_CHANNELS])
            axis.grid(axis="x", visible=False)
            axis.set_title(f"Predicted {horizon} s ahead")
        axes[0].set_ylabel("rms error, units as named")
        axes[0].legend(loc="upper left")
    return path
