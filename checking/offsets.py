"""Time offsets between the channels of a drive, estimated from physics within +-REACH seconds.

Each comparison has a channel that may be late, y(t + tau), and what the others say it must be: heading rate against the gyro,
speed against the accelerometer, the wheels' difference in turns against the gyro, course against heading, and the steering angle
against the motion that it causes. The last one is the front axle's force balance: delta = arctan((v + l_f omega_z)/u) + C(F, s),
F = a_y + k^2/l_r d(omega_z)/dt per mass (k: radius of gyration), s: slip of the wheels and C odd in F: the lateral force follows
the slip angle at once, while the yaw rate itself lags.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.checking.speed import over_ground
from softsoil.recording.clock import on_even_clock, unwrapped
from softsoil.recording.drive import WHEEL_CHANNELS, Array, Recording
from softsoil.recording.evidence import SLOWEST, SPIKE, interpolated, lagged
from softsoil.recording.geometry import Geometry, radius_of
from softsoil.recording.noise_level import noise_level

REACH = 2.0
"""s: largest offset that is looked for."""
STEP = 0.02
"""s: clock of the comparison; the best offset is interpolated between its steps."""
SMOOTHING = 0.15
"""s: moving mean over all signals before they are compared, the same for both sides."""
SYSTEMATIC = {"steer": 0.02, "psi": 0.005, "position": 0.01, "u": 0.01, "wheels": 0.2}
"""s: what the comparison itself is off by on drives with one clock (steer: 0.00 to 0.02 on multi-sine drives of two vehicles)."""
LEFT_BY_STEER = 0.03
"""Share of the steering's variance that its best offset leaves at most on the drives behind its SYSTEMATIC (good sensors); where
more is left, by noise or since the wheels follow another law, the offset is as much less certain."""
UNMODELLED = {"u": 0.15, "psi": 0.003, "position": 0.005, "wheels": 0.01}
"""What may be in a comparison for a second at a time: m/s^2 of an accelerometer that pitches and shakes, rad/s of the others."""
ALIKE = {"wheels": 0.2, "u": 0.1}
"""Share of what is explained by which two offsets must differ not to fit alike, 0.02 where a group is not named."""
LEFT_ALIKE = 0.25
"""Share of what is left by which they must: full-lock drives repeat themselves, and with one clock an offset of one period leaves
0.88 to 0.90 of what none leaves (2 of 50 drives of ten drawn vehicles)."""
CHANCE = 3.0
"""Standard deviations by which what is left at two offsets must differ, too, by as many independent samples as the residual has:
on 10 of 301 pieces of 10 and 13 s (five vehicles, good sensors) noise alone made positions a period off fit better."""
LEAD = {"wheels": -0.15, "steer": -0.01}
"""s: by how much a channel leads what it is compared with on one clock: inner and outer wheels slip differently, and their
difference lags the yaw rate by -0.1 to 0.4 s (58 drives of three vehicles); the steering lags the force balance by 0.007 to
0.011 s (4 multi-sine drives of the reference vehicle; a yaw inertia that is 10 % too large adds 0.008 s)."""
WITHOUT_V = {True: (0.025, 0.04), False: (0.11, 0.1)}
"""Whether there is an accelerometer -> (s that the steering leads further, s of further standard error), where v is not measured
and the rear axle's slip angle is put for it: 0.00 to 0.07 and 0.04 to 0.19 s on 11 drives of the reference vehicle."""
MOST_ROWS = 60_000
"""Rows of a long drive that are compared: its middle 20 minutes."""
JUMP = 6.0
"""Standard deviations of its noise by which a speed moves from one sample to the next, beyond what any vehicle accelerates, where
two records are joined or a receiver has jumped."""
FAR, EXPLAINED = 0.25, 0.9
"""s: a larger offset has to explain its channel with this correlation."""
LEAST_R2 = {"wheels": 0.8}
"""Share of the variance that the best offset must explain, 0.5 where a group is not named; below it no offset is given."""


@dataclass(frozen=True)
class Offset:
    """By how much a group of channels is late.

    group: steer, psi, position, u or wheels; against: what it was compared with; late_s: how late its clock is (s, negative:
    early); std: standard error (s), the systematic part included; before, after: correlation without and with the shift.
    """

    group: str
    against: str
    late_s: float
    std: float
    before: float
    after: float

    @property
    def trusted(self) -> bool:
        """Whether it may be a clock: a large offset that explains its channel badly is a wrong sign or unit."""
        return abs(self.late_s) <= FAR or self.after > EXPLAINED


