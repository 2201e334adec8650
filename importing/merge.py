"""Series of many rates and clocks brought to one even clock, sensors moved to where the model has its states.

Nothing is invented: a channel faster than the clock is the mean of its samples around each tick; a state channel slower than the
clock stands at the ticks next to its own samples and is empty between; a slower input (steering, wheel speeds, accelerations) is
a straight line between samples, and empty in gaps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from softsoil.importing.import_map import ImportMap, Mapped, Mount
from softsoil.importing.sources import GAP, TABLE_SUFFIXES, Series
from softsoil.recording.between import samples
from softsoil.recording.clock import at_clock
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Array, ChannelState, Recording
from softsoil.recording.evidence import interpolated
from softsoil.recording.geometry import Geometry
from softsoil.recording.outliers import left_out, outliers

LEAST = ("u", "omega_z", "steer")
ACCELERATIONS = ("a_x_imu", "a_y_imu")
FASTEST = 100.0
"""Hz: clock of a drive whose yaw rate comes faster, unless the map says another."""
SLOWEST = 1.0
"""s between yaw rates: what is farther is no motion of a vehicle."""
SLOW = 1.5
"""A channel whose samples are farther apart than so many ticks is slower than the clock."""
GRAVITY = 9.81
"""m/s^2"""
CARRIED = 5
"""Samples to each side for the yaw acceleration that moves an accelerometer to the centre of gravity."""


@dataclass(frozen=True)
class Origin:
    """Where a channel of a merged drive comes from: state, source, its own rate (Hz), gaps in it; late: as its map says (s)."""

    state: ChannelState
    source: str
    rate_hz: float
    gaps: int
    late: float = 0.0


@dataclass(frozen=True)
class Merged:
    """One drive out of many sources: recording; origins by channel; start_s: its first time on the sources' clock."""

    recording: Recording
    origins: Mapping[str, Origin]
    start_s: float


def merge(
    name: str,
    plan: ImportMap,
    series: Mapping[str, Series],
    geometry: Geometry,
    shifts: Mapping[str, float] | None = None,
) -> Merged:
    """The mapped channels on one clock.

    name: of the drive; plan: the map; series: by source; geometry: of the vehicle; shifts: source -> seconds added to its times.
    Raises ValueError where speed, yaw rate or steering angle is not mapped or the sources do not overlap.
    """
    for channel in LEAST:
        if channel not in plan.channels:
            raise ValueError(f"map: expected at least channels u, omega_z and steer; found no {channel}")
    moved = {key: s.t + (shifts or {}).get(key, 0.0) for key, s in series.items()}
    clock = _clock(plan, moved)
    dt = float(clock[1] - clock[0])
    channels: dict[str, Array] = {"t": clock - clock[0]}
    origins: dict[str, Origin] = {}
    wrong: dict[str, int] = {}
    notes = tuple(note for s in series.values() for note in s.notes)
    notes += tuple(f"map: mount.{name}: no channel comes from it" for name in plan.idle_mounts())
    for channel, origin in plan.channels.items():
        one = series[origin.source]
        values = origin.si(origin.samples(one), geometry.radius)
        good = np.isfinite(values)
        if good.sum() < 2:
            raise ValueError(
                f"{origin.label}: expected numbers for {channel}, found {int(good.sum())}"
            )
        t, values = moved[origin.source][good] - origin.late, values[good]
        if channel == "psi":
            values = np.unwrap(values)
        if (sampled := samples(channel, t, values)) is not None:
            t, values, notes = t[sampled[0]], values[sampled[0]], (*notes, sampled[1])
        own = Series(origin.source, t, {})
        if (out := outliers(channel, values)).any():
            t, values, wrong[channel] = t[~out], values[~out], int(out.sum())
        channels[channel] = _placed(channel, clock, t, values, dt)
        origins[channel] = Origin("measured", origin.label, own.rate_hz, own.gaps, origin.late)
    if wrong:
        notes += (left_out(wrong),)
    state: dict[str, ChannelState] = {}
    repeated = [n for n in WHEEL_CHANNELS if n in plan.channels]
    if len(repeated) > 1 and len({(plan.channels[n].source, plan.channels[n].fields) for n in repeated}) == 1:
        # One speed for all: it is the wheels' mean, and each wheel is derived from that.
        mean = channels[repeated[0]]
        for n in repeated:
            channels.pop(n)
        channels |= _all_from(mean, channels, geometry)
        for n in WHEEL_CHANNELS:
            state[n] = "derived"
            first = origins[repeated[0]]
            origins[n] = replace(first, state="derived")
    channels = _mounted(channels, plan, geometry)
    for channel, origin in plan.channels.items():
        if origin.late:
            notes += (f"{channel}: {origin.label}: taken as {origin.late:+.3f} s late, as its map says",)
        if count := origin.wraps(series[origin.source]):
            notes += (f"{channel}: {origin.label}: a counter that wrapped {count} times",)
    recording = Recording(name, channels, {}, notes, {}, state, _origin(plan, series))
    return Merged(recording, origins, float(clock[0]))


