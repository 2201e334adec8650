"""Factors of the turn-slip law from single-wheel runs: prediction-error least squares with CasADi derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from softsoil.calibration.single_wheel import WORTH_COMPILING, check_lateral, lateral_scale, law_for, soil_column
from softsoil.codegen.compiled import compile_function
from softsoil.recording.rig import MOTION, SOIL_KEYS, WheelRun
from softsoil.symbolic.laws.turn_slip import Factors, TurnSlip
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil
from softsoil.symbolic.wheel import Contact, Wheel
from softsoil.windows.sandwich import cluster_covariance

Array = NDArray[np.float64]

FACTORS = tuple(f.name for f in fields(Factors))
"""Factors of the law that can be fitted: width, path, turn, entry_time."""
SCALE = {"entry_time": 1e-3}
"""Size of one step of a parameter, 1 for a factor; soil parameters are fitted as multiples of what was given."""
LIMITS = {"width": (0.3, 2.0), "path": (0.2, 5.0), "turn": (0.2, 5.0), "entry_time": (-0.005, 0.02)}
"""A parameter that ends here is not identified; so does a soil multiple at SOIL_LIMITS."""
SOIL_LIMITS = (0.2, 5.0)
LEAST_SENSITIVITY = 1e-5
"""rms change of force over peak per step of a parameter, below which the runs say nothing about it."""


@dataclass(frozen=True)
class Calibrated:
    """Result of a fit.

    values, std: by parameter (factors as such, soil parameters as multiples of those given), standard errors robust to
    correlation within a run, NaN where there is one run in time alone; not_identified: parameters that the runs cannot fix,
    left as they were; runs: how many; rms: of the force error over peak, after the fit; evaluations: of the model on all runs.
    """

    values: Mapping[str, float]
    std: Mapping[str, float]
    not_identified: tuple[str, ...]
    runs: int
    rms: float
    evaluations: int

    @property
    def factors(self) -> Factors:
        """The fitted factors, neutral where they were not fitted."""
        return Factors(**{name: value for name, value in self.values.items() if name in FACTORS})


def calibrate(
    runs: Sequence[WheelRun],
    names: Sequence[str] = FACTORS,
    thin: int = 5,
    iterations: int = 30,
    progress: Callable[[str], None] = lambda text: None,
) -> Calibrated:
    """Fit parameters common to all `runs` by least squares on the smoothed lateral force over its peak.

    names: of FACTORS or soil parameters; thin: every how many samples count (smoothing makes neighbours alike);
    iterations: most evaluations; progress: called with one line per evaluation. Raises ValueError for an unknown name, no runs,
    or none with a lateral force.
    """
    if not runs:
        raise ValueError("calibrate: expected single-wheel runs, found none")
    for name in names:
        if name not in FACTORS and name not in SOIL_KEYS:
            raise ValueError(f"calibrate: expected names of {', '.join((*FACTORS, *SOIL_KEYS))}; found {name!r}")
    check_lateral(runs)
    names = tuple(dict.fromkeys(names))
    functions = _functions(runs, names)
    scale = np.array([SCALE.get(name, 1.0) for name in names])
    start = np.array([neutral(name) for name in names])
    first = np.concatenate([_residual(functions, run, start, thin)[1] for run in runs])
    free = np.sqrt(np.mean((first * scale) ** 2, axis=0)) > LEAST_SENSITIVITY
    low, high = _limits(names, runs)
    while True:
        problem = _Problem(runs, functions, start, free, thin, progress)
        if not free.any():
            break
        found = least_squares(
            problem.residual, start[free], jac=problem.jacobian, bounds=(low[free], high[free]), x_scale=scale[free],
            max_nfev=iterations, xtol=1e-5,
        )  # fmt: skip
        problem.residual(found.x)
        reach = 1e-3 * (high - low)
        stuck = free & ((problem.theta < low + reach) | (problem.theta > high - reach))
        if not stuck.any():
            break
        free &= ~stuck  # at a bound: held neutral, and the others fitted without it
    theta, blocks = problem.theta, problem.blocks
    std = _robust_std(_clusters(runs, blocks), free)
    kept = [i for i in range(len(names)) if free[i]]
    return Calibrated(
        {names[i]: float(theta[i]) for i in kept},
        {names[i]: float(std[i]) for i in kept},
        tuple(name for i, name in enumerate(names) if i not in kept),
        len(runs),
        float(np.sqrt(np.mean(np.concatenate([r for r, _ in blocks]) ** 2))),
        problem.calls,
    )


class _Problem:
    """Residual and derivative for least squares over the free parameters, each point evaluated once."""

    def __init__(
        self,
        runs: Sequence[WheelRun],
        functions: Mapping[tuple[float, float], ca.Function],
        start: Array,
        free: NDArray[np.bool_],
        thin: int,
        progress: Callable[[str], None],
    ) -> None:
        self.runs, self.functions, self.free, self.thin, self.progress = runs, functions, free, thin, progress
        self.theta, self.calls = start.copy(), 0
        self.blocks = [_residual(functions, run, start, thin) for run in runs]

    def _at(self, values: Array) -> None:
        if self.calls and np.array_equal(values, self.theta[self.free]):
            return
        self.theta[self.free] = values
        self.blocks = [_residual(self.functions, run, self.theta, self.thin) for run in self.runs]
        self.calls += 1
        rms = np.sqrt(np.mean(np.concatenate([r for r, _ in self.blocks]) ** 2))
        self.progress(f"evaluation {self.calls}: rms {100 * rms:.3f} % of peak")

    def residual(self, values: Array) -> Array:
        """Predicted less measured, over peak."""
        self._at(values)
        return -np.concatenate([r for r, _ in self.blocks])

    def jacobian(self, values: Array) -> Array:
        """Its derivative."""
        self._at(values)
        return np.concatenate([j for _, j in self.blocks])[:, self.free]


def neutral(name: str) -> float:
    """Value of a parameter that changes nothing."""
    return 0.0 if name == "entry_time" else 1.0


def with_soil(runs: Sequence[WheelRun], found: Calibrated) -> list[WheelRun]:
    """The runs with their soil parameters multiplied by the fitted factors, held inside their physical bounds."""
    return [
        replace(run, soil={key: _inside(key, value * found.values.get(key, 1.0)) for key, value in run.soil.items()})
        for run in runs
    ]


def _inside(key: str, value: float) -> float:
    return float(np.clip(value, SOIL_SIGNALS[key].lower, SOIL_SIGNALS[key].upper))


def _limits(names: Sequence[str], runs: Sequence[WheelRun]) -> tuple[Array, Array]:
    """Least and greatest value per parameter; multiples of soil parameters stay inside the physical bounds."""
    low, high = [], []
    for name in names:
        least, most = LIMITS.get(name, SOIL_LIMITS)
        if name in SOIL_KEYS:
            given = [run.soil[name] for run in runs if run.soil[name] > 0]
            least = max([least, *(SOIL_SIGNALS[name].lower / value for value in given)])
            most = min([most, *(SOIL_SIGNALS[name].upper / value for value in given)])
        low.append(least)
        high.append(most)
    return np.array(low), np.array(high)


def _functions(runs: Sequence[WheelRun], names: Sequence[str]) -> dict[tuple[float, float], ca.Function]:
    """Per wheel: [motion, soil, yaw, theta] -> [F, dF/dtheta], the force in the frame of judgement."""
    law = law_for("turn_slip", runs)
    if not isinstance(law, TurnSlip):
        raise TypeError(f"expected a TurnSlip, found {law!r}")
    functions = {}
    for radius, width in {(run.radius, run.width) for run in runs}:
        motion, soil = ca.SX.sym("motion", len(MOTION)), ca.SX.sym("soil", len(SOIL_KEYS))
        yaw, theta = ca.SX.sym("yaw"), ca.SX.sym("theta", len(names))
        given = dict(zip(names, [theta[i] for i in range(len(names))], strict=True))
        values = [soil[i] * given.get(key, 1.0) for i, key in enumerate(SOIL_KEYS)]
        factors = Factors(**{name: value for name, value in given.items() if name in FACTORS})
        contact = Contact(**{key: motion[i] for i, key in enumerate(MOTION)})
        force = replace(law, factors=factors)(Soil("", *values), Wheel(radius, width), contact)
        lateral = force.f_x * ca.sin(yaw) + force.f_y * ca.cos(yaw)
        out = ca.densify(ca.horzcat(lateral, ca.jacobian(lateral, theta)))
        function = ca.Function("lateral", [motion, soil, yaw, theta], [out])
        functions[(radius, width)] = compile_function(function) if len(runs) >= WORTH_COMPILING else function
    return functions


def _residual(
    functions: Mapping[tuple[float, float], ca.Function], run: WheelRun, theta: Array, thin: int
) -> tuple[Array, Array]:
    """Residual (m,) and its negative derivative (m, p) of one run, both over the peak force and smoothed."""
    out = np.array(functions[(run.radius, run.width)](run.motion(), soil_column(run), run.yaw[None], theta))
    out = out.reshape(len(run), 1 + len(theta))
    measured = run.smooth(run.lateral(run.f_x, run.f_y))
    peak = lateral_scale(run)
    smooth = np.column_stack([run.smooth(out[:, i]) for i in range(out.shape[1])])
    step = thin if run.dt is not None else 1
    return ((measured - smooth[:, 0]) / peak)[::step], (smooth[:, 1:] / peak)[::step]


def _clusters(runs: Sequence[WheelRun], blocks: list[tuple[Array, Array]]) -> list[tuple[Array, Array]]:
    """What is independent of each other: runs, or the rows of one steady table. One run in time shows nothing of what differs
    from run to run: none."""
    if len(runs) > 1:
        return blocks
    residual, slope = blocks[0]
    return [(residual[i : i + 1], slope[i : i + 1]) for i in range(len(residual))] if runs[0].dt is None else []


def _robust_std(blocks: Sequence[tuple[Array, Array]], free: NDArray[np.bool_]) -> Array:
    """Standard errors from the sandwich estimator; NaN without clusters, and for parameters that are not free."""
    std = np.full(len(free), np.nan)
    if not blocks:
        return std
    hessian = np.sum([j[:, free].T @ j[:, free] for _, j in blocks], axis=0)
    scores = [j[:, free].T @ r for r, j in blocks]
    std[free] = np.sqrt(np.diag(cluster_covariance(hessian, scores, rcond=1e-15)))
    return std
