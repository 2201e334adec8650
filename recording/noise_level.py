"""How noisy a channel is: of one sample, and as much white noise as has the same share of slow errors.

A smooth signal sampled finely has third differences of its noise only. Where they grow with the distance of their samples, but
slower than those of any motion, the noise itself is correlated: a filter has smoothed it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LONGEST = 0.1
"""s: distance of the samples of a third difference up to which a motion of 1.5 Hz is a tenth of itself in it."""
GROWS, MOTION = 1.15, 2.83
"""Growth of third differences when their samples are twice as far: above chance, and that of the smoothest noise (2 sqrt 2); a
motion grows 8 times."""
FEWEST = 3
"""Distances at which third differences are compared, at least: two do not tell a low-pass from white noise with some motion."""
FARTHEST = 3.0
"""Largest standard deviation of a sample over what was seen of it."""
SHORT = (2.0, 0.75)
"""Time constants of a low-pass run forwards, and forwards and backwards, from which on its noise looks like a motion, over the
distance of the samples."""
GAP = 2.5
"""Steps between a channel's samples over the usual one beyond which there is a gap, which no difference spans."""
HALF = 0.25
"""s: distance of the samples of second differences, in which a vehicle's motion shows."""
OF_MOTION = 0.08
"""Share of these from which correlated noise counts: on clean drives of two vehicles what looks like it is at most 0.06."""


@dataclass(frozen=True)
class NoiseLevel:
    """Noise of a channel, in its unit.

    std: standard deviation of a sample; white: of white noise that is as large in means, slopes and fits over times that are
    long against the noise's own; rough: of white noise that has the same third differences of neighbours; late: seconds by which
    a low-pass that leaves such noise is late, 0 where it is white, or was run backwards as well.
    """

    std: float
    white: float
    rough: float
    late: float = 0.0


def noise_level(values: Array, dt: float) -> NoiseLevel:
    """The noise of a channel by third differences, robust; 0 with fewer than 4 finite values.

    values (N,): NaN between the samples of a channel that is slower than the clock; dt: of the clock (s). Noise is matched to
    what a first-order low-pass leaves of white noise, run forwards, or forwards and backwards.
    """
    own, period, stretch = own_samples(values, dt)
    if len(own) < 4 or not (stretch[3:] == stretch[:-3]).any():
        return NoiseLevel(0.0, 0.0, 0.0)
    levels = [_third(own, stretch, 1)]
    while (stride := 2 ** len(levels)) * period <= LONGEST and (stretch[3 * stride :] == stretch[: -3 * stride]).any():
        level = _third(own, stretch, stride)
        if level > MOTION * levels[-1]:
            break
        levels.append(level)
    if len(levels) < FEWEST or levels[1] <= GROWS * levels[0]:
        return NoiseLevel(levels[0], levels[0], levels[0])
    matched = _matched(np.array(levels))
    if matched is None or matched[0] < OF_MOTION * _motion(own, stretch, max(round(HALF / period), 1)):
        return NoiseLevel(levels[0], levels[0], levels[0])
    std, correlated, late = matched
    std = min(std, FARTHEST * levels[-1])
    return NoiseLevel(std, std * float(np.sqrt(correlated)), levels[0], late * period)


def own_samples(values: Array, dt: float) -> tuple[Array, float, NDArray[np.int_]]:
    """The finite values (M,) of a channel, the time from one to the next (s), and the stretch between gaps that each is of (M,).

    values (N,): NaN between the samples of a channel that is slower than the clock; dt: of the clock (s).
    """
    own = np.flatnonzero(np.isfinite(values))
    steps = np.diff(own)
    usual = float(np.median(steps)) if len(steps) else 1.0
    return values[own], dt * usual, np.cumsum(np.concatenate([np.zeros(1, dtype=int), steps > GAP * usual]))[: len(own)]


def third_differences(values: Array, stretch: NDArray[np.int_], stride: int = 1) -> Array:
    """Third differences of values (M,) at a distance of `stride` samples, none across a gap; stretch (M,): by `own_samples`."""
    third = values[3 * stride :] - 3.0 * values[2 * stride : -stride] + 3.0 * values[stride : -2 * stride] - values[: -3 * stride]
    return third[stretch[3 * stride :] == stretch[: -3 * stride]]


def _third(values: Array, stretch: NDArray[np.int_], stride: int) -> float:
    """Standard deviation of white noise with these third differences."""
    return 1.4826 * float(np.median(np.abs(third_differences(values, stretch, stride)))) / float(np.sqrt(20.0))


def _motion(values: Array, stretch: NDArray[np.int_], stride: int) -> float:
    """Standard deviation of white noise with the second differences of values (M,) at a distance of `stride` samples."""
    second = values[2 * stride :] - 2.0 * values[stride:-stride] + values[: -2 * stride]
    second = second[stretch[2 * stride :] == stretch[: -2 * stride]]
    return float(np.sqrt(np.mean(second**2) / 6.0)) if len(second) else 0.0


def _matched(levels: Array) -> tuple[float, float, float] | None:
    """Standard deviation of a sample, how many samples count as one, and by how many the low-pass is late, by `levels` (L,) at
    strides of 1, 2, 4 ... samples; None for what may be a motion."""
    seen, correlated, late, sure = _low_passes(len(levels))
    apart = np.log(levels / seen)
    best = int(np.argmin(np.var(apart, axis=1)))
    return (float(np.exp(apart[best, -1])), float(correlated[best]), float(late[best])) if sure[best] else None


@lru_cache
def _low_passes(count: int) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Third differences of what K low-passes leave of noise of deviation 1, (K, count) at strides of 1, 2, 4 ... samples; how
    many samples count as one, how many each is late, and whether its noise does not look like a motion, each (K,)."""
    strides: Array = np.exp2(np.arange(count, dtype=np.float64))
    rows: list[tuple[Array, float, float, bool]] = []
    for shape, most in zip((_once, _twice), SHORT, strict=True):
        for length in np.geomspace(0.2, most * strides[-1], 40).tolist():
            kept = math.exp(-1.0 / length)
            rho = [shape(kept, order * strides) for order in (1, 2, 3)]
            seen = np.sqrt((20.0 - 30.0 * rho[0] + 12.0 * rho[1] - 2.0 * rho[2]) / 20.0)
            correlated = 1.0 + 2.0 * float(shape(kept, np.arange(1.0, 40.0 * strides[-1])).sum())
            late = kept / (1.0 - kept) if shape is _once else 0.0
            rows.append((seen, correlated, late, length < 0.99 * most * strides[-1]))
    table = [np.array(column) for column in zip(*rows, strict=True)]
    return table[0], table[1], table[2], table[3]


def _once(kept: float, k: Array) -> Array:
    """Correlation of samples at a distance of k (K,), `kept` of the low-pass's state left from one to the next."""
    return kept**k


def _twice(kept: float, k: Array) -> Array:
    return (1.0 + k * (1.0 - kept**2) / (1.0 + kept**2)) * kept**k