def time_offsets(recording: Recording, geometry: Geometry) -> tuple[Offset, ...]:
    """The offsets that a drive's measured channels allow; geometry: of the vehicle.

    Groups whose partners are not measured, or which hardly move, are left out, and all but psi where the yaw rate has the other
    sign: they rest on it.
    """
    c = _Clocked.of(recording)
    heading = _rate_of_heading(c)
    if heading is not None and lagged(c.rate("psi"), c["omega_z"], round(heading.late_s / c.dt)) < 0.0:
        return (heading,)
    found = [
        heading,
        _speed(c) if over_ground(recording, geometry) else None,  # wheel odometry departs from the accelerometer by its slip
        _wheels(c, geometry),
        _position(c, geometry),
        _steering(c, geometry),
    ]
    return tuple(offset for offset in found if offset is not None)


@dataclass(frozen=True)
class _Clocked:
    """Measured channels on a clock of STEP seconds, smoothed; rate(name): their slopes; period: of each channel (s)."""

    dt: float
    channels: dict[str, Array]
    period: dict[str, float]

    @classmethod
    def of(cls, recording: Recording) -> _Clocked:
        log = on_even_clock(recording)
        dt = max(STEP, log.dt)
        clock = np.arange(log.t[0], log.t[-1], dt)
        if len(clock) > MOST_ROWS:
            first = (len(clock) - MOST_ROWS) // 2
            clock = clock[first : first + MOST_ROWS]
        reach, size = max(round(0.5 / log.dt), 3), max(round(SMOOTHING / log.dt), 1)
        out, period = {}, {}
        joined = _jumps(log, size)
        for name in log.channels:
            if name == "t" or not log.measured(name):
                continue
            values = log[name]
            if name.startswith("a_"):
                values = np.where(np.abs(values) > SPIKE, np.nan, values)
            values = unwrapped(name, values)
            known = np.flatnonzero(np.isfinite(values))
            period[name] = float(np.median(np.diff(known))) * log.dt if len(known) > 2 else np.inf
            filled = _mean(np.where(joined, np.nan, interpolated(values, reach)), size)
            out[name] = np.interp(clock, log.t, filled)
        return cls(dt, out, period)

    def has(self, *names: str) -> bool:
        return all(name in self.channels for name in names)

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def rate(self, name: str) -> Array:
        return _mean(np.gradient(self.channels[name], self.dt), max(round(SMOOTHING / self.dt), 1))

    @property
    def driving(self) -> Array:
        """1 where the vehicle drives forwards, NaN elsewhere."""
        u = self.channels.get("u")
        return np.ones(1) if u is None else np.where(u > SLOWEST, 1.0, np.nan)


def _jumps(log: Recording, size: int) -> NDArray[np.bool_]:
    """(N,) samples within `size` samples of a jump of a speed: across it no slope means anything, and a few would decide."""
    found = np.zeros(len(log), dtype=bool)
    for name in ("u", "v"):
        if log.measured(name):
            at = np.flatnonzero(np.isfinite(log[name]))
            moved, apart = np.abs(np.diff(log[name][at])), np.diff(at) * log.dt
            found[at[1:][moved > SPIKE * apart + JUMP * noise_level(log[name], log.dt).rough]] = True
    return np.convolve(found, np.ones(2 * size + 1), mode="same") > 0.5


