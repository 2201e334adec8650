"""Whether the speed is a speed over ground, or the wheels' own: wheel odometry shows no slip, and the slip is what soil makes."""

from __future__ import annotations

import numpy as np

from softsoil.checking.words import Check
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.evidence import Motion, interpolated, regress
from softsoil.recording.geometry import Geometry, radius_of
from softsoil.recording.noise_level import noise_level

EXPECTED = "a speed over ground, which wheels that drive or brake slip against"
LEAST_SLIP = 0.0015
"""Slip per m/s^2 of acceleration, mean of all wheels: asphalt 0.0025 (one driven axle) up, soil 0.03 to 0.13 (35 drives)."""
SURE = 0.0005
"""The same: standard error up to which a slip that does not show is no chance."""
NOISY = 0.002
"""m/s: less noise of u is that of no sensor."""
SHARED = 0.3
"""Share of its noise that a difference of two channels has left, where one is made of the other."""


def speed_checks(m: Motion, geometry: Geometry) -> list[Check]:
    """One check where all four wheel speeds are measured: slip follows the acceleration, and u has a noise of its own.

    geometry: radius of the wheels (m). Wheel odometry is u = r omega, mean of an axle or of all wheels.
    """
    wheels = {name: m.channel(name) for name in WHEEL_CHANNELS}
    if not all(np.isfinite(values).any() for values in wheels.values()):
        return []
    u, rim = m.channel("u"), {name: radius_of(geometry, name) * values for name, values in wheels.items()}
    steer = interpolated(m.channel("steer"), round(0.5 / m.log.dt))
    front, rear = 0.5 * (rim["omega_fl"] + rim["omega_fr"]), 0.5 * (rim["omega_rl"] + rim["omega_rr"])
    every = 0.5 * (front + rear)
    speed = m.speed
    slip = m.mean(every - u) / m.driven(speed)
    line = regress(slip, m.driven(m.slope(u)), m.driven(m.mean(steer**2)), np.ones(m.windows))
    found = ""
    if line is not None:
        found = f"a slip of {line.value[0]:+.4f} ± {line.std[0]:.4f} per m/s^2 of acceleration"
        if line.std[0] < SURE and abs(line.value[0]) < LEAST_SLIP:
            return [_odometry(found)]
    for name, mean in (("all wheels", every), ("the rear wheels", rear), ("the front wheels", front * np.cos(steer))):
        own, other, shared = (noise_level(values, m.log.dt).rough for values in (u, mean, u - mean))
        if own > NOISY and shared < SHARED * min(own, other):
            return [_odometry(f"the noise of the mean of {name} in it, to {100 * shared / own:.0f} %")]
    return [Check("speed_source", "u", True, found, EXPECTED)] if found else []


def over_ground(recording: Recording, geometry: Geometry) -> bool:
    """Whether u is no wheel odometry, as far as the log shows; geometry: radius of the wheels (m)."""
    return all(check.passed for check in speed_checks(Motion.of(recording), geometry))


def _odometry(found: str) -> Check:
    cure = "is u made of the wheel speeds? It hides the slip, and n comes out wrong: map a speed of GPS, radar, camera or an INS"
    return Check("speed_source", "u", False, found, EXPECTED, cure)
