"""Area and perimeter of a footprint: the convex hull of the grid nodes that a wheel covers."""

from __future__ import annotations

import numpy as np

from softsoil.plant.kernel import kernel


@kernel
def hull_area_perimeter(low, high, spacing):
    """Area (m^2) and perimeter (m) of the convex hull of nodes given column by column.

    low, high: (I,) least and greatest row index in each column, low > high in an empty column; spacing: m.
    Andrew's monotone chain on the columns' ends, which are sorted already: O(I).
    """
    n = low.shape[0]
    xs = np.empty(2 * n)
    ys = np.empty(2 * n)
    size = 0
    for upper in range(2):
        start = size
        for step in range(n):
            i = step if upper == 0 else n - 1 - step
            if low[i] > high[i]:
                continue
            x = float(i)
            y = float(low[i]) if upper == 0 else float(high[i])
            while size - start >= 2 and (
                (xs[size - 1] - xs[size - 2]) * (y - ys[size - 2]) - (ys[size - 1] - ys[size - 2]) * (x - xs[size - 2])
                <= 0.0
            ):
                size -= 1
            xs[size] = x
            ys[size] = y
            size += 1
    area = 0.0
    perimeter = 0.0
    for k in range(size):
        m = k + 1 if k + 1 < size else 0
        area += xs[k] * ys[m] - xs[m] * ys[k]
        perimeter += np.hypot(xs[m] - xs[k], ys[m] - ys[k])
    return 0.5 * area * spacing * spacing, perimeter * spacing
