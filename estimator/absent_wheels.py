"""Models of logs without wheel speeds: wheels that turn as the balance of forces asks."""

from __future__ import annotations

from collections.abc import Sequence

from softsoil.declaration.driveline import with_driveline
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.symbolic.model import Model


def absent_wheels(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Wheels, of "fl", "fr", "rl", "rr", that the model turns, since a recording does not measure their speed.

    Beside an axle without any, a single measured wheel of the other is among them: its noise would go into the force that is left
    for that axle, and n then depends on its initial guess (`benchmarks/absent_channels.py --without "three wheels"`).
    """
    absent = [name[-2:] for name in WHEEL_CHANNELS if not all(r.measured(name) for r in recordings)]
    axles = [wheel[0] for wheel in absent]
    if any(axles.count(axle) == 2 for axle in axles):
        absent = [name[-2:] for name in WHEEL_CHANNELS if name[-2] in axles]
    return tuple(absent)


def with_log_wheels(model: Model, recordings: Sequence[Recording]) -> Model:
    """The bicycle `model` for the recordings: wheels without a measured speed turn as the balance of forces asks."""
    return with_driveline(model, absent_wheels(recordings))
