"""Heading against yaw rate, accelerometer against velocities, position against velocities: rigid-body kinematics alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from softsoil.checking.lateral import lateral_rate_checks
from softsoil.checking.scale import scale_check
from softsoil.checking.words import LIMITS, Check
from softsoil.recording.drive import Array
from softsoil.recording.evidence import MOSTLY, Line, Motion, interpolated, regress
from softsoil.recording.geometry import Geometry
from softsoil.recording.laid_heading import SCATTERED, laid_heading
from softsoil.recording.plausible import against

SLOPE, FEWEST = 4, 8
"""Samples in a window that make a slope, and those of a slow heading from which on it is compared from one to the next."""
MOST_SCALE = 0.2
"""Departure of a gyro's scale from 1 up to which it may be one."""
COARSE = 0.5
"""1/s^2: share that straight lines between samples take off the integral of a yaw rate, over dt^2 (1.2 % at 5 Hz)."""
TURNS = 0.1
"""rad: spread of the heading from which on a velocity along the vehicle's axes cannot be taken for one along the world's."""
ALONG = 0.9
"""Share of the rates of x and y that velocities along the world's axes explain at least; the rest is the front axle's turning."""
SURE_SIGN = 0.3
"""Scale of the yaw rate beyond whose negative its sign is wrong, or that of the heading; the steering tells which."""
ROLLING = 1.3
"""Scale of the lateral accelerometer up to which the body's roll may make it: 10 degrees per g are 1.17."""
SLIDING = 0.75
"""Share of u omega_z that dv/dt may take back while a vehicle slides: where v is not measured, a smaller departure of the lateral
accelerometer's scale from 1 is no evidence (0.59 was met on clay, at full lock)."""

LAID_BIAS = 0.01
"""rad/s: doubtful bias of a yaw rate by the course of positions."""
MIRRORED = 0.998
"""Length of the mean direction of positions below which they may be mirrored."""


def heading_checks(m: Motion) -> list[Check]:
    """d psi/dt = omega_z: sign, scale and bias of the gyro."""
    turned, expected, seconds = _turns(m)
    if np.nansum(expected**2 * seconds) < 0.1:
        return []
    line = regress(turned, expected, np.ones_like(turned))
    steady = line is not None and line.r2 < 0.3 and abs(np.nanmean(expected)) > np.nanstd(expected)
    if steady:  # a circle: nothing varies but noise, and the mean says what the scale is
        line = regress(turned, expected)
    if line is None:
        return []
    if line.r2 < 0.3 and not steady:
        found = f"r^2 = {line.r2:.2f} between the heading's rate and the yaw rate"
        words = "a heading that turns as the yaw rate says"
        return [Check("yaw_rate_heading", "psi", False, found, words, "map another column to psi or omega_z", True)]
    if line.value[0] < -SURE_SIGN and m.log.measured("steer") and against("steer", m.log.channels):
        words, found = "a yaw rate that turns as the heading and the steering say", f"a scale of {line.value[0]:.3f}"
        cure = 'sign = -1 for omega_z; of an inertial sensor that hangs upside down frame = "z-down" in its [mount]'
        return [Check("yaw_rate_heading", "omega_z", False, found, words, cure, True)]
    checks = [
        scale_check(
            "yaw_rate_heading",
            "psi",
            line,
            0,
            "a heading that turns as the yaw rate says (scale 1)",
            f"factor = {line.value[0]:.3f} for omega_z, a gyro's scale, or correct the unit of psi"
            if abs(line.value[0] - 1.0) < MOST_SCALE
            else 'a yaw rate in degrees: unit = "deg/s" for omega_z, else correct psi'
            if 0.9 < line.value[0] * 180.0 / np.pi < 1.1
            else "correct the unit or the scale of psi or omega_z",
            LIMITS.turn + COARSE * m.log.dt**2,
        )
    ]
    if checks[0].passed and not steady:
        checks.append(_bias("yaw_rate_bias", "omega_z", -float(line.value[1]), float(line.std[1]), LIMITS.gyro, "rad/s"))
    return checks


def _turns(m: Motion) -> tuple[Array, Array, Array]:
    """Rate of the heading (K,) and what the yaw rate says of it, each (rad/s), over so many seconds (K,): over windows, or from
    sample to sample of a heading that is too slow for them."""
    psi, turned = m.channel("psi"), m.integral(m.channel("omega_z"))
    at = np.flatnonzero(np.isfinite(psi))
    if len(at) >= SLOPE * m.windows or len(at) < FEWEST:
        return m.slope(psi), m.slope(turned, psi), np.full(m.windows, m.size * m.log.dt)
    at = at[:: int(np.ceil(m.size / np.median(np.diff(at))))]  # as far from each other as a window is long, or farther
    seconds = np.diff(at) * m.log.dt
    return np.diff(psi[at]) / seconds, np.diff(turned[at]) / seconds, seconds


