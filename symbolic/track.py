"""A fixed number of past samples behind a moving point, as branch-free CasADi expressions.

Cells run from the newest to the oldest. The first cell is always the present sample. A step pushes the others back only
when the second has come `spacing` away from what was the first, so that a given number of cells reaches equally far at every
time step and speed.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import casadi as ca

from softsoil.symbolic.signals import Layout, Signal

Scalar = Any
Cell = dict[str, Scalar]


def track_layout(prefix: str, count: int, values: Sequence[Signal]) -> Layout:
    """Layout of `count` cells, each with the given values: names <prefix>_<value>_<cell>."""
    cells = ((k, value) for k in range(count) for value in values)
    return Layout(tuple(Signal(f"{prefix}_{value.name}_{k}", value.unit, f"{value.doc}, cell {k}") for k, value in cells))


def read_cells(memory: Mapping[str, Scalar], prefix: str, count: int, values: Sequence[Signal]) -> list[Cell]:
    """The `count` cells out of a memory's quantities."""
    return [{value.name: memory[f"{prefix}_{value.name}_{k}"] for value in values} for k in range(count)]


def write_cells(cells: Sequence[Cell], prefix: str) -> Cell:
    """Cells as quantities by name."""
    return {f"{prefix}_{name}_{k}": value for k, cell in enumerate(cells) for name, value in cell.items()}


def push(cells: Sequence[Cell], new: Cell, coordinate: str, spacing: float) -> list[Cell]:
    """Cells after one step: `new` in front; the rest, already aged, moved back by one once the first two are `spacing` apart."""
    far = cells[1][coordinate] - cells[0][coordinate] >= spacing

    def older(before: Cell, cell: Cell) -> Cell:
        return {name: cell[name] + far * (before[name] - cell[name]) for name in new}

    return [dict(new), *(older(before, cell) for before, cell in pairwise(cells))]


def interpolate(cells: Sequence[Cell], coordinate: str, at: Scalar, name: str) -> Scalar:
    """Value `name` at the coordinate `at`, linear between cells, the oldest beyond the last."""
    value = cells[0][name]
    for newer, older in pairwise(cells):
        gap = older[coordinate] - newer[coordinate] + 1e-9  # two cells in one place: no division by zero
        share = ca.fmax(0.0, ca.fmin(1.0, (at - newer[coordinate]) / gap))
        value = value + share * (older[name] - newer[name])
    return value
