"""Series of many rates and clocks brought to one even clock, sensors moved to where the model has its states.

Nothing is invented: a channel faster than the clock is the mean of its samples around each tick; a state channel slower than the
clock stands at the ticks next to its own samples and is empty between; a slower input (steering, wheel speeds, accelerations) is
a straight line between samples, and empty in gaps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from softsoil.importing.import_map import ImportMap, Mapped
from softsoil.importing.mounted import mounted
from softsoil.importing.sources import GAP, Series
from softsoil.recording.between import samples
from softsoil.recording.clock import at_clock
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Array, ChannelState, Recording
from softsoil.recording.evidence import interpolated
from softsoil.recording.geometry import Geometry, radius_of
from softsoil.recording.outliers import left_out, outliers

LEAST = ("u", "omega_z", "steer")
FASTEST = 100.0
"""Hz: clock of a drive whose yaw rate comes faster, unless the map says another."""
SLOWEST = 1.0
"""s between yaw rates: what is farther is no motion of a vehicle."""
SLOW = 1.5
"""A channel whose samples are farther apart than so many ticks is slower than the clock."""


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
    _ask_least(plan)
    moved = {key: s.t + (shifts or {}).get(key, 0.0) for key, s in series.items()}
    clock = _clock(plan, series, moved)
    dt = float(clock[1] - clock[0])
    channels: dict[str, Array] = {"t": clock - clock[0]}
    origins: dict[str, Origin] = {}
    wrong: dict[str, int] = {}
    notes = tuple(note for s in series.values() for note in s.notes)
    for channel, origin in plan.channels.items():
        one = series[origin.source]
        samples_of = origin.samples(one)
        values, beyond = origin.si(samples_of, radius_of(geometry, channel)), origin.beyond(samples_of)
        good = np.isfinite(values)
        if good.sum() < 2:
            raise ValueError(
                f"{origin.label}: expected numbers for {channel}, found {int(good.sum())}"
            )
        if beyond:
            of = f"{beyond} of {int(good.sum())} samples"
            notes += (f"{channel}: {origin.label}: {of} lie beyond its table, taken as its ends",)
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
    for repeated, wheels in _one_for_many(plan):
        mean, first = channels[repeated[0]], replace(origins[repeated[0]], state="derived")
        channels |= _wheels_from(mean, wheels, channels, geometry)
        state |= dict.fromkeys(wheels, "derived")
        origins |= dict.fromkeys(wheels, first)
    channels, more = mounted(channels, plan, geometry)
    notes += more
    for channel, origin in plan.channels.items():
        if origin.late:
            notes += (f"{channel}: {origin.label}: taken as {origin.late:+.3f} s late, as its map says",)
        if count := origin.wraps(series[origin.source]):
            notes += (f"{channel}: {origin.label}: a counter that wrapped {count} times",)
    recording = Recording(name, channels, {}, notes, {}, state, _origin(plan, series))
    return Merged(recording, {name: one for name, one in origins.items() if name in channels}, float(clock[0]))


def _origin(plan: ImportMap, series: Mapping[str, Series]) -> tuple[float, float] | None:
    """Latitude and longitude (deg) of the drive's frame, where x and y are the metres east and north of one source's fixes."""
    x, y = (plan.channels.get(name) for name in ("x", "y"))
    if x is None or y is None:
        return None
    if replace(x, late=0.0) != Mapped(x.source, ("east",)) or replace(y, late=0.0) != Mapped(x.source, ("north",)):
        return None
    return series[x.source].origin


def wanted_span(plan: ImportMap, series: Mapping[str, Series]) -> tuple[float, float]:
    """Times (s) between which the map wants the recording, as its sources stamp them; ValueError as `merge`."""
    _ask_least(plan)
    begin = max(t[0] for t in _times(plan, series, {key: one.t for key, one in series.items()}).values())
    return begin + plan.start, begin + plan.end


def _ask_least(plan: ImportMap) -> None:
    for channel in LEAST:
        if channel not in plan.channels:
            raise ValueError(f"map: expected at least channels u, omega_z and steer; found no {channel}")


def _times(plan: ImportMap, series: Mapping[str, Series], moved: Mapping[str, Array]) -> dict[str, Array]:
    """Times at which the channels that a drive has to have stand: their source may have rows without them."""
    found = {}
    for channel in LEAST:
        origin = plan.channels[channel]
        there = np.isfinite(origin.samples(series[origin.source]))
        found[channel] = moved[origin.source][there] - origin.late
        if not there.any():
            raise ValueError(f"{origin.label}: expected numbers for {channel}, found 0")
    return found


def _clock(plan: ImportMap, series: Mapping[str, Series], moved: Mapping[str, Array]) -> Array:
    """Equal steps over what speed, yaw rate and steering have in common, at the yaw rate's own rate, cut as the map says."""
    times = _times(plan, series, moved)
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


def _one_for_many(plan: ImportMap) -> list[tuple[list[str], list[str]]]:
    """Wheels that the map gives one speed, and those that it stands for: these, or all where no other wheel has one."""
    mapped = [name for name in WHEEL_CHANNELS if name in plan.channels]
    alike: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for name in mapped:
        alike.setdefault((plan.channels[name].source, plan.channels[name].fields), []).append(name)
    return [(names, list(WHEEL_CHANNELS) if names == mapped else names) for names in alike.values() if len(names) > 1]


def _wheels_from(mean: Array, wheels: Sequence[str], channels: Mapping[str, Array], geometry: Geometry) -> dict[str, Array]:
    """Speeds of the wheels from the mean of them: faster or slower by their side's turning."""
    turning, sides = interpolated(channels["omega_z"], len(mean)), {"l": -1.0, "r": 1.0}
    half = {"f": geometry.track / 2, "r": geometry.rear_track / 2}
    radius = {name: radius_of(geometry, name) for name in wheels}
    rim = mean * (sum(radius.values()) / len(radius))
    return {name: (rim + sides[name[-1]] * half[name[-2]] * turning) / radius[name] for name in wheels}
