"""Wheel speeds against the speed of each wheel's centre, and the steering angle against the motion that it causes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from softsoil.checking.scale import unit_hint
from softsoil.checking.words import LIMITS, Check
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.evidence import Motion, interpolated, lagged, regress
from softsoil.recording.geometry import Geometry, corners, radius_of

GRAVITY = 9.81
"""m/s^2"""
LEAST_TURNING = 0.02
"""Difference of the wheels' speeds of an axle, over speed (root mean square), from which a drive turns."""

RIM = {"m/s": 1.0, "km/h": 3.6, "mph": 2.23694}
"""Unit of a rim's speed -> of so many in one m/s."""
RIM_APART = (0.95, 1.2)
"""Between these, rim speed over ground speed over what such a unit makes of it: driven wheels slip."""
AXLES = (WHEEL_CHANNELS[:2], WHEEL_CHANNELS[2:])
OTHER_SIDE = dict(zip(WHEEL_CHANNELS, ("omega_fr", "omega_fl", "omega_rr", "omega_rl"), strict=True))


DRIVE_SLIP = 1.35
"""Rim speed over ground speed to which the only driven axle may slip: more is a wrong radius or unit as well."""
DIAMETER = (1.7, 2.8)
"""Rim speed over ground speed, of most wheels, that a diameter in the place of a radius makes, with slip."""


def wheel_checks(m: Motion, geometry: Geometry, front: bool = True) -> list[Check]:
    """r omega over the speed of the wheel's centre in its plane, per wheel: 1 + slip for every wheel.

    geometry: place of the wheels and their radius; front: whether steered wheels are compared, for which the angle must be right.
    """
    reach = round(0.5 / m.log.dt)
    u, omega_z, steer = (interpolated(m.channel(name), reach) for name in ("u", "omega_z", "steer"))
    v = interpolated(m.channel("v"), reach)
    v = np.where(np.isfinite(v), v, 0.0)
    ratios: dict[str, float] = {}
    for name, (x, y, steered) in corners(geometry).items():
        spin = m.channel(name)
        if not np.isfinite(spin).any() or (steered and not front):
            continue
        angle = steer if steered else np.zeros_like(steer)
        centre = (u - y * omega_z) * np.cos(angle) + (v + x * omega_z) * np.sin(angle)
        rolled = m.driven(m.mean(radius_of(geometry, name) * spin)) / m.mean(centre)
        if np.isfinite(rolled).sum() >= 8:
            ratios[name] = float(np.nanmedian(rolled))
    if not ratios:
        return []
    low, high = LIMITS.wheel
    middle = float(np.median(list(ratios.values())))
    checks = []
    for name, ratio in ratios.items():
        found, expected = f"rim speed over ground speed {ratio:.3f}", f"1 + slip, within {low:g} to {high:g}"
        if ratio < 0.0 and abs(ratio) > 0.1:
            checks.append(Check(f"wheel_{name}", name, False, found, expected, f"sign = -1 for {name}", True))
        elif not low <= ratio <= high:
            hint = unit_hint(name, ratio) or _of_rim(ratio, radius_of(geometry, name))
            hint += " (is the vehicle's radius a diameter?)" if DIAMETER[0] < middle < DIAMETER[1] else ""
            cure = f"correct the unit of {name}{hint}, its radius, or leave it out"
            checks.append(Check(f"wheel_{name}", name, False, found, expected, cure, True))
        else:
            alike = _alike([ratio, ratios.get(OTHER_SIDE[name], np.inf)])
            drive = _drive(geometry, name) if _one_axle_slips(ratios) else None
            odd = abs(ratio / middle - 1.0) > LIMITS.wheel_apart and drive is None
            slips = not 1.0 - 2.0 * LIMITS.wheel_apart <= ratio <= 1.0 + 2.0 * LIMITS.wheel_apart
            slips &= not (drive is not None and drive > 0.5 and ratio > 1.0)  # of both axles it may be the radius
            # The slip that the other wheels have is no sensor's.
            rolling = float(np.median([r for other, r in ratios.items() if other != name])) if odd and len(ratios) > 2 else 1.0
            cure = f"factor = {rolling / ratio:.3f} for {name}, or another radius" if odd or slips else ""
            cure += _of_rim(ratio, radius_of(geometry, name)) if slips and not odd else ""
            cure += "; or the wheels slip as much on this ground" if slips and not odd and ratio > 1.0 else ""
            if odd and alike:
                cure = (
                    "both wheels of the axle slip as much: driven ones turn faster than they roll, towed ones slower, which "
                    "[driveline] of the vehicle says; or another radius of that axle (radius_rear)"
                )
            expected = f"all wheels alike ({middle:.3f}) and near 1" if odd or slips else expected
            checks.append(Check(f"wheel_{name}", name, not (odd or slips), found, expected, cure))
    return checks