def _bias(name: str, channel: str, value: float, std: float, limit: float, unit: str) -> Check:
    doubtful = abs(value) > max(limit, LIMITS.sigmas * std)
    cure = (
        f"offset = {-value:.4g} for {channel}{' (or the ground is sloped)' if channel.startswith('a_') else ''}"
        if doubtful
        else ""
    )
    found = f"a bias of {value:+.4f} ± {std:.4f} {unit}"
    return Check(name, channel, not doubtful, found, f"no bias beyond {limit:g} {unit}", cure)


def inertial_checks(m: Motion) -> list[Check]:
    """a_x = du/dt - v omega_z and a_y = dv/dt + u omega_z (specific force): sign, scale and bias of the accelerometer."""
    reach = round(0.5 / m.log.dt)
    u, v, omega = (interpolated(m.channel(name), reach) for name in ("u", "v", "omega_z"))
    has_v = bool(np.isfinite(v).any())
    swept = np.where(np.isfinite(v), v, 0.0) if not has_v else v
    one = np.ones(m.windows)
    checks: list[Check] = []
    a_x, a_y = (interpolated(m.channel(name), reach) for name in ("a_x_imu", "a_y_imu"))
    turning = m.slope(m.integral(u * omega))
    ahead = m.slope(u) - m.slope(m.integral(swept * omega))
    aside = (m.slope(v) if has_v else 0.0) + turning
    force_x, force_y = m.slope(m.integral(a_x)), m.slope(m.integral(a_y))
    for name, channel, force, expected, other in (
        ("accelerometer_x", "a_x_imu", force_x, ahead, force_y),
        ("accelerometer_y", "a_y_imu", force_y, aside, force_x),
    ):
        words = "du/dt - v omega_z (scale 1)" if channel == "a_x_imu" else "dv/dt + u omega_z (scale 1)"
        expected = m.driven(expected)
        if not (np.isfinite(force).any() and np.isfinite(expected).any()) or np.nanstd(expected) < 0.3:
            continue
        line, crossed = regress(force, expected, one), regress(other, expected, one)
        if line is None:
            continue
        rated = "u" if channel == "a_x_imu" else "v"
        line = line.unattenuated(0, m.slope_noise(rated) / float(np.nanvar(expected)))
        if channel == "a_y_imu" and not has_v:
            line = replace(line, bias=np.array([SLIDING, 0.0]))
        if crossed is not None and line.r2 < 0.3 and crossed.r2 > 0.8 and abs(crossed.value[0]) > 0.5:
            found = f"r^2 = {line.r2:.2f}, while the other axis of the accelerometer has {crossed.r2:.2f}"
            checks.append(
                Check(
                    name, channel, False, found, words, "swap a_x_imu and a_y_imu, or turn the mounting by 90 deg", True
                )
            )
            continue
        if line.r2 < 0.3 and not has_v:
            continue
        rolls = channel == "a_y_imu" and 1.0 < line.value[0] < ROLLING
        cure = f"correct sign, unit or axis of {channel}{'; or it rolls with the body and sees its weight' if rolls else ''}"
        checks.append(scale_check(name, channel, line, 0, words, cure))
        if checks[-1].passed:
            checks.append(
                _bias(f"{name}_bias", channel, float(line.value[1]), float(line.std[1]), LIMITS.accelerometer, "m/s^2")
            )
    rate = m.driven(m.slope(v))
    if np.isfinite(rate).any() and np.isfinite(force_y).any() and np.nanstd(rate) > 0.05:
        checks += lateral_rate_checks(m, force_y, u, v, omega)
    return checks


