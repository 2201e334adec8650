"""The paper's curve-fitting procedure: correction factors run by run, then their dependence on n, s, F_z and v.

For each soil class, each of the four slip ranges and each branch: (1) g_1, g_2, g_3 are matched to every run alone by
least squares, on the samples where the wheel steers away from zero slip (lower) or towards it (upper); (2) the
function families of the paper's appendix are fitted to the factors: polynomials in n (5, 1, 2) and s (4), linear
in F_z, a power of v for g_2, as products, by least squares in turns. Few runs per range make the polynomials ill
posed; a small ridge holds what the data do not fix.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from softsoil.calibration.single_wheel import SLIP_RANGES, soil_column
from softsoil.codegen.compiled import compile_function
from softsoil.recording.rig import MOTION, SOIL_KEYS, WheelRun
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.dallas import Branch, Dallas, Factor, SlipRange
from softsoil.symbolic.laws.dallas_refit import N_RANGE, soil_class
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact, Wheel

Array = NDArray[np.float64]

PRIOR = 0.01
"""Weight, against the relative force error, that holds a factor which the run does not determine at its first guess."""
THIN = 4
"""Every how many samples of a run are matched."""
START = (0.0, 0.0, np.log(0.02))
"""First guess of log g_1, g_2/G2_SCALE and log g_3."""
G2_SCALE = 50.0
LOG_BOUNDS = (np.array([-2.5, -6.0, -7.0]), np.array([2.5, 12.0, -0.5]))
"""Bounds of log g_1, g_2/G2_SCALE, log g_3: beyond them a factor no longer acts on the force."""
RIDGE = 1e-3
SWEEPS = 30


@dataclass(frozen=True)
class Matched:
    """Correction factors of one run and branch, with what they may depend on: n, s, F_z (N), v (m/s)."""

    n: float
    s: float
    load: float
    speed: float
    g: tuple[float, float, float]


def refit(runs: Sequence[WheelRun], progress: Callable[[str], None] = lambda text: None) -> dict[str, list[SlipRange]]:
    """Correction factors by soil class; progress: called with one line per soil class. ValueError for too few runs."""
    tables: dict[str, list[SlipRange]] = {}
    for group in dict.fromkeys(soil_class(run.group) for run in runs):
        mine = [run for run in runs if soil_class(run.group) == group]
        side = side_force(mine[0])
        pieces = []
        for low, high in SLIP_RANGES:
            inside = [run for run in mine if low <= run.slip < high]
            if len(inside) < 8:
                raise ValueError(f"dallas_refit: {group}, {low} <= s < {high}: expected 8 runs, found {len(inside)}")
            lower = fit_branch([match_run(side, run, False) for run in inside])
            upper = fit_branch([match_run(side, run, True) for run in inside])
            pieces.append(SlipRange(low, high, lower, upper))
        tables[group] = pieces
        progress(f"{group}: correction factors from {len(mine)} runs")
    return tables


def side_force(run: WheelRun) -> ca.Function:
    """[motion (7), soil (6), yaw, g (3)] -> [F, dF/dg] of one branch with factors g: force to the left in the frame of judgement
    (N), as `WheelRun.lateral`, with the wheel frame at yaw (rad) against it.
    """
    motion, soil, yaw, g = ca.SX.sym("motion", 7), ca.SX.sym("soil", 6), ca.SX.sym("yaw"), ca.SX.sym("g", 3)
    factors = [Factor(n=(x,)) for x in (ca.exp(g[0]), G2_SCALE * g[1], ca.exp(g[2]))]
    branch = Branch(*factors)
    law = Dallas((SlipRange(-1.0, 1.0, branch, branch),), Bekker(), n_range=N_RANGE)
    contact = Contact(**{key: motion[i] for i, key in enumerate(MOTION)})
    given = law(Soil(run.group, *[soil[i] for i in range(len(SOIL_KEYS))]), Wheel(run.radius, run.width), contact)
    force = given.f_x * ca.sin(yaw) + given.f_y * ca.cos(yaw)
    return compile_function(
        ca.Function("side", [motion, soil, yaw, g], [ca.densify(ca.horzcat(force, ca.jacobian(force, g)))])
    )


def match_run(side: ca.Function, run: WheelRun, upper: bool) -> Matched:
    """g_1, g_2, g_3 of one branch of one run."""
    away = run.steer_rate * -run.v_y > 0
    chosen = np.flatnonzero(away != upper)[::THIN]
    motion, soil, yaw = run.motion()[:, chosen], soil_column(run), np.broadcast_to(run.yaw, (len(run),))[chosen]
    measured = run.smooth(run.lateral(run.f_x, run.f_y))[chosen]
    peak = max(float(np.abs(measured).max()), 1.0)

    def both(g: Array) -> Array:
        return np.array(side(motion, soil, yaw[None], g)).reshape(len(chosen), 4)

    hold = PRIOR * np.sqrt(len(chosen)) * np.eye(3)
    found = least_squares(
        lambda g: np.append((both(g)[:, 0] - measured) / peak, hold @ (g - START)),
        START,
        jac=lambda g: np.vstack([both(g)[:, 1:] / peak, hold]),
        bounds=LOG_BOUNDS,
        max_nfev=25,
    ).x
    speed = float(np.hypot(run.v_x, run.v_y).mean())
    factors = (float(np.exp(found[0])), float(G2_SCALE * found[1]), float(np.exp(found[2])))
    return Matched(run.soil["n"], run.slip, float(run.load.mean()), speed, factors)


def fit_branch(matched: Sequence[Matched]) -> Branch:
    """The function families of the appendix through the factors of many runs."""
    g_1 = _fit_product(matched, 0, orders=(5, 4, 0), power=False)
    g_2 = _fit_product(matched, 1, orders=(1, 4, 1), power=True)
    g_3 = _fit_product(matched, 2, orders=(2, 4, 1), power=False)
    return Branch(g_1, g_2, g_3)


def _fit_product(matched: Sequence[Matched], which: int, orders: tuple[int, int, int], power: bool) -> Factor:
    """Product of polynomials of given orders in n, s, F_z (and a power of v), by least squares in turns.

    Each polynomial is fitted with the others held, on centred and scaled arguments, with a ridge towards a constant;
    the first sets the size, the others have mean one.
    """
    target = np.array([m.g[which] for m in matched])
    arguments = [np.array([getattr(m, key) for m in matched]) for key in ("n", "s", "load")]
    speed = np.array([m.speed for m in matched])
    exponent = _power(target, speed) if power else 0.0
    of_v = (speed / 5.0) ** exponent
    scaled = [(a - a.mean()) / max(float(np.ptp(a)) / 2, 1e-9) for a in arguments]
    designs = [np.vander(a, order + 1, increasing=True) for a, order in zip(scaled, orders, strict=True)]
    weights = [np.eye(order + 1)[0] for order in orders]
    weights[0] = weights[0] * float(np.median(target / of_v))
    size = max(float(np.mean(np.abs(target))), 1e-9)
    for _ in range(SWEEPS):
        for k, design in enumerate(designs):
            others = of_v * np.prod(
                [d @ w for j, (d, w) in enumerate(zip(designs, weights, strict=True)) if j != k], axis=0
            )
            matrix = design * others[:, None]
            ridge = RIDGE * len(target) * np.diag([0.0] + [1.0] * orders[k]) * float(np.mean(others**2))
            weights[k] = np.linalg.solve(
                matrix.T @ matrix + ridge + 1e-12 * size**2 * np.eye(orders[k] + 1), matrix.T @ target
            )
            if k:
                mean = float(np.mean(design @ weights[k]))
                weights[k], weights[0] = weights[k] / mean, weights[0] * mean
    plain = [_unscaled(w, a) for w, a in zip(weights, arguments, strict=True)]
    return Factor(n=plain[0], s=plain[1], load=plain[2], speed=(5.0**-exponent, exponent))


def _power(target: Array, speed: Array) -> float:
    """Exponent of v that explains |g| best, between -2 and 1."""
    positive = np.abs(target) > 1e-3 * np.abs(target).max()
    slope = np.polyfit(np.log(speed[positive]), np.log(np.abs(target[positive])), 1)[0] if positive.sum() > 3 else 0.0
    return float(np.clip(slope, -2.0, 1.0))


def _unscaled(weights: Array, argument: Array) -> tuple[float, ...]:
    """Coefficients (highest power first) in the plain argument of a polynomial in the scaled one."""
    inner = np.poly1d([1.0, -float(argument.mean())]) / max(float(np.ptp(argument)) / 2, 1e-9)
    total = np.poly1d([0.0])
    for order, weight in enumerate(weights):
        total = total + float(weight) * inner**order
    return tuple(float(c) for c in total.coeffs)


def tables_to_toml(tables: Mapping[str, Sequence[SlipRange]], heading: str) -> str:
    """The tables as TOML text under a one-line comment."""
    lines = [f"# {heading}"]
    for name, pieces in tables.items():
        for piece in pieces:
            lines += ["", f"[[soil.{name}]]", f"low = {piece.low!r}", f"high = {piece.high!r}"]
            for branch in ("lower", "upper"):
                for g, factor in asdict(getattr(piece, branch)).items():
                    parts = [f"{k} = [{', '.join(f'{x:.6g}' for x in factor[k])}]" for k in ("n", "s", "load", "speed")]
                    parts.append(f"n_positive = {str(factor['n_positive']).lower()}")
                    lines.append(f"{branch}.{g} = {{ {', '.join(parts)} }}")
    return "\n".join(lines) + "\n"
