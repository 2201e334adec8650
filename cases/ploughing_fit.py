"""Candidates for what a force law lacks on a steady single wheel, fitted on some slip angles and judged on others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from softsoil.cases.cmu_data import SteadyWheel
from softsoil.cases.ploughing import Digging, Ploughing
from softsoil.recording.rig import MOTION
from softsoil.symbolic.side_wall import WALL_FRICTION, Wall
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact, ForceLaw, Wheel

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SLOWEST = 0.02
"""Standstill over the median speed of the runs."""
PARAMETERS: Mapping[str, tuple[float, float, float, str, str]] = {
    "phi": (np.deg2rad(29.0), np.deg2rad(20.0), np.deg2rad(45.0), "rad", "angle of internal friction"),
    "k": (0.01, 0.001, 0.05, "m", "shear deformation modulus"),
    "width": (1.0, 0.5, 2.0, "", "effective width of the wheel over its width"),
    "unit_weight": (0.0, 0.0, 25e3, "N/m^3", "unit weight of the soil on the side wall"),
    "heap": (0.0, 0.0, 2.0, "", "height of the heap on the side wall over the sinkage"),
    "shear": (0.0, 0.0, 3.0, "", "sinkage per share of shearing rim motion"),
    "push": (0.0, 0.0, 6.0, "", "sinkage per pushed share of the way, to the power"),
    "power": (2.0, 1.0, 4.0, "", "power of the pushed share"),
}
"""Value, bounds, unit and meaning of every parameter; the values are the absent ones."""
STARTS = {"heap": 0.5, "shear": 0.5, "push": 2.0, "unit_weight": 13e3}


@dataclass(frozen=True)
class Hypothesis:
    """A physical effect that a force law may lack on a single wheel, with the parameters that are fitted for it.

    name; doc; fixed: parameters with the values that the laboratory or the literature give; to_sinkage, to_force: parameters
    fitted to the measured sinkage, then to the measured side force. Nothing else is adapted.
    """

    name: str
    doc: str
    fixed: Mapping[str, float]
    to_sinkage: tuple[str, ...] = ()
    to_force: tuple[str, ...] = ()


class Ploughs:
    """Side force, sinkage and longitudinal force of a wheel on its steady runs, for any parameters.

    wheel: the runs; soil: parameters by name (n, k_phi, c of the laboratory); base: the law below the wheel.
    """

    def __init__(self, wheel: SteadyWheel, soil: Mapping[str, float], base: ForceLaw) -> None:
        self.wheel, self.soil, self.base = wheel, dict(soil), base

    @cached_property
    def function(self) -> ca.Function:
        """[motion (7), parameters] -> [f_y, sinkage, f_x]."""
        run = self.wheel.run
        motion, theta = ca.SX.sym("motion", len(MOTION)), ca.SX.sym("theta", len(PARAMETERS))
        given = {name: theta[i] for i, name in enumerate(PARAMETERS)}
        still = SLOWEST * float(np.median(np.hypot(run.v_x, run.v_y)))
        wall = Wall(given["unit_weight"], given["heap"], WALL_FRICTION, still)
        law = Ploughing(self.base, wall, Digging(given["shear"], given["push"], given["power"], still))
        soil = Soil("sand", **{**self.soil, "phi": given["phi"], "k": given["k"]})
        body = Wheel(run.radius, run.width * given["width"])
        force = law(soil, body, Contact(**{key: motion[i] for i, key in enumerate(MOTION)}))
        return ca.Function("plough", [motion, theta], [ca.vertcat(force.f_y, force.sinkage, force.f_x)])

    def __call__(self, values: Mapping[str, float]) -> Array:
        """(3, N) side force (N), sinkage (m), longitudinal force (N); parameters not given are absent."""
        theta = [float(values.get(name, default[0])) for name, default in PARAMETERS.items()]
        return np.array(self.function(self.wheel.run.motion(), np.array(theta)[:, None]))


def fit_candidate(model: Ploughs, candidate: Hypothesis, rows: Mask) -> dict[str, float]:
    """All parameters of a candidate, fitted on the rows chosen: first those of the sinkage, then those of the force."""
    run, values = model.wheel.run, dict(candidate.fixed)
    if candidate.to_sinkage:
        if run.sinkage is None:
            raise ValueError(
                f"{run.name}: expected measured sinkages to fit {', '.join(candidate.to_sinkage)}, found none"
            )
        values = _fit(model, values, candidate.to_sinkage, 1, run.sinkage, rows)
    return _fit(model, values, candidate.to_force, 0, run.f_y, rows)


def _fit(
    model: Ploughs, values: Mapping[str, float], names: Sequence[str], channel: int, measured: Array, rows: Mask
) -> dict[str, float]:
    if not names:
        return dict(values)
    start = np.array([STARTS.get(name, PARAMETERS[name][0]) for name in names])
    bounds = np.array([PARAMETERS[name][1:3] for name in names]).T
    size = float(np.abs(measured).max())

    def residual(theta: Array) -> Array:
        return (model({**values, **dict(zip(names, theta, strict=True))})[channel] - measured)[rows] / size

    found = least_squares(residual, start, bounds=bounds, x_scale=np.abs(start))
    return {**values, **{name: float(v) for name, v in zip(names, found.x, strict=True)}}


@dataclass(frozen=True)
class Judged:
    """A candidate on one wheel.

    candidate; values: fitted on all rows; std: jackknife over the groups of `held`; fitted: side force with `values` (N,);
    held: by what was left out ("angle", "trial") -> side force (N,) of each row predicted from the other groups;
    held_sinkage (N,): likewise, by angle.
    """

    candidate: Hypothesis
    values: Mapping[str, float]
    std: Mapping[str, float]
    fitted: Array
    held: Mapping[str, Array]
    held_sinkage: Array


def judge_candidate(model: Ploughs, candidate: Hypothesis) -> Judged:
    """Fit on all rows, and on all but one slip angle (and all but one repeat) for the rows of that angle (repeat)."""
    wheel = model.wheel
    free = (*candidate.to_sinkage, *candidate.to_force)
    values = fit_candidate(model, candidate, np.ones(len(wheel), dtype=bool))
    held, folds, sinkage = {}, [], np.zeros(len(wheel))
    for key, labels in (("angle", wheel.angle), ("trial", wheel.trial)):
        predicted = np.zeros(len(wheel))
        for label in np.unique(labels):
            out = labels == label
            found = fit_candidate(model, candidate, ~out) if free else values
            force = model(found)
            predicted[out] = force[0, out]
            if key == "angle":
                folds.append([found[name] for name in free])
                sinkage[out] = force[1, out]
        held[key] = predicted
    spread = np.array(folds)
    count = len(spread)
    std = np.sqrt((count - 1) / count * ((spread - spread.mean(axis=0)) ** 2).sum(axis=0)) if free else np.zeros(0)
    return Judged(candidate, values, dict(zip(free, map(float, std), strict=True)), model(values)[0], held, sinkage)


def at_bound(name: str, value: float) -> bool:
    """Whether the `value` of the parameter `name` is on a bound: no credible size of this effect explains the runs."""
    _, lower, upper, *_ = PARAMETERS[name]
    near = 1e-3 * (upper - lower)
    return value < lower + near or value > upper - near


def rms(values: Array) -> float:
    """Root of the mean square of values (N,)."""
    return float(np.sqrt(np.mean(np.asarray(values) ** 2)))


def held_mean(wheel: SteadyWheel) -> Array:
    """(N,) side force of each row from the same condition's other repeats: what no law can beat."""
    out = np.zeros(len(wheel))
    for i in range(len(wheel)):
        same = (wheel.angle == wheel.angle[i]) & (wheel.rim_speed == wheel.rim_speed[i])
        same[i] = False
        out[i] = wheel.run.f_y[same].mean() if same.any() else np.nan
    return out
