"""Whether a vehicle that does not turn moves straight on: a sensor that is turned makes a lateral velocity."""

from __future__ import annotations

import numpy as np

from softsoil.checking.words import LIMITS, Check
from softsoil.recording.evidence import Motion, interpolated, regress

NAME = "v_straight"
MOST = 0.03
"""rad: slip angle without a turn up to which it may come from a slope to the side, wind or a dragging wheel."""


def straight_checks(m: Motion) -> list[Check]:
    """One check where v is measured and tells: v/u over windows by omega_z/u, omega_z u, as axles slip, and what is left."""
    if not m.log.measured("u", "v", "omega_z"):
        return []
    reach = round(0.5 / m.log.dt)
    v, omega_z = (m.mean(interpolated(m.channel(name), reach)) for name in ("v", "omega_z"))
    speed = m.driven(m.speed)
    line = regress(v / speed, omega_z / speed, omega_z * speed, np.ones(m.windows))
    if line is None or not line.std[2] < MOST / 3:
        return []
    slip, std = float(line.value[2]), float(line.std[2])
    wrong = abs(slip) > max(MOST, LIMITS.sigmas * std)
    found = f"{slip:+.3f} ± {std:.3f} of the speed without a turn"
    expected = f"no lateral velocity straight on (within {MOST:g} of the speed)"
    cure = (
        f"offset = {slip:.3f} for psi, where that turns velocities, else yaw = {-slip:.3f} in the [mount] of its sensor; or "
        "something pulls the vehicle to one side"
    )
    return [Check(NAME, "v", not wrong, found, expected, cure if wrong else "")]
