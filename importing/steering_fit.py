"""A steering map from a log that holds both what was commanded and what the road wheels did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.signal import lfilter

from softsoil.files.steering_map import SteeringMap

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SteeringRules:
    """degrees: of the polynomials tried; better: share by which the held-out cost has to fall for a higher one; stretches: of
    the log, held out in turn; latest: longest delay tried (s); lags: of the first order, tried (s); shown: share of what is left
    that one takes away at least; settle: at the beginning of the log, where the wheels follow commands of before it (s, a fifth
    of the log at most); most: rows that delay and lag are fitted to; knots: of the map; least: samples; range: smallest angle
    covered (rad); tight: largest residual over the angles' standard deviation for a map."""

    degrees: tuple[int, ...] = (1, 2, 3, 5)
    better: float = 0.02
    shown: float = 0.005
    stretches: int = 6
    latest: float = 0.6
    lags: tuple[float, ...] = (0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.25, 0.35, 0.5)
    settle: float = 1.5
    most: int = 6000
    knots: int = 21
    least: int = 100
    range: float = 0.05
    tight: float = 0.2


RULES = SteeringRules()
REFINED = 3
"""Times that lags are tried between the neighbours of the best one."""


ROUNDING = 1e-9
"""Share of the commands' half range within which two knots are one."""
FINE, NEAREST = 0.01, 0.003
"""s: longest step of the clock on which a command lags; resolution of a delay: a lag stands in for what is left of it."""


@dataclass(frozen=True)
class SteeringFit:
    """map; degree: of the polynomial behind it; std: largest standard error of its angles (rad), by stretches of the log left
    out and by what the polynomial misses; residual: root mean square of what is left (rad); delay: by which the wheels follow the
    command (s); lag: of the first order with which they do besides (s), 0 where the log shows none."""

    map: SteeringMap
    degree: int
    std: float
    residual: float
    delay: float
    lag: float = 0.0


