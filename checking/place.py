"""Of which point of the vehicle a lateral velocity is, or a position, by how it turns, where no other channel says so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from softsoil.checking.words import Check
from softsoil.recording.drive import Array, Recording
from softsoil.recording.evidence import Line, Motion, interpolated, regress
from softsoil.recording.geometry import Geometry
from softsoil.recording.laid_heading import laid_heading

NAME, POSITIONS = "lateral_velocity_place", "position_place"
SIGMAS = 2.0
FARTHEST = 0.15
"""Over l_r: how far ahead of the rear axle v may seem to be taken and is still doubted. Slip that does not grow in proportion
draws the estimate towards the axle: 0.1 to 1.05 on 76 drives of sixteen vehicles with the centre of gravity's v, none of which
was doubted, -0.9 to 0.05 with the rear axle's, 72 of which were (`benchmarks.velocity_place`)."""
STEADY = 0.3
"""Largest standard error, over l_r, of the estimate."""
LAYINGS = 4
"""Rounds in which a heading is laid on positions and their place found."""
BEYOND = 1.4
"""Over l_r: how far ahead of the rear axle, less l_f, a position may seem to be: 0.24 to 1.13 on those drives with the front
axle's, none of which was doubted, -1.06 to 0.32 with the centre of gravity's, 53 of 64 of which were."""


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


def position_checks(m: Motion, geometry: Geometry) -> list[Check]:
    """Positions across the heading against (ahead - c u^2) omega_z, as of `place_checks`; l_f + l_r for the front axle. None with
    a measured v, against which positions are compared themselves; a heading that is not measured is laid on them."""
    if np.isfinite(m.channel("v")).any():
        return []
    line = _across(m, geometry)
    if line is None or not line.std[0] < STEADY * geometry.l_r:
        return []
    ahead, std = float(line.value[0]), float(line.std[0])
    seen, least = (ahead - geometry.l_f) / geometry.l_r, SIGMAS * std / geometry.l_r
    doubtful = seen + least < FARTHEST or seen - least > BEYOND
    wheelbase = geometry.l_f + geometry.l_r
    found = f"one that turns {ahead:+.2f} ± {std:.2f} m ahead of the rear axle"
    expected = f"the position of the front axle, {wheelbase:.2f} m ahead of the rear axle"
    cure = "give the antenna's place in [mount] of the map, or mend its clock; positions are set aside" if doubtful else ""
    return [Check(POSITIONS, "x, y", not doubtful, found, expected, cure)]


def without_misplaced(recording: Recording, checks: Sequence[Check]) -> Recording:
    """The recording without positions that `position_checks` finds to be of another point: no lateral velocity is to be derived
    from them.

    checks: of its channels.
    """
    if all(check.passed for check in checks if check.name == POSITIONS):
        return recording
    note = "x, y: of another point than the front axle, or of another time, by how they turn"
    return replace(recording, state={**recording.state, "x": "absent", "y": "absent"}, notes=(*recording.notes, note))


def _across(m: Motion, geometry: Geometry) -> Line | None:
    """The sideways motion of positions on omega_z, -u |u| omega_z and u, which a heading that is turned makes."""
    u, omega = (interpolated(m.channel(name), round(0.5 / m.log.dt)) for name in ("u", "omega_z"))
    psi = interpolated(m.channel("psi"), round(0.5 / m.log.dt))
    if np.isfinite(psi).any():
        return _sideways(m, psi, u, omega)
    ahead, turning = np.nan_to_num(u), np.nan_to_num(omega)
    aside, line = geometry.l_f * turning, None
    for _ in range(LAYINGS):  # by the slip that the line says: none at first
        laid = laid_heading(m.channel("x"), m.channel("y"), ahead, aside, turning, m.log.dt)
        line = None if laid is None or laid.scattered else _sideways(m, laid.psi, u, omega)
        if line is None or not np.isfinite(line.std[:2]).all():
            return None
        aside = (line.value[0] - line.value[1] * ahead * np.abs(ahead)) * turning
    return line


def _sideways(m: Motion, psi: Array, u: Array, omega: Array) -> Line | None:
    """As of `_across`, with a heading (N,), rad, a speed (N,), m/s, and a yaw rate (N,), rad/s."""
    x, y = m.channel("x"), m.channel("y")
    middle = np.unwrap(np.nan_to_num(m.mean(psi)))

    def sideways(ahead: Array, aside: Array) -> Array:
        """(windows,) slopes across the mean heading of the path that velocities in the vehicle's frame make."""
        path = (ahead + 1j * aside) * np.exp(1j * psi)
        rates = m.slope(m.integral(path.real), x), m.slope(m.integral(path.imag), y)
        return -np.sin(middle) * rates[0] + np.cos(middle) * rates[1]

    still = np.zeros_like(u)
    moved = -np.sin(middle) * m.slope(x) + np.cos(middle) * m.slope(y) - sideways(u, still)
    features = sideways(still, omega), sideways(still, -u * np.abs(u) * omega), sideways(still, u)
    return regress(m.driven(moved), *features)
