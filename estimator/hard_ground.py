"""Whether a drive was on hard ground: the same vehicle with rubber on a road in place of the soil's law, compared by windows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from softsoil.symbolic.bicycle import forces
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS
from softsoil.symbolic.wheel import force_law
from softsoil.windows.free_windows import FreeWindows
from softsoil.windows.parameters import Free
from softsoil.windows.window_fit import fit_windows

ROAD = (Free("phi", ("phi",), 0.1, 0.05, 1.1), Free("k", ("k",), 1e-3, 2e-4, 0.05))
"""Friction angle (rad) and shear length of the tread (m)."""
STARTS = ((0.6, 0.0015), (0.35, 0.004))
ITERATIONS = 8


@dataclass(frozen=True)
class HardGround:
    """Hard ground against soil on the windows of one drive.

    friction: coefficient that hard ground would have; cost, soil_cost: mean robust squared residual of the windows, in standard
    deviations, with hard ground and with the soil's law, n fitted; better, better_std: by how much hard ground leaves less per
    window, and its standard error.
    """

    friction: float
    cost: float
    soil_cost: float
    better: float
    better_std: float


def on_hard_ground(model: Model) -> Model:
    """The bicycle `model` with its effects, the force law replaced by `hard_ground`, whose phi and k stay parameters."""
    law = force_law("hard_ground")
    stages = (replace(s, compute=lambda q: forces(q, law)) if s.name == "forces" else s for s in model.stages)
    return replace(model, name=f"{model.name}_on_hard_ground", stages=tuple(stages))


def compare_hard_ground(soil: FreeWindows, road: FreeWindows, n0: float) -> HardGround:
    """Fit one n (from n0) to the windows of a drive, `soil`, and friction and tread to the same windows on a `road`."""
    n = SOIL_SIGNALS["n"]
    free = (Free("n", ("n_f", "n_r"), 0.1, n.lower, n.upper),)
    soil.reset()
    given = fit_windows([soil], free, np.array([n0]), soil.compiled.model.p.nominal, iterations=ITERATIONS)
    p = road.compiled.model.p.nominal
    fits = [fit_windows([road], ROAD, np.array(start), p, iterations=ITERATIONS) for start in STARTS]
    best = min(fits, key=lambda fit: fit.cost)
    gain = given.costs - best.costs
    share = min(float(np.median(np.diff(soil.rows))) / soil.steps, 1.0)  # of a window that its neighbour does not cover
    error = float(gain.std() / np.sqrt(max(share * len(gain), 1.0)))
    friction = float(np.tan(best.value[0]))
    return HardGround(friction, float(best.costs.mean()), float(given.costs.mean()), float(gain.mean()), error)
