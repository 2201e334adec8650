"""Clocks of the channels against each other."""

from __future__ import annotations

import numpy as np

from softsoil.checking.offsets import Offset, time_offsets
from softsoil.checking.words import LIMITS, Check
from softsoil.recording.drive import Recording
from softsoil.recording.geometry import Geometry
from softsoil.recording.noise_level import noise_level

CHANNELS = {"psi": "psi", "u": "u", "wheels": "omega_fl..rr", "position": "x, y", "steer": "steer"}
WRONG = 0.25
"""s: two sensors of one vehicle whose clocks are farther apart contradict each other."""
WRONG_EARLY = 0.7
"""s: a steering angle that is earlier than this is no actuator's lag any more."""

CLEARLY, PLACED = 0.7, 0.97
"""Share of what is left without a shift that one leaves at most that contradicts a clock; and of positions to be doubtful, which
steady circles tell from a slip angle by next to nothing."""
FILTERED = 0.012
"""s: a yaw rate that a low-pass has made so late is doubtful: n comes out 5 % too low (multi-sine, two soils: 9 % at 0.02 s)."""


def clock_checks(recording: Recording, geometry: Geometry, late_steering: float = 0.0) -> list[Check]:
    """One check per group of channels whose time offset can be estimated.

    geometry: of the vehicle; late_steering: seconds by which its road wheels are known to follow `steer`, which so seems early.
    """
    checks = []
    for offset in time_offsets(recording, geometry):
        declared = late_steering if offset.group == "steer" else 0.0
        late = offset.late_s + declared
        matters = offset.after - offset.before > 0.002 or abs(declared) > LIMITS.clock
        matters = matters and offset.trusted  # else a sign or a unit is wrong, which other checks say
        matters = matters and (offset.group != "position" or _clearly(offset, PLACED))
        least = LIMITS.heading_clock if offset.group == "psi" else LIMITS.clock
        doubtful = abs(late) > max(least, 3.0 * offset.std) and matters
        side = "late" if offset.late_s > 0 else "early"
        found = f"{abs(offset.late_s):.3f} ± {offset.std:.3f} s {side} against the {offset.against}"
        way = "early" if declared > 0.0 else "late"
        found += f", where {abs(declared):.3f} s {way} are declared" if abs(declared) > 0.005 else ""
        found += f" (correlation {offset.before:.3f}, {offset.after:.3f} when shifted)"
        channel = CHANNELS[offset.group]
        by = f"late = {late:.3f} at {channel} in its map"
        cure = f"softsoil import shifts it: --align where it is a source of its own, {by} where it shares one"
        if offset.group == "psi" and offset.late_s < 0:  # no heading comes before the turning that makes it
            cure = f"the yaw rate is late, which makes n too low: late = {-offset.late_s:.3f} at omega_z in the map of softsoil "
            cure += f"import; or the heading's clock is early: {by}"
        if offset.group == "steer" and -WRONG_EARLY < late < 0:
            cure += "; or the steering itself lags, which `softsoil refine` tells"
        if declared > LIMITS.clock:
            cure += "; or the vehicle's file declares a steering of another lag"
        if offset.group == "position":
            away, place = late * float(np.nanmedian(recording["u"])), "behind" if late > 0 else "ahead of"
            cure += f"; or these positions are of a point {abs(away):.1f} m {place} the front axle: give its place in [mount]"
        # Beside what is declared and by itself: a log that is right of itself contradicts the declaration, not its own clocks.
        wrong = all(one > WRONG or one < -(WRONG_EARLY if offset.group == "steer" else WRONG) for one in (late, offset.late_s))
        wrong = wrong and doubtful and offset.group != "wheels" and offset.after > 0.9 and _clearly(offset, CLEARLY)
        cure = cure if doubtful else ""
        checks.append(
            Check(f"clock_{offset.group}", channel, not doubtful, found, "one clock for all channels", cure, wrong)
        )
    return checks


def _clearly(offset: Offset, share: float) -> bool:
    """Whether a shift leaves less than a share of what is left without it: a slope of the ground looks like a clock, too."""
    return 1.0 - offset.after**2 < share * (1.0 - offset.before**2)


def filter_checks(recording: Recording) -> list[Check]:
    """Whether the noise of the yaw rate is that of a low-pass, which makes it late by less than clocks show; none where not."""
    late = noise_level(recording["omega_z"], recording.dt).late if recording.measured("omega_z") else 0.0
    if late < FILTERED:
        return []
    found, cure = f"noise that a low-pass of {late:.3f} s leaves", "log it unfiltered: n comes out too low where it is late"
    return [Check("filtered_yaw_rate", "omega_z", False, found, "a yaw rate as its sensor gives it", cure)]
