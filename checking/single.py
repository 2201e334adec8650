"""Sensors that freeze or saturate, and drives that do not move or steer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from softsoil.checking.words import LIMITS, Check
from softsoil.recording.drive import WHEEL_CHANNELS, Array
from softsoil.recording.evidence import SLOWEST, Motion, interpolated

WATCHED = ("x", "y", "psi", "u", "v", "omega_z", "a_x_imu", "a_y_imu", "steer", *WHEEL_CHANNELS)
LEAST_SPEED = 0.5
"""m/s: a drive that never exceeds this stands."""
BOTH_WAYS = 0.075
"""rad/s to either side, in a tenth of a time, that no vehicle turns by with an angle that stays where it is."""
REQUIRED = ("u", "omega_z", "steer")
"""Channels that no drive is without."""
COARSE = 0.05
"""m/s: a speed whose values differ by steps as large may keep one value though it is measured, at a steady speed."""
AS_FAST = 0.1
"""Share by which such a speed may differ from that of the positions and is right."""
FAR = 4.0
"""s over which a way between positions is taken, so that their noise makes no speed."""
LEAST_STEERING = 0.015
"""rad: spread of the steering angle below which a drive is straight."""


def single_checks(m: Motion) -> list[Check]:
    """Stretches in which a channel does not change while the vehicle moves, and samples at one extreme."""
    checks = []
    dt = m.log.dt
    u = np.repeat(np.nan_to_num(m.speed), m.size)
    moving = np.zeros(len(m.log), dtype=bool)
    moving[: len(u)] = u > LEAST_SPEED
    turning = _turning(m)
    for name in WATCHED:
        values = m.channel(name)
        good = np.isfinite(values)
        if good.sum() < 20:
            continue
        active = moving if name in ("x", "y") else moving & turning
        if name == "steer":
            active = moving & _turned_without(m, values)
        if name == "u":  # without positions, nothing says that the speed must have changed
            active &= bool(np.isfinite(m.channel("x")).any() or np.isfinite(m.channel("omega_fl")).any())
            active[: len(u)] &= ~np.repeat(_as_fast(m), m.size) | (_step(values[good]) < COARSE)
        longest, share = _frozen(values, good, active, dt)
        if longest > (2.0 if name == "steer" else 1.0) * LIMITS.frozen:
            found = f"the same value for {longest:.1f} s while the vehicle moves ({100 * share:.0f} % of the samples)"
            other = f"another source of {name}" if name in REQUIRED else f"leave {name} out of the map"
            checks.append(Check(f"frozen_{name}", name, False, found, "a channel that changes with the motion",
                                f"{other}, or cut the stretch", share > 0.5))  # fmt: skip
        if name not in ("x", "y", "steer"):
            stuck = _saturated(values[good], moving[good])
            if stuck > LIMITS.saturated:
                found = f"{100 * stuck:.1f} % of the samples at an extreme"
                cure = f"a wider range of the sensor for {name}"
                checks.append(Check(f"saturated_{name}", name, False, found, "no clipped extremes", cure, stuck > LIMITS.clipped))
    return checks


def _step(values: Array) -> float:
    """Smallest difference of the values (N,), 0 where there are fewer than three of them."""
    different = np.unique(values)
    return float(np.diff(different).min()) if len(different) > 2 else 0.0


def _as_fast(m: Motion) -> NDArray[np.bool_]:
    """(windows,) whether the positions move as fast as u says."""
    by_position = np.hypot(m.slope(m.channel("x")), m.slope(m.channel("y")))
    return np.abs(by_position - m.speed) < AS_FAST * np.abs(m.speed)


def _turning(m: Motion) -> Array:
    """(N,) whether the mean over a window of steering angle or yaw rate changes in the second of a sample."""
    reach = max(round(1.0 / m.log.dt), 3)
    out = np.zeros(len(m.log), dtype=bool)
    for name, needed in (("steer", 0.03), ("omega_z", 0.05)):
        values = uniform_filter1d(np.nan_to_num(m.channel(name)), m.size)
        rows = len(values) // reach
        if rows < 1:
            continue
        spread = np.ptp(values[: rows * reach].reshape(rows, reach), axis=1) > needed
        out[: rows * reach] |= np.repeat(spread, reach)
    return out


def _turned_without(m: Motion, steer: Array) -> Array:
    """(N,) False where the angle (N,) stays and the vehicle does not turn both ways, after its answer to a step; else True."""
    settled = max(round(1.0 / m.log.dt), 3)
    u = np.repeat(np.nan_to_num(m.speed), m.size)
    yaw = uniform_filter1d(np.nan_to_num(m.channel("omega_z")), m.size)[: len(u)] * (u > LEAST_SPEED)
    out = np.ones(len(steer), dtype=bool)
    edges = np.flatnonzero(np.diff((np.diff(steer[: len(u)]) == 0.0).astype(int), prepend=0, append=0)).reshape(-1, 2)
    for start, stop in edges[np.diff(edges, axis=1)[:, 0] > settled + m.size + 2]:
        right, left = np.quantile(yaw[start + settled : stop - m.size], (0.1, 0.9))
        out[start : stop + 1] = right < -BOTH_WAYS and left > BOTH_WAYS
    return out


def _frozen(values: Array, good: Array, active: Array, dt: float) -> tuple[float, float]:
    """Longest time (s) without a change while `active`, and the share of active samples in stretches over LIMITS.frozen."""
    rows = np.flatnonzero(good)
    same = np.diff(values[rows]) == 0.0
    counted = same & active[rows[1:]]
    edges = np.flatnonzero(np.diff(counted.astype(int), prepend=0, append=0)).reshape(-1, 2)
    times = np.array([(rows[stop] - rows[start]) * dt for start, stop in edges]) if len(edges) else np.zeros(0)
    long = times > LIMITS.frozen
    total = max(float(active.sum()) * dt, 1e-9)
    return float(times.max(initial=0.0)), float(times[long].sum() / total)


def _saturated(values: Array, moving: Array) -> float:
    """Share of samples (N,) that equal the largest or the smallest value, in runs of three or more while the vehicle is `moving`
    (N,)."""
    if np.ptp(values) < 1e-9:
        return 0.0
    most = 0.0
    for extreme in (values.max(), values.min()):
        at = (values == extreme) & moving
        if extreme != 0.0:
            most = max(most, float((at[2:] & at[1:-1] & at[:-2]).mean()))
    return most


def excitation_checks(m: Motion) -> list[Check]:
    """Whether the vehicle drives, and whether it steers."""
    speed = float(np.nanmax(np.abs(m.speed), initial=0.0)) if np.isfinite(m.speed).any() else 0.0
    if speed < LEAST_SPEED:
        expected = f"a vehicle that moves (more than {LEAST_SPEED:g} m/s)"
        return [Check("drives", "u", False, f"at most {speed:.3g} m/s", expected, "a log of a drive", True)]
    backwards = float(np.mean(m.speed[np.isfinite(m.speed)] < -0.2))
    if backwards > 0.5:
        found = f"reversing in {100 * backwards:.0f} % of the log"
        return [
            Check(
                "drives", "u", False, found, "forward motion (u > 0)", "sign = -1 for u, or a log driven forwards", True
            )
        ]
    steer = m.driven(m.mean(m.channel("steer")))
    if not m.driving.any():
        steer = m.mean(m.channel("steer"))
    spread = float(np.nanstd(steer)) if np.isfinite(steer).any() else 0.0
    steered = spread > LEAST_STEERING
    cure = (
        ""
        if steered
        else "steer: on a straight path the soil does not show in the lateral motion, and n is not identified"
    )
    return [
        Check("drives", "u", True, f"up to {speed:.3g} m/s", f"more than {LEAST_SPEED:g} m/s"),
        Check("steered", "steer", steered, f"a spread of {spread:.4f} rad", f"more than {LEAST_STEERING:g} rad", cure),
        *_slower_than_positions(m),
    ]


def _slower_than_positions(m: Motion) -> list[Check]:
    """Where u is so slow everywhere that it is not compared, while the positions are not."""
    x, y = (interpolated(m.channel(name), round(FAR / m.log.dt)) for name in ("x", "y"))
    way = min(round(FAR / m.log.dt), len(x) - 1)
    gone = np.hypot(x[way:] - x[:-way], y[way:] - y[:-way]) / (way * m.log.dt)
    middle = float(np.median(gone[np.isfinite(gone)])) if np.isfinite(gone).any() else 0.0
    if m.driving.any() or not middle > max(SLOWEST, LIMITS.wrong_scale[1] * float(np.nanmedian(m.speed))):
        return []
    found = f"positions that move at {middle:.3g} m/s in the median, and u at {float(np.nanmedian(m.speed)):.3g}"
    expected, cure = "a speed as the positions move (scale 1)", "correct unit or scale of u"
    return [Check("speed_position", "u", False, found, expected, cure, True)]
