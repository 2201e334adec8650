"""Figure of a soil map: n per cell along the ways of the drives, and how well it is known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Rectangle

from softsoil.figures.style import INITIAL, SOFT, page
from softsoil.mapping.cells import Cell
from softsoil.mapping.soil_map import SoilMap

APART = 25
"""Cells without any between two fields, which are drawn each for itself."""
MOST = 4
"""Fields that are drawn, those with most cells."""
DOUBTED = "inconsistent"
"""Verdict of cells where drives or soils disagree."""


def draw_soil_map(ground: SoilMap, path: Path) -> Path:
    """Two maps of each field, n and its standard deviation in per cent of n, side by side or, for one long way, below each other.

    Cells that are not identified are hatched, those that are inconsistent in red; colours are those of the others, the same in
    all fields.
    """
    found, drives = fields(ground.cells), ground.used
    shown = found[:MOST]
    title = f"Sinkage exponent along {len(drives)} drive{'s' if len(drives) > 1 else ''}, cells of {ground.size:g} m"
    if found[1:]:
        title += f", {len(found)} fields" + (f", {MOST} of them here" if found[MOST:] else "")
    shapes = [_shape(field) for field in shown]
    long = len(shown) == 1 and shapes[0] < 1.0 / 1.6
    heights = [float(np.clip((8.0 if long else 4.2) * shape + 1.1, 2.0, 6.0)) for shape in shapes]
    known = [c for c in ground.cells if c.verdict == "identified"]
    layers = (
        (f"sinkage exponent n{_marks(ground.cells)}", "viridis", {c: c.n for c in known}),
        ("standard deviation, % of n", "magma_r", {c: 100 * c.std / c.n for c in known}),
    )
    layout, heights = ((2, 1), 2 * heights) if long else ((len(shown), 2), heights)
    with page(path, title, 9 if long else 11, sum(heights), *layout, squeeze=False, height_ratios=heights) as axes:
        for i, field in enumerate(shown):
            for k, (label, colours, values) in enumerate(layers):
                _cells(axes.ravel()[2 * i + k], ground, field, values, label, colours)
    return path


def fields(cells: Sequence[Cell]) -> list[list[Cell]]:
    """The cells in groups with at least `APART` cells without any between them, the largest first; one empty group for none."""
    blocks: dict[tuple[int, int], list[Cell]] = {}
    for cell in cells:
        blocks.setdefault((cell.column // APART, cell.row // APART), []).append(cell)
    groups = []
    while blocks:
        todo, group = [next(iter(blocks))], []
        while todo:
            at = todo.pop()
            group += blocks.pop(at, [])
            near = [(at[0] + i, at[1] + k) for i in (-1, 0, 1) for k in (-1, 0, 1)]
            todo += [other for other in near if other in blocks]
        groups.append(group)
    return sorted(groups, key=len, reverse=True) or [[]]


def _shape(field: Sequence[Cell]) -> float:
    """Height over width of what the cells cover."""
    high, wide = (1 + np.ptp([getattr(cell, way) for cell in field] or [0]) for way in ("row", "column"))
    return float(high / wide)


def _marks(cells: Sequence[Cell]) -> str:
    """What the cells without a colour are."""
    words = {cell.verdict for cell in cells}
    said = ["hatched: not identified"] if words - {"identified", DOUBTED} else []
    said += [f"red: {DOUBTED}"] if DOUBTED in words else []
    return f" ({', '.join(said)})" if said else ""


def _cells(axis: Any, ground: SoilMap, field: list[Cell], values: dict[Cell, float], label: str, colours: str) -> None:
    for drive in ground.used:
        axis.plot(*drive.way.T, color=SOFT, lw=0.8)
    for doubted, color in ((False, SOFT), (True, INITIAL)):
        others = [_box(c, ground.size) for c in field if c not in values and (c.verdict == DOUBTED) == doubted]
        axis.add_collection(PatchCollection(others, facecolor="none", edgecolor=color, hatch="//", lw=0.8))
    mine = [c for c in field if c in values]
    boxes = PatchCollection([_box(c, ground.size) for c in mine], cmap=colours)
    boxes.set_array(np.array([values[c] for c in mine]))
    if values:
        boxes.set_clim(min(values.values()), max(values.values()))
    axis.add_collection(boxes)
    axis.set(xlabel="x, m", ylabel="y, m", title=label, aspect="equal")
    _limits(axis, field, ground.size)
    if not mine:
        return
    bar = axis.inset_axes((1.02, 0.0, 0.02, 1.0))  # as high as the map, whatever its shape
    axis.figure.colorbar(boxes, cax=bar)
    bar.grid(False)


def _limits(axis: Any, field: list[Cell], size: float) -> None:
    """The field and a little room around it; without cells the ways alone."""
    if not field:
        axis.autoscale_view()
        return
    places = np.array([(cell.column, cell.row) for cell in field]) * size
    low, high = places.min(axis=0), places.max(axis=0) + size
    room = max(0.04 * float((high - low).max()), size)
    axis.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))


def _box(cell: Cell, size: float) -> Rectangle:
    return Rectangle((cell.column * size, cell.row * size), size, size)