def _one_axle_slips(ratios: Mapping[str, float]) -> bool:
    """Whether the wheels of each axle turn alike, one axle near its rolling, and the other with no more than a drive's slip."""
    axles = [[ratios[name] for name in axle if name in ratios] for axle in AXLES]
    if not all(axles):
        return False
    alike = all(map(_alike, axles))
    slips = [max(abs(ratio - 1.0) for ratio in axle) for axle in axles]
    return alike and min(slips) < 2.0 * LIMITS.wheel_apart and max(slips) < DRIVE_SLIP - 1.0


def _alike(ratios: Sequence[float]) -> bool:
    """Whether the wheels of an axle turn alike; none does with one that stands."""
    least, most = min(ratios), max(ratios)
    return least > 0.0 and most - least < LIMITS.wheel_apart / 2 * least


def _drive(geometry: Geometry, name: str) -> float | None:
    """Share of the drive at a wheel's axle, where the vehicle declares that its axles turn freely of each other; else None."""
    declared = getattr(geometry, "driveline", {})
    if not declared or declared.get("centre_lock", 1.0) > 0.5 or "front_drive" not in declared:
        return None
    return float(declared["front_drive"] if name in AXLES[0] else 1.0 - declared["front_drive"])


def _of_rim(ratio: float, radius: float) -> str:
    """A hint where the speed is that of the rim; radius (m)."""
    units = (unit for unit, size in RIM.items() if RIM_APART[0] < ratio / (size * radius) < RIM_APART[1])
    return next((f' ({unit}? unit = "{unit}")' for unit in units), "")


def sensor_checks(m: Motion, geometry: Geometry) -> list[Check]:
    """Whether each wheel has a sensor: in turns the four have no speed in common, to the last digit not even on locked axles.

    geometry: track.
    """
    wheels = [m.channel(name) for name in WHEEL_CHANNELS]
    turns = geometry.track * m.mean(m.channel("omega_z")) / m.driven(m.speed)
    turning = float(np.sqrt(np.nanmean(turns**2))) if np.isfinite(turns).any() else 0.0
    if turning < LEAST_TURNING or not all(np.isfinite(wheel).any() for wheel in wheels):
        return []
    same = all(np.array_equal(wheel, wheels[0], equal_nan=True) for wheel in wheels[1:])
    cure = "leave these columns out, the model turns the wheels then: one speed shows no wheel's slip" if same else ""
    found = "one speed for all four in turns" if same else "four speeds"
    return [Check("wheel_sensors", "wheels", not same, found, "a sensor for each wheel", cure)]


