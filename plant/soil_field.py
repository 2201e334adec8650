"""Soil that varies in space: parameter sets on a regular map, the same for all wheels or one each for left and right."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.kernel import kernel
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil

K_PHI, K_C, N, C, TAN_PHI, K_SHEAR, K_ELASTIC, DAMPING = range(8)
"""Order of a parameter set in the kernel; friction as tan(phi)."""


def soil_vector(soil: Soil) -> NDArray[np.float64]:
    """(8,) parameters of a soil in the kernel's order."""
    values = np.array([float(soil.parameters()[name]) for name in SOIL_SIGNALS.names])
    values[TAN_PHI] = np.tan(values[TAN_PHI])
    return values


@dataclass(frozen=True)
class SoilField:
    """Soil parameters over the ground.

    values: (S, I, J, 8) parameter sets, S = 1 for all wheels, or S = 2 for left and right wheels separately;
    origin: (x, y) of the map's first cell centre (m); spacing: of the cells (m); blend: bilinear between cell centres,
    or the nearest cell (a sharp border half-way between two centres); name: of the soil. Outside the map the nearest cell counts.
    Raises ValueError for another shape or spacing <= 0.
    """

    values: NDArray[np.float64]
    origin: tuple[float, float] = (0.0, 0.0)
    spacing: float = 1.0
    blend: bool = True
    name: str = "field"

    def __post_init__(self) -> None:
        shape = self.values.shape
        if len(shape) != 4 or shape[0] not in (1, 2) or shape[3] != 8 or 0 in shape:
            raise ValueError(f"soil field: expected values of shape (1 or 2, I, J, 8), found {shape}")
        if not self.spacing > 0:
            raise ValueError(f"soil field: expected a spacing > 0 m, found {self.spacing}")

    @property
    def meta(self) -> NDArray[np.float64]:
        """(4,) origin x, y, spacing and blend for the kernel."""
        return np.array([self.origin[0], self.origin[1], self.spacing, float(self.blend)])

    @classmethod
    def uniform(cls, soil: Soil) -> SoilField:
        """The same soil everywhere."""
        return cls(soil_vector(soil).reshape(1, 1, 1, 8), name=soil.name)

    @classmethod
    def left_right(cls, left: Soil, right: Soil) -> SoilField:
        """One soil under the left wheels, another under the right ones (a track beside a shoulder)."""
        return cls(np.stack([soil_vector(left), soil_vector(right)]).reshape(2, 1, 1, 8))

    @classmethod
    def change_at(cls, before: Soil, after: Soil, x: float) -> SoilField:
        """A sharp border across the way at world x (m)."""
        values = np.stack([soil_vector(before), soil_vector(after)]).reshape(1, 2, 1, 8)
        return cls(values, origin=(x - 0.5, 0.0), spacing=1.0, blend=False)

    @classmethod
    def along_x(cls, soil: Callable[[float], Soil], start: float, stop: float, spacing: float = 1.0) -> SoilField:
        """A soil that changes smoothly along world x between start and stop (m): soil(x) is asked once per cell."""
        centres = np.arange(start, stop + spacing, spacing)
        return cls(np.stack([soil_vector(soil(float(x))) for x in centres])[None, :, None, :], (start, 0.0), spacing)

    @classmethod
    def over(cls, soil: Callable[[float, float], Soil], x: Sequence[float], y: Sequence[float]) -> SoilField:
        """A soil over a map: soil(x, y) is asked once per cell centre; x and y (m) are equally spaced alike."""
        spacing = float(x[1] - x[0])
        values = np.array([[soil_vector(soil(float(a), float(b))) for b in y] for a in x])
        return cls(values[None], (float(x[0]), float(y[0])), spacing)


@kernel
def soil_at(values, side, meta, x, y, out):
    """Write the eight parameters at (x, y) for wheels of a side into `out`."""
    side = min(side, values.shape[0] - 1)
    rows, columns = values.shape[1], values.shape[2]
    a = min(max((x - meta[0]) / meta[2], 0.0), rows - 1.0)
    b = min(max((y - meta[1]) / meta[2], 0.0), columns - 1.0)
    if meta[3] == 0.0:
        i, j = int(np.floor(a + 0.5)), int(np.floor(b + 0.5))
        for m in range(8):
            out[m] = values[side, i, j, m]
        return
    i, j = min(int(a), max(rows - 2, 0)), min(int(b), max(columns - 2, 0))
    i1, j1 = min(i + 1, rows - 1), min(j + 1, columns - 1)
    fa, fb = a - i, b - j
    for m in range(8):
        out[m] = (1.0 - fa) * ((1.0 - fb) * values[side, i, j, m] + fb * values[side, i, j1, m]) + fa * (
            (1.0 - fb) * values[side, i1, j, m] + fb * values[side, i1, j1, m]
        )
