"""A coefficient that must be 1: flipped, in another unit, of another scale, or right."""

from __future__ import annotations

import numpy as np

from softsoil.checking.words import LIMITS, Check
from softsoil.recording.drive import CHANNEL_UNITS
from softsoil.recording.evidence import Line


def scale_check(
    name: str, channel: str, line: Line, index: int, expected: str, cure: str, doubtful_at: float = LIMITS.scale
) -> Check:
    """A coefficient (number `index` of `line`) that must be 1: flipped, in another unit, of another scale, or right.

    name, channel, expected: as of Check; cure: for a wrong scale; doubtful_at: departure from 1 that is doubtful.
    """
    value, std, bias = float(line.value[index]), float(line.std[index]), float(line.bias[index])
    low, high = LIMITS.wrong_scale
    found = f"a scale of {value:.3f} ± {std:.3f}"
    sure = std < 0.15 * max(abs(value), 1.0) and abs(value - 1.0) > bias
    if sure and value < -0.3 and value < -LIMITS.sigmas * std:
        compass = ", or compass = true where it grows clockwise from north" if channel == "psi" else ""
        return Check(name, channel, False, found, expected, f"sign = -1 for {channel}{compass}", True)
    if sure and not low <= value <= high and abs(value - 1.0) > LIMITS.sigmas * std:
        return Check(name, channel, False, found, expected, cure + unit_hint(channel, value), True)
    doubtful = abs(value - 1.0) > max(doubtful_at, LIMITS.sigmas * std, bias)
    return Check(name, channel, not doubtful, found, expected, cure if doubtful else "")


UNIT_RATIOS = {
    "rad": ((180 / np.pi, "degrees"),),
    "rad/s": ((180 / np.pi, "deg/s"), (30 / np.pi, "rpm")),
    "m/s": ((3.6, "km/h"), (2.23694, "mph"), (1000.0, "mm/s")),
    "m/s^2": ((1.0 / 9.80665, "g"), (1000.0, "mm/s^2")),
}
"""SI unit -> what a channel in another unit is too large by."""


def unit_hint(channel: str, scale: float) -> str:
    """Which mistaken unit makes the channel so called `scale` times what it must be, or converted twice; empty for none."""
    for ratio, words in UNIT_RATIOS.get(CHANNEL_UNITS.get(channel, ""), ()):
        for factor, doubt in ((ratio, f" ({words}?)"), (1.0 / ratio, f" (converted from {words} twice?)")):
            if 0.9 < abs(scale) / factor < 1.1:
                return doubt
    return ""