def _mean(values: Array, size: int) -> Array:
    """Centred moving mean over an odd number of samples; NaN where one of them is."""
    size = size // 2 * 2 + 1
    padded = np.pad(values, size // 2, mode="edge")
    bad = np.isnan(padded)
    total = np.cumsum(np.concatenate([[0.0], np.where(bad, 0.0, padded)]))
    count = np.cumsum(np.concatenate([[0], bad]))
    out = (total[size:] - total[:-size]) / size
    return np.where(count[size:] - count[:-size] > 0, np.nan, out)


def _rate_of_heading(c: _Clocked) -> Offset | None:
    if not c.has("psi", "omega_z"):
        return None
    return best_offset("psi", "yaw rate", c.rate("psi"), np.zeros_like(c["psi"]), [c["omega_z"]], c.dt)


def _speed(c: _Clocked) -> Offset | None:
    if not c.has("u", "a_x_imu", "omega_z"):
        return None
    v = c["v"] if c.has("v") else np.zeros_like(c["u"])
    return best_offset("u", "accelerometer", c.rate("u"), np.zeros_like(v), [c["a_x_imu"] + v * c["omega_z"]], c.dt)


def _wheels(c: _Clocked, geometry: Geometry) -> Offset | None:
    """By the wheels' difference in turns: against the speed, slip that follows the acceleration looks like another clock. None
    where it fits turned over, as half a period of a steady slalom later."""
    if not c.has(*WHEEL_CHANNELS, "omega_z"):
        return None
    left_f, right_f, left_r, right_r = (c[name] for name in WHEEL_CHANNELS)
    front, rear = geometry.radius / geometry.track, geometry.rear_radius / geometry.rear_track
    turning = 0.5 * (front * (right_f - left_f) + rear * (right_r - left_r))
    found = best_offset("wheels", "yaw rate", turning, np.zeros_like(turning), [c["omega_z"]], c.dt)
    if found is None:
        return None
    same = lagged(turning, c["omega_z"], round((found.late_s - LEAD["wheels"]) / c.dt))
    return found if same > 0.0 else None


def _position(c: _Clocked, geometry: Geometry) -> Offset | None:
    if not c.has("x", "y", "psi", "u", "v", "omega_z"):  # without v, side slip would be taken for an offset
        return None
    slow = max(c.period["x"], c.period["psi"])
    size = max(round(max(SMOOTHING, 3.0 * slow) / c.dt), 1)
    rates = [np.gradient(_mean(c[name], size), c.dt) for name in ("x", "y")]
    course = np.arctan2(_mean(rates[1], size), _mean(rates[0], size))
    course[np.isfinite(course)] = np.unwrap(course[np.isfinite(course)])
    slip = np.arctan2(c["v"] + geometry.l_f * c["omega_z"], np.maximum(c["u"], SLOWEST))
    expected = _mean(_mean((c["psi"] + slip) * c.driving, size), size)
    # Rates, so that a lap does not count as a trend.
    turning = [_mean(np.gradient(values, c.dt), size) for values in (course * c.driving, expected)]
    found = best_offset("position", "heading", turning[0], np.zeros_like(course), [turning[1]], c.dt)
    return None if found is None else replace(found, std=float(np.hypot(found.std, slow / 4)))


def _steering(c: _Clocked, geometry: Geometry) -> Offset | None:
    if not c.has("steer", "u", "omega_z"):
        return None
    u = np.where(c["u"] > SLOWEST, c["u"], np.nan)
    gyration = geometry.yaw_inertia / geometry.mass
    turning = c.rate("omega_z")
    if c.has("v"):
        course = np.arctan((c["v"] + geometry.l_f * c["omega_z"]) / u)
        a_y = c["u"] * c["omega_z"] + c.rate("v")
        force = a_y + gyration / geometry.l_r * turning
        features = [force, force**3]
        names = [name for name in WHEEL_CHANNELS if c.has(name)]
        if names:  # a wheel that slips needs a larger slip angle for the same force
            rim = np.mean([radius_of(geometry, name) * c[name] for name in names], axis=0)
            slip = 1.0 - u / np.maximum(rim, SLOWEST)
            features += [force * slip, force * slip**2]
        return best_offset("steer", "front axle's motion", c["steer"], course, features, c.dt)
    # Without lateral velocity the rear axle's slip stands in: (v - l_r omega_z)/u falls with its force.
    a_y = c["a_y_imu"] if c.has("a_y_imu") else c["u"] * c["omega_z"]
    front, rear = a_y + gyration / geometry.l_r * turning, a_y - gyration / geometry.l_f * turning
    course = (geometry.l_f + geometry.l_r) * c["omega_z"] / u
    found = best_offset("steer", "front axle's motion", c["steer"], course, [front, front**3, rear], c.dt)
    lead, std = WITHOUT_V[c.has("a_y_imu")]
    return found and replace(found, late_s=found.late_s + lead, std=float(np.hypot(found.std, std)))


def best_offset(
    group: str, against: str, late: Array, known: Array, features: Sequence[Array], dt: float
) -> Offset | None:
    """The offset tau that makes late(t + tau) = known + features best, least squares with a constant.

    group, against: as of Offset; late, known and each feature (N,): on a clock of dt (s). None where nothing is explained.
    """
    reach = round(REACH / dt)
    count = len(late)
    if count < 4 * reach:
        return None
    inner = slice(reach, count - reach)
    columns = np.column_stack([np.ones(count), *features])[inner]
    usable = np.isfinite(columns).all(axis=1) & np.isfinite(known[inner])
    good = np.isfinite(late)
    if usable.sum() < reach or good.sum() < reach or np.std(late[good]) < 1e-9:
        return None
    filled = np.interp(np.arange(count), np.flatnonzero(good), late[good])
    q = np.linalg.qr(columns[usable])[0]
    lags = np.arange(-reach, reach + 1)
    base = known[inner][usable]
    rest, total = np.empty(len(lags)), np.empty(len(lags))
    for i, lag in enumerate(lags):
        shifted = filled[reach + lag : count - reach + lag][usable]
        y = shifted - base
        rest[i], total[i] = float(y @ y - np.sum((q.T @ y) ** 2)), float(np.var(shifted)) * len(shifted)
    if not np.median(total) > 0.0:  # nothing of it lies where the others are known
        return None
    left = rest / np.median(total)
    # A repeated manoeuvre fits again a period later: of offsets that fit alike, the smallest.
    y = filled[reach + lags[left.argmin()] : count - reach + lags[left.argmin()]][usable] - base
    chance = 2.0 * CHANCE / np.sqrt(_independent(y - q @ (q.T @ y)))
    level = left.min() + max(ALIKE.get(group, 0.02) * (1.0 - left.min()), max(LEFT_ALIKE, chance) * left.min())
    valleys = [i for i in range(len(left)) if left[i] <= level and left[i] == left[max(i - 5, 0) : i + 6].min()]
    best = min(valleys, key=lambda i: abs(lags[i]))
    away = 0.0
    if 0 < best < len(left) - 1:
        bend = left[best - 1] - 2 * left[best] + left[best + 1]
        away = 0.5 * (left[best - 1] - left[best + 1]) / bend if bend > 0 else 0.0
    # Each offset against its own variance: an outlier of the channel lies in some of them only.
    before, after = (1.0 - rest[i] / max(total[i], 1e-300) for i in (reach, best))
    if not after >= LEAST_R2.get(group, 0.5):
        return None
    error = _error(filled, base, q, usable, reach, int(lags[best]), dt, UNMODELLED.get(group, 0.0))
    if not np.isfinite(error):
        return None
    more = max(np.sqrt(max(left[best], 0.0) / LEFT_BY_STEER), 1.0) if group == "steer" else 1.0
    std = float(np.hypot(error, more * SYSTEMATIC.get(group, 0.02)))
    late_s = float((lags[best] + away) * dt) + LEAD.get(group, 0.0)
    return Offset(group, against, late_s, std, float(np.sqrt(max(before, 0.0))), float(np.sqrt(after)))


def _error(
    late: Array, base: Array, q: Array, usable: NDArray[np.bool_], reach: int, lag: int, dt: float, unmodelled: float
) -> float:  # fmt: skip
    """Standard error of the offset: residual over slope, with the residual's own correlation in time.

    What the samples say of the offset is the product of two slopes, of the channel and of what the features explain: their noises
    are independent, while the square of one would count its noise as motion. Infinite where they have no motion in common.
    unmodelled: root mean square, in the channel's unit, of what may be in it beside the features for a second at a time.
    """
    count = len(late)
    channel = late[reach + lag : count - reach + lag][usable]
    explained = q @ (q.T @ (channel - base))
    residual, slope = channel - base - explained, np.gradient(base + explained, dt)
    slope = slope - q @ (q.T @ slope)
    square = float(np.gradient(channel, dt) @ slope)
    if not square > 0.0:
        return np.inf
    power = float(residual @ residual) / _independent(residual) * max(float(slope @ slope), square) / square
    return float(np.sqrt((power + unmodelled**2 * max(1.0 / dt, 1.0)) / square))


def _independent(residual: Array) -> float:
    """How many independent samples a residual (N,) has, by its own correlation in time."""
    power = float(residual @ residual) + 1e-300
    correlation = 1.0
    for k in range(1, min(200, len(residual) // 4)):
        rho = float(residual[k:] @ residual[:-k]) / power
        if rho < 0.05:
            break
        correlation += 2.0 * rho
    return len(residual) / correlation
