"""Whether a lateral velocity is that of the centre of gravity, where no accelerometer says so: how v turns with the vehicle."""

from __future__ import annotations

import numpy as np

from softsoil.checking.words import Check
from softsoil.recording.evidence import Motion, regress
from softsoil.recording.geometry import Geometry

NAME = "lateral_velocity_place"
SIGMAS = 2.0
FARTHEST = 0.15
"""Over l_r: how far ahead of the rear axle v may seem to be taken and is still doubted. Slip that does not grow in proportion
draws the estimate towards the axle: 0.1 to 1.05 on 76 drives of sixteen vehicles with the centre of gravity's v, none of which
was doubted, -0.9 to 0.05 with the rear axle's, 72 of which were (`benchmarks.velocity_place`)."""
STEADY = 0.3
"""Largest standard error, over l_r, of the estimate."""


def place_checks(m: Motion, geometry: Geometry) -> list[Check]:
    """v against (ahead - c u^2) omega_z: ahead (m) of the rear axle, whose slip angle is c u omega_z; l_r for the centre of
    gravity. Odometry is often of the rear axle (base_link), and its v then hardly depends on turning. None with an accelerometer,
    against which v is compared itself."""
    u, v, omega = (m.channel(name) for name in ("u", "v", "omega_z"))
    if not np.isfinite(v).any() or np.isfinite(m.channel("a_y_imu")).any():
        return []
    turning = m.mean(omega)
    line = regress(m.driven(m.mean(v)), turning, -m.mean(u * u * omega), np.ones(m.windows))
    if line is None or not line.std[0] < STEADY * geometry.l_r:
        return []
    ahead, std = float(line.value[0]), float(line.std[0])
    doubtful = ahead + SIGMAS * std < FARTHEST * geometry.l_r
    found = f"one that turns {ahead:+.2f} ± {std:.2f} m ahead of the rear axle"
    expected = f"the lateral velocity of the centre of gravity, which turns {geometry.l_r:.2f} m ahead of the rear axle"
    cure = (
        f"if the source is odometry of the rear axle (base_link), give its place in [mount], x = {-geometry.l_r:.2f}: "
        "clocks that seem off may be right"
    )
    return [Check(NAME, "v", not doubtful, found, expected, cure if doubtful else "")]
