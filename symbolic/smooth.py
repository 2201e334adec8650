"""The few smooth replacements that keep every derivative finite, stated once."""

from typing import Any

import casadi as ca

Scalar = Any
"""A CasADi SX or MX scalar, or a float."""


def smooth_norm(a: Scalar, b: Scalar, width: float) -> Scalar:
    """sqrt(a^2 + b^2 + width^2): a length that never vanishes (unit of a)."""
    return ca.sqrt(a * a + b * b + width * width)


def smooth_positive(value: Scalar, width: float) -> Scalar:
    """(value + sqrt(value^2 + width^2))/2: a positive part with slope 1/2 at zero (unit of value)."""
    return 0.5 * (value + ca.sqrt(value * value + width * width))


def smooth_min(a: Scalar, b: Scalar, width: float) -> Scalar:
    """Smooth minimum of a and b, at most width/2 below it (unit of a)."""
    return 0.5 * (a + b - ca.sqrt((a - b) * (a - b) + width * width))


def held(value: Scalar, most: Scalar, width: float = 0.02) -> Scalar:
    """`value` >= 0 held smoothly at `most`, over width * most, and above zero however small it is (unit of value)."""
    return smooth_positive(smooth_min(value, most, width * most), 0.5 * width * width * most)


def fade_in(value: Scalar, full: Scalar) -> Scalar:
    """s^2 (3 - 2 s) with s = value/full, at most 1: 0 at 0 and 1 from `full` on (unit of value), slope 0 at both."""
    share = ca.fmin(value / full, 1.0)
    return share * share * (3.0 - 2.0 * share)
