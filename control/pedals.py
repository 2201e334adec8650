"""Throttle and brake for a vehicle that takes pedals instead of an acceleration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softsoil.codegen.sampling import STEP


@dataclass
class Pedals:
    """Feed-forward, proportional and integral: throttle and brake for an acceleration and a speed.

    base, gain (s^2/m): throttle that holds the speed, and per acceleration; proportional (s/m), integral (1/m): of the error
    in speed; brake (s^2/m): pedal per deceleration; tick: time between calls (s).
    """

    base: float = 0.15
    gain: float = 0.12
    proportional: float = 0.35
    integral: float = 0.15
    brake: float = 0.12
    tick: float = STEP
    _sum: float = 0.0

    def __call__(self, a_x: float, wanted: float, u: float) -> tuple[float, float]:
        """(throttle, brake) in [0, 1] for a_x (m/s^2) now and the speeds wanted and u, the present one (m/s)."""
        error = wanted - u
        asked = self.base + self.gain * a_x + self.proportional * error + self._sum
        if 0.0 < asked < 1.0:
            self._sum = float(np.clip(self._sum + self.integral * error * self.tick, -0.3, 0.5))
        braking = float(np.clip(-self.brake * (a_x + 1.0) if a_x < -1.0 else 0.0, 0.0, 1.0))
        return float(np.clip(asked, 0.0, 1.0)) if braking == 0.0 else 0.0, braking
