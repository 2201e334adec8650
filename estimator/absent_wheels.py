"""Models of logs without wheel speeds: wheels that turn as the balance of forces asks."""

from __future__ import annotations

from collections.abc import Sequence

from softsoil.declaration.driveline import with_driveline
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.symbolic.model import Model


def absent_wheels(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Wheels, of "fl", "fr", "rl", "rr", whose speed a recording does not measure."""
    return tuple(name[-2:] for name in WHEEL_CHANNELS if not all(r.measured(name) for r in recordings))


def with_log_wheels(model: Model, recordings: Sequence[Recording]) -> Model:
    """The bicycle `model` for the recordings: wheels without a measured speed turn as the balance of forces asks."""
    return with_driveline(model, absent_wheels(recordings))