def pose_checks(m: Motion, geometry: Geometry) -> list[Check]:
    """Velocity from positions, in the heading's frame, against (u, v + l omega_z): speed scale, heading, v and reference point.

    The regression is rotate(-psi) d(x, y)/dt = s (u, 0) + b (0, u) + a (0, v) + l (0, omega_z) over windows of all headings.
    """
    x, y = m.channel("x"), m.channel("y")
    reach = round(0.5 / m.log.dt)
    psi, u, v, omega = (interpolated(m.channel(name), reach) for name in ("psi", "u", "v", "omega_z"))
    if not (np.isfinite(x).any() and np.isfinite(psi).any()):
        return _without_heading(m, geometry)
    has_v = bool(np.isfinite(v).any())
    v = v if has_v else np.zeros_like(u)
    cos, sin = np.cos(psi), np.sin(psi)
    middle = np.unwrap(np.nan_to_num(m.mean(psi)))
    c, s = np.cos(middle), np.sin(middle)

    def turned(ahead: Array, aside: Array) -> tuple[Array, Array]:
        """Slopes of the path that (ahead, aside) in the body frame makes, in the frame of the window's mean heading."""
        path_x, path_y = m.integral(ahead * cos - aside * sin), m.integral(ahead * sin + aside * cos)
        rate_x, rate_y = m.slope(path_x, x), m.slope(path_y, y)
        return c * rate_x + s * rate_y, -s * rate_x + c * rate_y

    zero = np.zeros_like(u)
    moved_x, moved_y = m.slope(x), m.slope(y)
    moved = (m.driven(c * moved_x + s * moved_y), m.driven(-s * moved_x + c * moved_y))
    parts = [turned(u, zero), turned(zero, u), turned(zero, omega)] + ([turned(zero, v)] if has_v else [])
    if has_v and _of_the_world(m, middle, (moved_x, moved_y), (u, v)):
        found, words = "the rates of x and y", "velocities along the vehicle's axes"
        cure = "they are given in the world's frame: map the twist of the vehicle's own frame, or a speed to u and nothing to v"
        return [Check("velocity_frame", "u, v", False, found, words, cure, True)]
    course = _course(moved, parts[0])
    if course is not None and not course.passed:
        return [course]
    features = [np.concatenate(part) for part in parts]
    line = regress(np.concatenate(moved), *features)
    if line is None:
        return []
    line = line.disturbed(_sway(m))
    mirrored = _mirrored(m, (moved_x, moved_y), (c, s), features, line)
    if mirrored is not None:
        return [mirrored]
    checks = [] if course is None else [course]
    ahead = regress(moved[0], parts[0][0])
    if ahead is not None:
        slope = max(float(ahead.value[0]), 1e-9)
        inverse = replace(ahead, value=np.array([1.0 / slope]), std=ahead.std / slope**2)
        checks.append(
            scale_check(
                "speed_position",
                "u",
                inverse,
                0,
                "a speed as the positions move (scale 1)",
                "correct unit or scale of u",
            )
        )
    heading, heading_std = float(line.value[1]), float(line.std[1])
    doubtful = abs(heading) > max(LIMITS.heading, LIMITS.sigmas * heading_std)
    checks.append(
        Check(
            "heading_course",
            "psi",
            not doubtful,
            f"course less heading and side slip {heading:+.4f} ± {heading_std:.4f} rad",
            "a heading along the vehicle's axis (0 rad)",
            f"offset = {heading:.4f} for psi (mounting angle)" if doubtful else "",
        )
    )
    if has_v:
        noise = m.mean_noise("v") / max(float(line.alone[3]) ** 2, 1e-12)
        checks.append(
            scale_check(
                "lateral_velocity",
                "v",
                line.only(3).unattenuated(0, noise),
                0,
                "a lateral velocity as course minus heading says (scale 1)",
                "correct sign, unit or place of v",
                LIMITS.lateral,
            )
        )
        if noise > MOSTLY:  # v as it is: fitted, its noise would leave its part to the arm
            trusted = regress(np.concatenate(moved) - features[3], *features[:3])
            line = line if trusted is None else trusted.disturbed(_sway(m))
        away, std = float(line.value[2]) - geometry.l_f, float(line.std[2])
        doubtful = abs(away) > max(LIMITS.reference, LIMITS.sigmas * std, float(line.bias[2]))
        checks.append(
            Check(
                "reference_point",
                "x, y",
                not doubtful,
                f"a point {away:+.2f} ± {std:.2f} m ahead of the front axle",
                "the position of the front axle",
                f"give the antenna's place in [mount]; or v's, if that is of a point {abs(away):.2f} m "
                f"{'ahead of' if away < 0.0 else 'behind'} the centre of gravity" if doubtful else "",
            )
        )
    return checks


def _sway(m: Motion) -> float:
    """Root mean square velocity (m/s) of a position sensor that body roll and its own wander make, over both directions."""
    force = m.channel("u") * m.channel("omega_z")
    return float(np.hypot(LIMITS.still, LIMITS.sway * np.sqrt(0.5 * np.nanmean(m.driven(m.slope(force)) ** 2))))


