"""Figure of a soil map: n per cell along the ways of the drives, and how well it is known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Rectangle

from softsoil.figures.style import SOFT, page
from softsoil.mapping.cells import Cell
from softsoil.mapping.soil_map import SoilMap


def draw_soil_map(ground: SoilMap, path: Path) -> Path:
    """Two maps, n and its standard deviation in per cent of n, side by side or, for a long way, below each other.

    Cells that are not identified are outlined alone; colours are those of the others.
    """
    cells, drives = ground.cells, ground.used
    title = f"Sinkage exponent along {len(drives)} drive{'s' if len(drives) > 1 else ''}, cells of {ground.size:g} m"
    wide, high = 1 + np.ptp([cell.column for cell in cells]), 1 + np.ptp([cell.row for cell in cells])
    long = wide > 1.6 * high
    height = float(np.clip(8.0 * high / wide + 1.1, 2.0, 6.0)) if long else 5.2
    with page(path, title, 9 if long else 11, 2 * height if long else height, *((2, 1) if long else (1, 2))) as axes:
        known = [c for c in cells if c.verdict == "identified"]
        for axis, values, label, colours in (
            (axes[0], [c.n for c in known], "sinkage exponent n (outlined: not identified)", "viridis"),
            (axes[1], [100 * c.std / c.n for c in known], "standard deviation, % of n", "magma_r"),
        ):
            _cells(axis, ground, known, np.array(values), label, colours)
    return path


def _cells(axis: Any, ground: SoilMap, known: list[Cell], values: np.ndarray, label: str, colours: str) -> None:
    for drive in ground.used:
        axis.plot(*drive.way.T, color=SOFT, lw=0.8)
    others = [_box(c, ground.size) for c in ground.cells if c not in known]
    axis.add_collection(PatchCollection(others, facecolor="none", edgecolor=SOFT, hatch="//", lw=0.8))
    boxes = PatchCollection([_box(c, ground.size) for c in known], cmap=colours)
    boxes.set_array(values)
    axis.add_collection(boxes)
    axis.set(xlabel="x, m", ylabel="y, m", title=label, aspect="equal")
    axis.autoscale_view()
    if not known:
        return
    bar = axis.inset_axes((1.02, 0.0, 0.02, 1.0))  # as high as the map, whatever its shape
    axis.figure.colorbar(boxes, cax=bar)
    bar.grid(False)


def _box(cell: Cell, size: float) -> Rectangle:
    return Rectangle((cell.column * size, cell.row * size), size, size)
