"""The few smooth replacements that keep every derivative finite, stated once."""

from __future__ import annotations

from typing import Any

import casadi as ca

Scalar = Any
"""A CasADi SX or MX scalar, or a float."""


def smooth_abs(value: Scalar, width: float) -> Scalar:
    """sqrt(value^2 + width^2) - width: zero at zero, smooth, at most `width` below |value| (unit of value)."""
    return ca.sqrt(value * value + width * width) - width


def smooth_norm(a: Scalar, b: Scalar, width: float) -> Scalar:
    """sqrt(a^2 + b^2 + width^2): a length that never vanishes (unit of a)."""
    return ca.sqrt(a * a + b * b + width * width)


def smooth_positive(value: Scalar, width: float) -> Scalar:
    """(value + sqrt(value^2 + width^2))/2: a positive part with slope 1/2 at zero (unit of value)."""
    return 0.5 * (value + ca.sqrt(value * value + width * width))


def smooth_min(a: Scalar, b: Scalar, width: float) -> Scalar:
    """Smooth minimum of a and b, at most width/2 below it (unit of a)."""
    return 0.5 * (a + b - ca.sqrt((a - b) * (a - b) + width * width))


def power(base: Scalar, exponent: Scalar, floor: float = 1e-9) -> Scalar:
    """base^exponent for base >= 0 with finite derivatives at 0: exp(exponent log(base + floor))."""
    return ca.exp(exponent * ca.log(base + floor))
