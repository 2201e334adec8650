"""Models of logs without wheel speeds: wheels that turn as the balance of forces asks."""

from __future__ import annotations

from collections.abc import Sequence

from softsoil.declaration.driveline import with_driveline
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.symbolic.model import Model


def absent_wheels(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Wheels, of "fl", "fr", "rl", "rr", that the model turns, since a recording does not measure their speed.

    Where wheels of both axles are absent, all are among them: single encoders then make n depend on its initial guess,
    which the balance of forces alone does not (`python benchmarks/absent_channels.py`).
    """
    absent = tuple(name[-2:] for name in WHEEL_CHANNELS if not all(r.measured(name) for r in recordings))
    both = len({wheel[0] for wheel in absent}) == 2
    return tuple(name[-2:] for name in WHEEL_CHANNELS) if both else absent


def with_log_wheels(model: Model, recordings: Sequence[Recording]) -> Model:
    """The bicycle `model` for the recordings: wheels without a measured speed turn as the balance of forces asks."""
    return with_driveline(model, absent_wheels(recordings))
