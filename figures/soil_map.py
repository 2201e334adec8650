"""Figure of a soil map: n per cell along the ways of the drives, and how well it is known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Rectangle

from softsoil.figures.style import SOFT, page
from softsoil.mapping.soil_map import Cell, DriveSoil


def draw_soil_map(cells: Sequence[Cell], drives: Sequence[DriveSoil], size: float, path: Path) -> Path:
    """Two maps, n and its standard deviation in per cent of n, side by side or, for a long way, below each other; size: of a
    cell (m)."""
    title = f"Sinkage exponent along {len(drives)} drive{'s' if len(drives) > 1 else ''}, cells of {size:g} m"
    wide, high = 1 + np.ptp([cell.column for cell in cells]), 1 + np.ptp([cell.row for cell in cells])
    long = wide > 1.6 * high
    height = float(np.clip(8.0 * high / wide + 1.1, 2.0, 6.0)) if long else 5.2
    with page(path, title, 9 if long else 11, 2 * height if long else height, *((2, 1) if long else (1, 2))) as axes:
        _cells(axes[0], cells, drives, size, np.array([c.n for c in cells]), "sinkage exponent n", "viridis")
        spread = np.array([100 * c.std / c.n for c in cells])
        _cells(axes[1], cells, drives, size, spread, "standard deviation, % of n", "magma_r")
    return path


def _cells(
    axis: Any, cells: Sequence[Cell], drives: Sequence[DriveSoil], size: float, values: np.ndarray, label: str, colours: str
) -> None:
    for drive in drives:
        axis.plot(drive.x, drive.y, color=SOFT, lw=0.8)
    boxes = PatchCollection([Rectangle((c.column * size, c.row * size), size, size) for c in cells], cmap=colours)
    boxes.set_array(values)
    axis.add_collection(boxes)
    axis.set(xlabel="x, m", ylabel="y, m", title=label, aspect="equal")
    axis.autoscale_view()
    bar = axis.inset_axes((1.02, 0.0, 0.02, 1.0))  # as high as the map, whatever its shape
    axis.figure.colorbar(boxes, cax=bar)
    bar.grid(False)