def _of_the_world(m: Motion, heading: Array, moved: tuple[Array, Array], velocity: tuple[Array, Array]) -> bool:
    """Whether the velocity's components are the rates of x and y, although the heading (K,) turns away from x."""
    if np.nanstd(heading) < TURNS:
        return False
    lines = [regress(m.mean(one), rate, np.ones(m.windows)) for one, rate in zip(velocity, moved, strict=True)]
    return all(line is not None and line.r2 > ALONG and 0.8 < line.value[0] < 1.25 for line in lines)


def _mirrored(
    m: Motion, rates: tuple[Array, Array], heading: tuple[Array, Array], features: list[Array], line: Line
) -> Check | None:
    """A contradiction where positions with an axis flipped or swapped fit the velocities far better."""
    c, s = heading
    for words, (east, north) in (
        ("sign = -1 for y", (rates[0], -rates[1])), ("sign = -1 for x", (-rates[0], rates[1])), ("swap x and y", rates[::-1]),
    ):  # fmt: skip
        other = regress(np.concatenate((m.driven(c * east + s * north), m.driven(-s * east + c * north))), *features)
        if other is not None and other.scale < 0.3 * line.scale and other.scale < 0.5:
            found = f"{line.scale:.2f} m/s between positions and velocities, {other.scale:.2f} m/s with {words}"
            return Check(
                "course_heading", "x, y", False, found, "positions that move where the heading points", words, True
            )
    return None


def _course(moved: tuple[Array, Array], ahead: tuple[Array, Array]) -> Check | None:
    """Direction of motion against the heading, as a mean direction: mirrored or swapped axes and wrong frames leave none."""
    angle = np.arctan2(moved[1], moved[0]) - np.arctan2(ahead[1], ahead[0])
    size = np.hypot(*moved)
    good = np.isfinite(angle) & (size > 0.5)
    if good.sum() < 8:
        return None
    mean = np.mean(np.exp(1j * angle[good]))
    length, offset = float(abs(mean)), float(np.angle(mean))
    expected = "positions that move where the heading points"
    if length < SCATTERED:
        found = f"directions of motion that scatter about the heading (mean direction {length:.2f} long, 1 for a rigid body)"
        cure = "x and y swapped, one of them flipped, or a compass heading? sign = -1, compass = true, or swap"
        return Check("course_heading", "x, y, psi", False, found, expected, cure, True)
    if abs(offset) > LIMITS.wrong_heading:
        found = f"motion {offset:+.2f} rad off the heading"
        cure = f"offset = {offset:.3f} for psi, or another frame (compass = true), or u backwards"
        return Check("course_heading", "psi", False, found, expected, cure, True)
    return Check("course_heading", "psi", True, f"motion {offset:+.3f} rad off the heading on the mean", expected)


def _without_heading(m: Motion, geometry: Geometry) -> list[Check]:
    """Positions without a heading: distance against speed, and the way that they turn against the yaw rate."""
    x, y = m.channel("x"), m.channel("y")
    if not np.isfinite(x).any():
        return []
    checks = _direction(m, x, y, geometry)
    speed = np.hypot(m.slope(x), m.slope(y))
    line = regress(m.driven(m.speed), m.driven(speed))
    if line is None:
        return checks
    return [
        *checks,
        scale_check("speed_position", "u", line, 0, "a speed as the positions move (scale 1)", "correct unit or scale of u"),
    ]


def _direction(m: Motion, x: Array, y: Array, geometry: Geometry) -> list[Check]:
    """Positions that turn as the yaw rate says; mirrored ones turn the other way."""
    u, v, omega = (np.nan_to_num(interpolated(m.channel(name), round(1.0 / m.log.dt))) for name in ("u", "v", "omega_z"))
    laid = laid_heading(x, y, u, v + geometry.l_f * omega, omega, m.log.dt)
    if laid is None:
        return []
    expected = "positions that turn as the yaw rate says"
    other = 1.0 - laid.mirrored < 0.1 * (1.0 - laid.agreement) and laid.agreement < MIRRORED
    if other or laid.scattered:
        found = f"a mean direction {laid.agreement:.2f} long, 1 for a rigid body; {laid.mirrored:.2f} with one axis turned round"
        cure = "sign = -1 for x or for y, or swap them" if other else "positions of another time, or a yaw rate that is none"
        return [Check("course_heading", "x, y", False, found, expected, cure, True)]
    checks = [Check("course_heading", "x, y", True, f"a mean direction {laid.agreement:.2f} long", expected)]
    if abs(laid.bias) > LAID_BIAS:
        found, cure = f"a bias of {laid.bias:+.3f} rad/s by the positions' course", f"offset = {-laid.bias:.3f} for omega_z"
        checks.append(Check("yaw_rate_bias", "omega_z", False, found, f"no bias beyond {LAID_BIAS:g} rad/s", cure))
    return checks
