"""Picture of an identification: what an error of each number costs n."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from softsoil.figures.labels import plain
from softsoil.figures.numbers import COLOURS, shown_states
from softsoil.figures.style import page
from softsoil.identification.result import Identification, in_order

MOST = 12
"""Numbers that are drawn, those that cost most."""


def draw_costs(result: Identification, path: Path) -> Path:
    """Change of n by an error of one standard deviation of each number; returns the path."""
    names = sorted(in_order(result.numbers), key=lambda name: abs(result.numbers[name].n_percent_per_std))[-MOST:]
    states, more = shown_states(result.numbers), f", the {len(names)} largest" if len(result.numbers) > len(names) else ""
    with page(path, f"What an error of each number costs n{more}", 8.0, 3.6) as axis:
        at = np.arange(len(names))
        costs = [result.numbers[name].n_percent_per_std for name in names]
        axis.barh(at, costs, color=[COLOURS[states[name]] for name in names], height=0.62)
        axis.set_yticks(at, [plain(name) for name in names])
        axis.set_xlabel("change of n by one standard deviation, %")
    return path