def side_checks(m: Motion, geometry: Geometry) -> list[Check]:
    """Right wheel less left wheel of an axle: track omega_z by rolling, less what the lighter, inner wheel slips, ~ u^2 omega_z.

    The first share is 0 on a locked axle and 1 or more on an open one, never below: there left and right are swapped.
    geometry: tracks and radius.
    """
    checks = []
    turning, speed = m.mean(m.channel("omega_z")), m.speed
    for axle, track in (("f", geometry.track), ("r", geometry.rear_track)):
        left, right = m.channel(f"omega_{axle}l"), m.channel(f"omega_{axle}r")
        apart = m.driven(radius_of(geometry, f"omega_{axle}l") * (m.mean(right) - m.mean(left)))
        line = regress(apart, track * turning, speed**2 * turning / GRAVITY, np.ones(m.windows))
        if line is None or not line.std[0] < 0.25:
            continue
        value, std = float(line.value[0]), float(line.std[0])
        wrong = value < -0.4 and value < -LIMITS.sigmas * std
        names = f"omega_{axle}l, omega_{axle}r"
        found = f"{value:+.2f} ± {std:.2f} of it"
        expected = "a right wheel that is faster than the left one in a left turn (track omega_z)"
        cure = "left and right wheels swapped?" if wrong else ""
        checks.append(Check(f"wheel_sides_{axle}", names, not wrong, found, expected, cure, wrong))
    return checks


def steering_checks(m: Motion, geometry: Geometry) -> list[Check]:
    """L omega_z/u = g steer over windows, g in (0, 1] on ground that gives way: its sign, and its size against units.

    Correlations are taken within 1 s of delay: a steering that lags is an effect, not a contradiction. Of a drive to one side,
    a circle, they are taken about zero: what varies there is what a driver corrects, against the turning. geometry: wheelbase.
    """
    reach = round(0.5 / m.log.dt)
    steer, omega = (interpolated(m.channel(name), reach) for name in ("steer", "omega_z"))
    speed = np.where(m.speed > 0.5, m.speed, np.nan)
    wheelbase = geometry.l_f + geometry.l_r
    delta, turning = m.driven(m.mean(steer)), wheelbase * m.mean(omega) / m.driven(speed)
    good = np.isfinite(delta) & np.isfinite(turning)
    if good.sum() < 12 or np.nanstd(turning[good]) < 0.005:
        return []
    delta, turning = delta[good], turning[good]
    one_sided = all(abs(np.mean(x)) > np.std(x) for x in (delta, turning))
    name, expected = ("steer_yaw_rate", "steer"), "a yaw rate that follows the steering angle, L omega_z/u = gain steer"
    if np.std(delta) < 1e-6 and not one_sided:
        found = f"a constant angle of {np.median(delta):.4f} rad while the path's curvature varies"
        return [Check(*name, False, found, "a steering angle that turns the vehicle", "map another column to steer", True)]
    correlation = [lagged(delta, turning, lag, one_sided) for lag in range(-2, 3)]
    best, worst = max(correlation), min(correlation)
    gain = float(np.sqrt(np.mean(turning**2) / np.mean(delta**2)) if one_sided else np.std(turning) / np.std(delta))
    found = f"correlation {correlation[2]:+.2f} ({best:+.2f} at best within 1 s), gain {gain:.3f}"
    if worst < -0.6 and best < max(0.3, 0.5 * abs(worst)):  # a short wave fits a little again within 1 s
        cure = "sign = -1 for steer (positive to the left), or its clock is off by a second or more"
        return [Check(*name, False, found, expected, cure, True)]
    low, high = LIMITS.steer_gain
    if best > 0.6 and not low <= gain <= high:
        hint = unit_hint("steer", 1.0 / gain) or " (the angle of the steering wheel? give ratio)"
        return [Check(*name, False, found, f"{expected}, gain {low:g} to {high:g}", f"correct the unit of steer{hint}", True)]
    if best < 0.6:
        cure = "steer does not explain the turning: another column, clock or vehicle?"
        return [Check(*name, False, found, expected, cure, best < 0.15)]
    return [Check(*name, True, found, expected)]


def turned_over(steering: list[Check], sides: list[Check]) -> list[Check]:
    """The checks of the steering, with another cure where steering and wheels agree on the side and the motion does not.

    steering: of `steering_checks`; sides: of `side_checks`.
    """
    against = [check for check in steering if "sign = -1 for steer" in check.cure]
    if not against or not sides or not all(check.beyond_doubt for check in sides):
        return steering
    cure = 'y, psi, v, omega_z, a_y_imu are positive to the right (z down)? frame = "z-down" in their [mount], or sign = -1'
    return [replace(check, cure=cure, channel="omega_z") if check in against else check for check in steering]
