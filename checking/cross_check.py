"""Channels of a drive checked against each other: signs, units, scales, offsets, clocks, frozen and saturated sensors.

No model of tyre or soil is needed: rigid-body kinematics says what one channel must be, given the others. Only measured channels
are compared: one that was derived from others agrees with them by construction.
"""

from __future__ import annotations

from collections.abc import Sequence

from softsoil.checking.clocks import clock_checks, filter_checks
from softsoil.checking.motion import heading_checks, inertial_checks, pose_checks
from softsoil.checking.place import place_checks, position_checks
from softsoil.checking.single import excitation_checks, single_checks
from softsoil.checking.speed import speed_checks
from softsoil.checking.straight import straight_checks
from softsoil.checking.wheels import sensor_checks, side_checks, steering_checks, turned_over, wheel_checks
from softsoil.checking.words import Check
from softsoil.recording.drive import Recording
from softsoil.recording.evidence import Motion
from softsoil.recording.geometry import Geometry

FEWEST_WINDOWS = 4
"""A drive shorter than so many windows cannot be checked."""


def check_channels(recording: Recording, geometry: Geometry, late_steering: float = 0.0) -> tuple[Check, ...]:
    """Every check that the measured channels of a drive allow.

    geometry: of the vehicle; late_steering: seconds by which its road wheels are known to follow `steer`.
    """
    motion = Motion.of(recording)
    if motion.windows < FEWEST_WINDOWS:
        return ()
    checks = excitation_checks(motion)
    if not checks[0].passed:
        return tuple(checks)
    checks += place_checks(motion, geometry) + position_checks(motion, geometry)
    checks += clock_checks(recording, geometry, late_steering)  # before the rest: a clock that is off makes other checks fail
    checks += filter_checks(motion.log)
    checks += speed_checks(motion, geometry)
    checks += straight_checks(motion) + heading_checks(motion) + pose_checks(motion, geometry) + inertial_checks(motion)
    sides = side_checks(motion, geometry)
    steering = turned_over(steering_checks(motion, geometry), sides)
    checks += steering  # before the wheels: a front wheel's speed is compared along its steering
    steered = not any(check.beyond_doubt for check in steering)
    checks += wheel_checks(motion, geometry, steered) + sensor_checks(motion, geometry) + sides
    checks += single_checks(motion)
    return tuple(checks)


def refuse_contradictions(where: str, checks: Sequence[Check]) -> None:
    """Raise ValueError naming `where`, channel, evidence and cure for the first check that failed beyond doubt."""
    wrong = [check for check in checks if not check.passed and check.beyond_doubt]
    if wrong:
        more = f" ({len(wrong) - 1} more: {', '.join(check.name for check in wrong[1:])})" if len(wrong) > 1 else ""
        raise ValueError(f"{where}: {wrong[0].sentence()}{more}")


def warnings(checks: Sequence[Check]) -> tuple[str, ...]:
    """One sentence per doubtful check."""
    return tuple(check.sentence() for check in checks if not check.passed and not check.beyond_doubt)