def fit_steering_map(t: Array, command: Array, angle: Array, rules: SteeringRules = RULES) -> SteeringFit:
    """The map of a log, angle = a_0 + a_1 c + ... of the degree that predicts stretches held out best, c the command as it has
    passed a delay and a lag: an actuator that is slow does not reach the angle of a command that goes on.

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
    clock, asked = _on_fine_clock(t, (command - middle) / half)
    delay, lag = _followed(t, clock, asked, angle, rules)
    settled = _settled(t, rules)
    scaled = np.interp(t - delay, clock, _lagged(clock, asked, lag))[settled]
    t, angle = t[settled], angle[settled]
    stretch = np.minimum((np.arange(len(t)) * rules.stretches) // len(t), rules.stretches - 1)
    best, cost = rules.degrees[0], np.inf
    for degree in rules.degrees:
        held = _held_out(scaled, angle, stretch, degree)[0]
        if held < (1.0 - rules.better) * cost:
            best, cost = degree, held
    rest = angle - np.polyval(np.polyfit(scaled, angle, best), scaled)
    residual = float(np.sqrt(np.mean(rest**2)))
    if residual > rules.tight * float(np.std(angle)):
        raise ValueError(
            f"steering map: expected angles that follow the command, found {residual:.3g} rad of "
            f"{float(np.std(angle)):.3g} rad unexplained"
        )
    fitted = np.polyfit(scaled, angle, best)
    knots = _knots(fitted, scaled, rules)
    curve = _straight_on(fitted, knots, scaled)
    found = SteeringMap(tuple(map(float, middle + half * knots)), tuple(map(float, curve)))
    curves = np.array([_straight_on(c, knots, scaled) for c in _held_out(scaled, angle, stretch, best)[1]])
    count = len(curves)
    std = np.sqrt((count - 1) / count * ((curves - curves.mean(axis=0)) ** 2).sum(axis=0))
    return SteeringFit(found, best, float(np.hypot(std.max(), _missed(scaled, rest, rules))), residual, delay, lag)


def _knots(polynomial: Array, scaled: Array, rules: SteeringRules) -> Array:
    """Commands of a map, between the ends of what was commanded, -1 and 1, for a polynomial fitted to scaled (N,): as far as the
    wheels were asked to go, less far where they lag; and the ends, where its tangents there do not turn back."""
    if len(polynomial) == 2:
        return np.array([-1.0, 1.0])
    inner = np.linspace(scaled.min(), scaled.max(), rules.knots)
    rises = np.polyval(polynomial, inner[-1]) > np.polyval(polynomial, inner[0])
    low, high = (np.polyval(np.polyder(polynomial), inner[[0, -1]]) > 0.0) == rises
    ends = low and inner[0] > -1.0 + ROUNDING, high and inner[-1] < 1.0 - ROUNDING
    return np.array([*([-1.0] if ends[0] else []), *inner, *([1.0] if ends[1] else [])])


def _straight_on(polynomial: Array, at: Array, scaled: Array) -> Array:
    """(K,) values of a polynomial at (K,), beyond the range of what it was fitted to, scaled (N,), along its tangents there."""
    inside = np.clip(at, scaled.min(), scaled.max())
    return np.polyval(polynomial, inside) + np.polyval(np.polyder(polynomial), inside) * (at - inside)


def _missed(scaled: Array, rest: Array, rules: SteeringRules) -> float:
    """Root mean square over the commands of what the curve misses at one and the same command, beyond what scatter makes of it:
    rest (N,) in as many bins of scaled (N,) as the map has knots."""
    order = np.array_split(rest[np.argsort(scaled)], rules.knots)
    square = np.array([np.mean(part) ** 2 - np.var(part) / max(len(part), 1) for part in order])
    return float(np.sqrt(max(square.mean(), 0.0)))


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


def _on_fine_clock(t: Array, values: Array) -> tuple[Array, Array]:
    """Times (K,) at even steps of at most FINE, and values (N,) of t (N,) there, on curves that do not overshoot a step: on lines
    between slow samples a lag would seem a delay."""
    step = min(float(np.median(np.diff(t))), FINE)
    clock = t[0] + step * np.arange(int(np.ptp(t) / step) + 1)
    return clock, np.asarray(PchipInterpolator(t, values)(clock))


def _followed(t: Array, clock: Array, scaled: Array, angle: Array, rules: SteeringRules) -> tuple[float, float]:
    """Delay and lag (s) of the command with which a cubic leaves least, no lag where it takes away less than `shown` of it.

    scaled (K,): the command at even times clock (K,); angle (N,): at times t (N,).
    """
    found = {lag: _delay(t, clock, _lagged(clock, scaled, lag), angle, rules) for lag in (0.0, *rules.lags)}

    def left(lag: float) -> float:
        return found[lag][1]

    for _ in range(REFINED):
        tried = sorted(found)
        at = tried.index(min(found, key=left))
        between = np.linspace(tried[max(at - 1, 0)], tried[min(at + 1, len(tried) - 1)], 6)[1:-1]
        found |= {lag: _delay(t, clock, _lagged(clock, scaled, lag), angle, rules) for lag in map(float, between)}
    best = min(found, key=left)
    lag = best if left(best) < (1.0 - rules.shown) * left(0.0) else 0.0
    return found[lag][0], lag


def _settled(t: Array, rules: SteeringRules) -> NDArray[np.bool_]:
    """(N,) rows after the beginning of a log, where the wheels follow commands that it holds."""
    return t > t[0] + min(rules.settle, 0.2 * float(np.ptp(t)))


def _lagged(clock: Array, values: Array, lag: float) -> Array:
    """(K,) values (K,) at even times clock (K,) behind a lag of the first order (s)."""
    if lag <= 0.0:
        return values
    step = float(clock[1] - clock[0])
    kept = np.exp(-step / lag)
    mean = lag / step * (1.0 - kept)  # of the lag's response over a step: straight lines between samples go through it exactly
    before, now = mean - kept, 1.0 - mean
    start = [(1.0 - now) * values[0]]
    return np.asarray(lfilter([now, before], [1.0, -kept], values, zi=start)[0])


def _delay(t: Array, clock: Array, scaled: Array, angle: Array, rules: SteeringRules) -> tuple[float, float]:
    """Delay (s) at which a cubic of the delayed command leaves least, to NEAREST, and the squares that it leaves."""
    step, settled = float(np.median(np.diff(t))), np.flatnonzero(_settled(t, rules))
    settled = settled[:: max(len(settled) // rules.most, 1)]

    def left(delay: float) -> float:
        late, wheels = np.interp(t[settled] - delay, clock, scaled), angle[settled]
        return float(((np.polyval(np.polyfit(late, wheels, 3), late) - wheels) ** 2).sum())

    best = float(min(np.arange(0.0, rules.latest, step), key=left))
    while step > NEAREST:
        best, step = float(min(np.maximum(best + step * np.linspace(-1.0, 1.0, 11), 0.0), key=left)), step / 5
    return best, left(best)
