"""Models of logs without wheel speeds: wheels that turn as the balance of forces asks."""

from __future__ import annotations

from collections.abc import Sequence

from softsoil.declaration.driveline import with_driveline
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.symbolic.model import Model


def absent_axles(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Axles, of "f", "r", of which a recording does not measure both wheel speeds."""
    return tuple(
        axle
        for axle in "fr"
        if not all(r.measured(*(name for name in WHEEL_CHANNELS if name[-2] == axle)) for r in recordings)
    )


def with_log_wheels(model: Model, recordings: Sequence[Recording]) -> Model:
    """The bicycle `model` for the recordings: axles without measured wheel speeds turn as the balance of forces asks."""
    return with_driveline(model, absent_axles(recordings))
