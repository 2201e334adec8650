"""Courses by their geometry: lane change, slalom, straight on, each after a weave on which the soil may be learnt."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from softsoil.control.path import Path

Array = NDArray[np.float64]

SPACING = 0.25
"""m between the points of a path."""
WARM_UP = 45.0
"""m: at the beginning of every course, a gentle weave on which the soil may be learnt; nothing is judged there."""


def _curve(y: Callable[[Array], Array], length: float) -> Path:
    x = np.arange(0.0, length + SPACING, SPACING)
    return Path(np.stack([x, y(x)], axis=1))


def _smooth(t: Array) -> Array:
    """0 to 1 with two continuous derivatives."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10.0 - 15.0 * t + 6.0 * t * t)


def _warm_up(x: Array) -> Array:
    """A gentle weave that begins and ends straight."""
    inside = _smooth(x / 8.0) * _smooth((WARM_UP - x) / 8.0)
    return 0.9 * inside * np.sin(2.0 * np.pi * x / 18.0)


def double_lane_change(width: float = 3.5, ramp: float = 13.5, hold: float = 9.0) -> Path:
    """To the left and back (after ISO 3888): width, ramp and hold in m."""
    first, back = WARM_UP + 3.0, WARM_UP + 3.0 + ramp + hold

    def y(x: Array) -> Array:
        return _warm_up(x) + width * (_smooth((x - first) / ramp) - _smooth((x - back) / ramp))

    return _curve(y, back + ramp + 22.0)


def slalom(amplitude: float = 1.6, wave: float = 26.0, waves: int = 3) -> Path:
    """A sine of `wave` m with an amplitude (m), `waves` times."""
    stop = WARM_UP + 3.0 + waves * wave

    def y(x: Array) -> Array:
        inside = _smooth((x - WARM_UP) / (wave / 3)) * _smooth((stop - x) / (wave / 3))
        return _warm_up(x) + amplitude * inside * np.sin(2.0 * np.pi * (x - WARM_UP - 3.0) / wave)

    return _curve(y, stop + 12.0)


def straight(length: float = 60.0) -> Path:
    """Straight on after the warm-up, over a length (m)."""
    return _curve(_warm_up, WARM_UP + length)