def _origin(plan: ImportMap, series: Mapping[str, Series]) -> tuple[float, float] | None:
    """Latitude and longitude (deg) of the drive's frame, where x and y are the metres east and north of one source's fixes."""
    x, y = (plan.channels.get(name) for name in ("x", "y"))
    if x is None or y is None:
        return None
    if replace(x, late=0.0) != Mapped(x.source, ("east",)) or replace(y, late=0.0) != Mapped(x.source, ("north",)):
        return None
    return series[x.source].origin


def _clock(plan: ImportMap, moved: Mapping[str, Array]) -> Array:
    """Equal steps over what speed, yaw rate and steering have in common, at the yaw rate's own rate, cut as the map says."""
    times = {channel: moved[plan.channels[channel].source] - plan.channels[channel].late for channel in LEAST}
    turning = times["omega_z"]
    step = float(np.median(np.diff(turning))) if len(turning) > 1 else float("nan")
    if not step > 0:
        raise ValueError(
            f"{plan.channels['omega_z'].source}: expected yaw rates over time, found {len(turning)} samples"
        )
    if step > SLOWEST:
        source = plan.channels["omega_z"].source
        raise ValueError(
            f"{source}: expected yaw rates at most {SLOWEST:g} s apart, found {step:.4g} s: is its time in other units? "
            f'[sources."{source}"] time_unit = "ms" in the map says which'
        )
    dt = 1.0 / plan.rate_hz if plan.rate_hz else max(step, 1.0 / FASTEST)
    start, stop = max(t[0] for t in times.values()), min(t[-1] for t in times.values())
    if not stop - start > 4 * dt:
        spans = "; ".join(
            f"{plan.channels[c].source} {t[0]:.3f} to {t[-1]:.3f} s" for c, t in times.items()
        )
        raise ValueError(f"map: expected sources that overlap in time, found {spans}")
    first = turning[np.searchsorted(turning, start)]
    clock = first + dt * np.arange(int((stop - first) / dt + 1e-6) + 1)
    cut = clock[(clock >= start + plan.start - 1e-9) & (clock <= start + plan.end + 1e-9)]
    if len(cut) < 5:
        raise ValueError(
            f"map: clock: expected start and end within the {clock[-1] - start:.3f} s of the drive, "
            f"found {plan.start:g} to {plan.end:g}"
        )
    return cut


def _ticked(clock: Array, t: Array, values: Array, dt: float) -> tuple[Array, Array]:
    """Times and values of a channel faster than the clock, each the mean of the samples within half a step of a tick."""
    tick = np.floor((t - clock[0]) / dt + 0.5)
    first = np.flatnonzero(np.diff(tick, prepend=-np.inf))
    count = np.diff(first, append=len(t))
    return np.add.reduceat(t, first) / count, np.add.reduceat(values, first) / count


def _placed(channel: str, clock: Array, t: Array, values: Array, dt: float) -> Array:
    period = float(np.median(np.diff(t)))
    if period < dt / SLOW:
        t, values = _ticked(clock, t, values, dt)
        period = dt
    if period <= SLOW * dt:
        return at_clock(clock, t, values, 0.75 * max(dt, period))
    if channel in STATE_CHANNELS:
        return at_clock(clock, t, values, 0.5 * dt)
    after = np.clip(np.searchsorted(t, clock), 1, len(t) - 1)
    inside = (t[after] - t[after - 1] <= GAP * period) & (clock >= t[0]) & (clock <= t[-1])
    return np.where(inside, np.interp(clock, t, values), np.nan)


