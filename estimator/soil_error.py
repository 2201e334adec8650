"""What n owes to the other parameters of the soil's class: an error of any of them moves it, and a drive hardly shows that.

n and these parameters change the same forces: a friction angle a tenth larger can move n by a fifth while the model leaves hardly
more than before. n is therefore that of the class as declared. What a parameter is worth follows from the windows of an estimate:
with H the sum of their quadratics, the n that balances a change of a parameter is dn = -H_nn^-1 H_nk dk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.moving_horizon import MovingHorizon
from softsoil.estimator.summary import LEAST_CURVATURE
from softsoil.symbolic.soil import CLASS_NUMBERS
from softsoil.windows.free_windows import FreeWindows
from softsoil.windows.parameters import Free
from softsoil.windows.window_fit import reduce_windows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SoilError:
    """What the soil's other parameters make of the n of a drive.

    tenth: parameter -> change of n at the front axle, as a share, where it is a tenth larger than declared; std: standard
    deviation of n, as a share, by the errors that the soil's file states of its parameters; 0 where it states none.
    """

    tenth: dict[str, float]
    std: float


def soil_error(windows: FreeWindows, horizon: MovingHorizon) -> SoilError:
    """How far errors of the class move n; windows: of the drive; horizon: run to its end."""
    layout, count = windows.compiled.model.p, len(horizon.free)
    values = {name: float(layout[name].nominal) for name in CLASS_NUMBERS if layout[name].nominal > 0.0}
    others = tuple(Free(name, (name,), 0.1 * value, 0.0, np.inf) for name, value in values.items())
    last = len(windows.rows) - 1
    which = np.arange(horizon.since, last + 1)
    x0 = np.array(horizon.summary.states)[which]
    linear = windows.linearise(horizon.parameters(horizon.n), x0, (*horizon.free, *others), which)
    hessian = np.einsum("w,wkl->kl", horizon.weight(last)[which], np.nan_to_num(reduce_windows(linear).hessian))
    curvature = hessian[:count, :count] + LEAST_CURVATURE * np.eye(count)
    moved = -np.linalg.solve(curvature, hessian[:count, count:])[0] / max(float(horizon.n[0]), 1e-9)
    by_tenth = {name: float(0.1 * values[name] * one) for name, one in zip(values, moved, strict=True)}
    stated = [layout[name].spread * one for name, one in zip(values, moved, strict=True) if np.isfinite(layout[name].spread)]
    return SoilError(by_tenth, float(np.linalg.norm(stated)) if stated else 0.0)
