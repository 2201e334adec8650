"""A steering map from a log that holds both what was commanded and what the road wheels did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.files.steering_map import SteeringMap

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SteeringRules:
    """degrees: of the polynomials tried; better: share by which the held-out cost has to fall for a higher one; stretches: of
    the log, held out in turn; latest: longest delay tried (s); knots: of the map; least: samples; range: smallest angle covered
    (rad); tight: largest residual over the angles' standard deviation for a map."""

    degrees: tuple[int, ...] = (1, 2, 3, 5)
    better: float = 0.02
    stretches: int = 6
    latest: float = 0.6
    knots: int = 21
    least: int = 100
    range: float = 0.05
    tight: float = 0.2


RULES = SteeringRules()


@dataclass(frozen=True)
class SteeringFit:
    """map; degree: of the polynomial behind it; std: largest standard error of its angles (rad), by stretches of the log left
    out; residual: root mean square of what is left (rad); delay: by which the wheels follow the command (s)."""

    map: SteeringMap
    degree: int
    std: float
    residual: float
    delay: float


def fit_steering_map(t: Array, command: Array, angle: Array, rules: SteeringRules = RULES) -> SteeringFit:
    """The map of a log, angle = a_0 + a_1 c + ... of the degree that predicts stretches held out best.

    t (N,): time (s); command (N,): as recorded; angle (N,): mean road-wheel angle (rad), NaN where there is none; rules: limits.
    Raises ValueError where the log steers too little, or its angles do not follow the command.
    """
    t, command, angle = (np.asarray(values, dtype=float) for values in (t, command, angle))
    good = np.isfinite(command) & np.isfinite(angle) & np.isfinite(t)
    t, command, angle = t[good], command[good], angle[good]
    swing = float(np.ptp(angle)) if len(angle) else 0.0
    if len(t) < rules.least or swing < rules.range or np.ptp(command) <= 0.0:
        raise ValueError(
            f"steering map: expected {rules.least} samples of command and angle or more that steer over {rules.range:g} rad, "
            f"found {len(t)} over {swing:.3g} rad"
        )
    middle, half = 0.5 * (command.max() + command.min()), 0.5 * float(np.ptp(command))
    delay = _delay(t, (command - middle) / half, angle, rules)
    scaled = (np.interp(t - delay, t, command) - middle) / half
    stretch = np.minimum((np.arange(len(t)) * rules.stretches) // len(t), rules.stretches - 1)
    best, cost = rules.degrees[0], np.inf
    for degree in rules.degrees:
        held = _held_out(scaled, angle, stretch, degree)[0]
        if held < (1.0 - rules.better) * cost:
            best, cost = degree, held
    residual = float(np.sqrt(np.mean((np.polyval(np.polyfit(scaled, angle, best), scaled) - angle) ** 2)))
    if residual > rules.tight * float(np.std(angle)):
        raise ValueError(
            f"steering map: expected angles that follow the command, found {residual:.3g} rad of "
            f"{float(np.std(angle)):.3g} rad unexplained"
        )
    knots = np.linspace(-1.0, 1.0, rules.knots if best > 1 else 2)
    curve = np.polyval(np.polyfit(scaled, angle, best), knots)
    found = SteeringMap(tuple(map(float, middle + half * knots)), tuple(map(float, curve)))
    curves = np.array([np.polyval(c, knots) for c in _held_out(scaled, angle, stretch, best)[1]])
    count = len(curves)
    std = np.sqrt((count - 1) / count * ((curves - curves.mean(axis=0)) ** 2).sum(axis=0))
    return SteeringFit(found, best, float(std.max()), residual, delay)


def _held_out(scaled: Array, angle: Array, stretch: NDArray[np.int_], degree: int) -> tuple[float, list[Array]]:
    """Mean squared error on stretches held out in turn, and the polynomials without each."""
    total, curves = 0.0, []
    for one in np.unique(stretch):
        out = stretch == one
        curves.append(np.polyfit(scaled[~out], angle[~out], degree))
        # Beyond the commands of the fit a polynomial says nothing: the stretch's own rows inside them judge.
        inside = out & (scaled >= scaled[~out].min()) & (scaled <= scaled[~out].max())
        total += float(((np.polyval(curves[-1], scaled[inside]) - angle[inside]) ** 2).sum())
    return total / len(angle), curves


def _delay(t: Array, scaled: Array, angle: Array, rules: SteeringRules) -> float:
    """Delay (s) at which a cubic of the delayed command leaves least, to a fifth of a sample."""
    step = float(np.median(np.diff(t)))

    def left(delay: float) -> float:
        late = np.interp(t - delay, t, scaled)
        return float(((np.polyval(np.polyfit(late, angle, 3), late) - angle) ** 2).sum())

    coarse = min(np.arange(0.0, rules.latest, step), key=left)
    return float(max(min(coarse + step * np.linspace(-1.0, 1.0, 11), key=left), 0.0))