def _all_from(mean: Array, channels: Mapping[str, Array], geometry: Geometry) -> dict[str, Array]:
    """Each wheel's speed from the mean of all: faster or slower by its side's turning."""
    turning = interpolated(channels["omega_z"], len(mean)) / geometry.radius
    sides = {"l": -1.0, "r": 1.0}
    half = {"f": geometry.track / 2, "r": geometry.rear_track / 2}
    return {name: mean + sides[name[-1]] * half[name[-2]] * turning for name in WHEEL_CHANNELS}


def _mounted(channels: dict[str, Array], plan: ImportMap, geometry: Geometry) -> dict[str, Array]:
    """Channels in the project's frame: (x, y) of the front axle, velocities and accelerations of the centre of gravity."""
    out = dict(channels)
    offset = {name: plan.channels[name].offset for name in out if name in plan.channels}
    for name in ("y", "psi", "v", "omega_z", "a_y_imu"):
        if name in plan.channels and (m := plan.mount_of(name)) and m.frame == "z-down":
            out[name] = -out[name]
    for name in offset.keys() - set(ACCELERATIONS):
        out[name] = out[name] + offset[name]
    if m := plan.mount_of("omega_z"):
        out["omega_z"] = out["omega_z"] / (np.cos(m.pitch) * np.cos(m.roll))
    reach = len(out["t"])
    omega = interpolated(out["omega_z"], reach)
    if "psi" in plan.channels and (m := plan.mount_of("psi")):
        out["psi"] = out["psi"] - m.yaw
    if m := plan.mount_of("u"):
        aside = out["v"] if "v" in out and plan.channels["v"].source == plan.channels["u"].source else None
        if aside is not None:
            out["u"], aside = _turned(out["u"], aside, m.yaw)
            out["v"] = aside - m.x * omega
        out["u"] = out["u"] + m.y * omega
    _mount_accelerations(out, plan, omega)
    for name in offset.keys() & set(ACCELERATIONS):  # what they read beside the motion, as the checks say it
        out[name] = out[name] + offset[name]
    if {"x", "y"} <= set(out):
        place = _place(plan.channels["x"].source, plan.mount_of("x"), geometry)
        if place is not None and "psi" in out:
            psi = interpolated(out["psi"], reach)
            ahead, left = geometry.l_f - place[0], -place[1]
            out["x"] = out["x"] + ahead * np.cos(psi) - left * np.sin(psi)
            out["y"] = out["y"] + ahead * np.sin(psi) + left * np.cos(psi)
    return out


def _turned(ahead: Array, aside: Array, yaw: float) -> tuple[Array, Array]:
    """Components in the vehicle's frame of a vector given in a frame turned to the left by yaw (rad)."""
    return ahead * np.cos(yaw) - aside * np.sin(yaw), ahead * np.sin(yaw) + aside * np.cos(yaw)


def _mount_accelerations(out: dict[str, Array], plan: ImportMap, omega: Array) -> None:
    """Specific force at the centre of gravity: gravity in a tilted sensor off, turned, moved by its lever arm."""
    if not set(ACCELERATIONS) <= set(plan.channels):
        return
    m = plan.mount_of("a_x_imu")
    if m is None:
        return
    ahead = (out["a_x_imu"] + GRAVITY * np.sin(m.pitch)) / np.cos(m.pitch)
    aside = (out["a_y_imu"] - GRAVITY * np.sin(m.roll)) / np.cos(m.roll)
    ahead, aside = _turned(ahead, aside, m.yaw)
    dt = float(out["t"][1] - out["t"][0])
    clock = np.arange(-CARRIED, CARRIED + 1) * dt
    turning = np.convolve(np.pad(omega, CARRIED, mode="edge"), clock[::-1] / float(clock @ clock), mode="valid")
    out["a_x_imu"] = ahead + turning * m.y + omega**2 * m.x
    out["a_y_imu"] = aside - turning * m.x + omega**2 * m.y


def _place(source: str, mount: Mount | None, geometry: Geometry) -> tuple[float, float] | None:
    """Place of the positions from the centre of gravity (m); None where they are of the front axle already."""
    if mount is None:
        return None if source.endswith(TABLE_SUFFIXES) else (0.0, 0.0)
    if mount.point == "front_axle":
        return None
    return (0.0, 0.0) if mount.point == "centre_of_gravity" else (mount.x, mount.y)
