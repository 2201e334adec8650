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


def _warm_up(x: Array, length: float) -> Array:
    """A gentle weave over a length (m) that begins and ends straight."""
    inside = _smooth(x / 8.0) * _smooth((length - x) / 8.0)
    return 0.9 * inside * np.sin(2.0 * np.pi * x / 18.0)


def double_lane_change(width: float = 3.5, ramp: float = 13.5, hold: float = 9.0, warm_up: float = WARM_UP) -> Path:
    """To the left and back (after ISO 3888): width, ramp, hold and the weave before them, warm_up, in m."""
    first, back = warm_up + 3.0, warm_up + 3.0 + ramp + hold

    def y(x: Array) -> Array:
        return _warm_up(x, warm_up) + width * (_smooth((x - first) / ramp) - _smooth((x - back) / ramp))

    return _curve(y, back + ramp + 22.0)


def slalom(amplitude: float = 1.6, wave: float = 26.0, waves: int = 3, warm_up: float = WARM_UP) -> Path:
    """A sine of `wave` m with an amplitude (m), `waves` times, after a weave of warm_up m."""
    stop = warm_up + 3.0 + waves * wave

    def y(x: Array) -> Array:
        inside = _smooth((x - warm_up) / (wave / 3)) * _smooth((stop - x) / (wave / 3))
        return _warm_up(x, warm_up) + amplitude * inside * np.sin(2.0 * np.pi * (x - warm_up - 3.0) / wave)

    return _curve(y, stop + 12.0)


def straight(length: float = 60.0, warm_up: float = WARM_UP) -> Path:
    """Straight on over a length (m) after a weave of warm_up m."""
    return _curve(lambda x: _warm_up(x, warm_up), warm_up + length)
