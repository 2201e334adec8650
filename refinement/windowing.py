"""How drives are cut into windows for the tracing: length, smoothing of the recorded states, Euler steps per sample."""

from __future__ import annotations

from dataclasses import dataclass

from softsoil.estimator.horizons import HORIZONS
from softsoil.refinement.rules import RULES
from softsoil.windows.shooting import SMOOTHING

SAMPLES = 7
"""Samples that smooth a recorded state on hard ground, where a vehicle answers within hundredths of a second."""


@dataclass(frozen=True)
class Windowing:
    """horizon: length of the windows (s); smoothing: of the recorded states (s), default by their noise on soil (`lengths` of
    `softsoil.windows.shooting`), SAMPLES on hard ground;
    substeps: Euler steps in a sample, default as many as the fitted model's fastest motion needs; horizons: s, of the errors.
    """

    horizon: float = RULES.horizon
    smoothing: float | None = None
    substeps: int | None = None
    horizons: tuple[float, ...] = HORIZONS

    def smooth(self, dt: float, sinks: bool) -> float | None:
        """The length that smooths the states of a drive with samples dt (s) apart, None: by their noise; sinks: on soil."""
        return self.smoothing or (None if sinks else min(SAMPLES * dt, SMOOTHING))
