"""An import: sources and a map become one drive, with its clocks compared and its channels checked."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.checking.axle import axle_checks
from softsoil.checking.cross_check import check_channels
from softsoil.checking.offsets import Offset, time_offsets
from softsoil.checking.place import place_checks, without_misplaced
from softsoil.checking.words import Check
from softsoil.importing.bag import inspect_bag, read_bag, topics_of
from softsoil.importing.draft_map import geodetic
from softsoil.importing.earth_velocity import EARTH
from softsoil.importing.import_map import ImportMap, split_label
from softsoil.importing.local_frame import east_north
from softsoil.importing.loose_table import BY_NAME, TimeColumn, inspect_table, open_table, read_columns
from softsoil.importing.merge import Merged, merge
from softsoil.importing.sources import Holding, Series, check_source, is_bag
from softsoil.recording.derive import completed
from softsoil.recording.drive import CHANNEL_UNITS, WHEEL_CHANNELS, Recording
from softsoil.recording.evidence import Motion
from softsoil.recording.geometry import Geometry

GROUPS: Mapping[str, tuple[str, ...]] = {
    "psi": ("psi",), "u": ("u",), "wheels": WHEEL_CHANNELS, "position": ("x", "y"), "steer": ("steer",),
}  # fmt: skip
"""Group of a time offset -> channels whose sources share it."""
BY_V = ("position", "steer")
"""Groups whose offsets rest on the lateral velocity: of one that is doubted they say nothing."""
SHOWN = 0.1
"""s: standard error of an offset beyond which it does not show whether a channel is late by itself."""
LEAST_SIGMAS = 3.0
"""A clock is shifted by an offset of at least so many standard errors."""
ROUNDS = 3
"""Offsets are estimated again on shifted clocks: a late gyro hides what else is late."""
SETTLED = 0.003
"""s: a further shift smaller than this ends the rounds."""
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Import:
    """What an import made.

    merged: the drive before absent channels were derived; drive: with them; shifts: source -> seconds that its clock was shifted;
    offsets: between the clocks as they were; checks: of the drive as it is now; series: by source.
    """

    merged: Merged
    drive: Any
    shifts: Mapping[str, float]
    offsets: tuple[Offset, ...]
    checks: tuple[Check, ...]
    series: Mapping[str, Series]

    def as_json(self) -> dict[str, Any]:
        """The content of import.json."""
        channels = {}
        for name in CHANNEL_UNITS:
            if name == "t":
                continue
            origin = self.merged.origins.get(name)
            source = origin.source if origin else ""
            shift = (self.shifts.get(split_label(source)[0], 0.0) - origin.late) if origin else 0.0
            channels[name] = {
                "state": self.drive.state_of(name),
                "source": source, "rate_hz": origin.rate_hz if origin else None,
                "offset_s": shift, "gaps": origin.gaps if origin else None,
            }  # fmt: skip
        offsets = [vars(offset) for offset in self.offsets]
        clock = {"rows": len(self.drive), "rate_hz": 1.0 / self.drive.dt, "start_s": self.merged.start_s}
        checks = [check.as_json() for check in self.checks]
        place = {"origin": self.drive.origin and list(self.drive.origin)}
        return {**clock, **place, "channels": channels, "offsets": offsets, "checks": checks, "notes": list(self.drive.notes)}


def inspect_sources(paths: Sequence[Path], progress: Progress = lambda share: None) -> list[Holding]:
    """Everything that bags and tables hold; progress: called with the share done. Raises ValueError naming the file."""
    for path in paths:
        check_source(path)
    found: list[Holding] = []
    for i, path in enumerate(paths):
        look = inspect_bag if is_bag(path) else inspect_table
        found += look(path, lambda share, i=i: progress((i + share) / len(paths)))  # type: ignore[misc]
    names = [holding.name for holding in found]
    _refuse_twice(names)
    return found


def _refuse_twice(names: Sequence[str]) -> None:
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        parts = ": bag files in one folder are read as the parts of one recording" if twice.startswith("/") else ""
        raise ValueError(f"sources: expected distinct topics and file names, found {twice!r} twice{parts}")


def read_sources(paths: Sequence[Path], plan: ImportMap, progress: Progress = lambda share: None) -> dict[str, Series]:
    """The samples that the map wants, by source; progress: called with the share done.

    Raises ValueError for a source that no path holds, or a field that a source lacks.
    """
    wanted = plan.wanted()
    parts: list[Series] = []
    for i, path in enumerate(paths):
        check_source(path)
        if is_bag(path):
            parts += _of_bag(path, wanted, lambda share, i=i: progress((i + share) / len(paths)))  # type: ignore[misc]
        elif path.name in wanted:
            parts.append(_of_table(path, wanted[path.name], plan.times.get(path.name, BY_NAME)))
        progress((i + 1) / len(paths))
    _refuse_twice([one.name for one in parts])
    found = {one.name: one for one in parts}
    missing = [source for source in wanted if source not in found]
    if missing:
        there = [topic for path in paths if is_bag(path) for topic in topics_of(path)] if missing[0].startswith("/") else []
        of = ", ".join(there or map(str, paths))
        none = f"no message of {missing[0]!r}" if missing[0] in there else f"none called {missing[0]!r}"
        raise ValueError(f"map: expected {'topics' if there else 'sources'} of {of}; found {none}")
    return found


def _of_bag(path: Path, wanted: Mapping[str, Sequence[str]], progress: Progress) -> list[Series]:
    topics = {s: list(fields) for s, fields in wanted.items() if s.startswith("/")}
    for fields in topics.values():
        if "east" in fields or "north" in fields:
            fields[:] = [f for f in fields if f not in ("east", "north")] + ["latitude", "longitude", "altitude"]
    return [_local(one, ("latitude", "longitude", "altitude")) if "latitude" in one.values else one
            for one in read_bag(path, topics, progress)]  # fmt: skip


def _of_table(path: Path, fields: Sequence[str], time: TimeColumn) -> Series:
    if not {"east", "north"} & set(fields) or {"east", "north"} <= set(open_table(path, time).frame.columns):
        return read_columns(path, fields, time)
    names = geodetic(list(map(str, open_table(path, time).frame.columns)))
    if names is None:
        raise ValueError(f"{path}: expected columns of latitude and longitude for east and north, found none")
    others = [f for f in fields if f not in ("east", "north")]
    return _local(read_columns(path, [*others, *(n for n in names if n)], time), names)


def _local(one: Series, names: tuple[str, str, str]) -> Series:
    blank = np.full(len(one.t), np.nan)
    latitude, longitude, altitude = (one.values.get(n, blank) for n in names)
    east, north, origin = east_north(one.name, latitude, longitude, altitude)
    note = f"{one.name}: local frame with its origin at latitude {origin[0]:.7f}, longitude {origin[1]:.7f} deg"
    return replace(one, values={**one.values, "east": east, "north": north}, notes=(*one.notes, note), origin=origin)


def bring_in(
    name: str, plan: ImportMap, series: Mapping[str, Series], geometry: Geometry, align: bool = False, late_steering: float = 0.0
) -> Import:
    """The drive of the mapped series, its clocks aligned where asked.

    name: of the drive; plan: the map; series: by source; geometry: of the vehicle; align: whether clocks are shifted by their
    estimated offsets; late_steering: seconds by which its road wheels are known to follow `steer`, which is no clock's. Raises
    ValueError as `merge` does.
    """
    merged = merge(name, plan, series, geometry)
    offsets = time_offsets(merged.recording, geometry)
    shifts: dict[str, float] = {}
    if align:
        found = offsets
        elsewhere = any(not check.passed for check in place_checks(Motion.of(merged.recording), geometry))
        for _ in range(ROUNDS):
            further = source_shifts(plan, [o for o in found if not (elsewhere and o.group in BY_V)], late_steering)
            shifts = {source: shifts.get(source, 0.0) + further.get(source, 0.0) for source in {*shifts, *further}}
            if max((abs(value) for value in further.values()), default=0.0) < SETTLED:
                break
            merged = merge(name, plan, series, geometry, shifts)
            found = time_offsets(merged.recording, geometry)
        hidden = _positions_elsewhere(plan, shifts, merged.recording, geometry)
        if hidden:
            shifts = {source: value for source, value in shifts.items() if source not in hidden}
            merged = merge(name, plan, series, geometry, shifts)
    notes = tuple(f"{source}: clock shifted by {value:+.3f} s" for source, value in shifts.items() if value)
    recording = replace(merged.recording, notes=(*merged.recording.notes, *notes))
    checks = (*check_channels(recording, geometry, late_steering), *axle_checks(recording, geometry))
    checks = (*(as_mapped(check, plan) for check in checks), *idle_entries(plan))
    return Import(merged, completed(without_misplaced(recording, checks), geometry), shifts, offsets, checks, series)


def idle_entries(plan: ImportMap) -> tuple[Check, ...]:
    """A doubt of each mount and each time column that serves no channel, as of a source whose name is misspelt."""
    sources = ", ".join(dict.fromkeys(origin.source for origin in plan.channels.values()))
    idle = [("mount", name) for name in plan.idle_mounts()] + [("sources", name) for name in plan.idle_times()]
    return tuple(
        Check(f"{table}_{name}", f"{table}.{name}", False, "no channel that comes from it", f"a source of the map ({sources})",
              "correct its name, or take it out")
        for table, name in idle
    )  # fmt: skip


def as_mapped(check: Check, plan: ImportMap) -> Check:
    """The check with the cure that the map asks for: a sign that the map turns already is to be taken out of it."""
    origin, asked = plan.channels.get(check.channel), f"sign = -1 for {check.channel}"
    if origin is not None and origin.earth:
        pair = " and ".join(EARTH)
        cure = check.cure.replace(asked, f"compare psi with {pair}, which it turns")
        return replace(check, cure=re.sub(r"\b(of|for|at) [uv]\b", rf"\1 {pair}", cure))
    if origin is None or asked not in check.cure or origin.scale > 0.0:
        return check
    there = f"no sign, ratio or factor below 0 for {check.channel}, as the map has it now"
    return replace(check, cure=check.cure.replace(asked, there))


def _positions_elsewhere(
    plan: ImportMap, shifts: Mapping[str, float], recording: Recording, geometry: Geometry
) -> set[str]:
    """Sources of positions whose clocks have been shifted, where the positions still are not those of the front axle: an antenna
    that stands elsewhere looks like a late clock, and a shift would hide it."""
    moved = {plan.channels[c].source for c in GROUPS["position"] if c in plan.channels}
    moved &= {source for source, value in shifts.items() if value}
    return moved if moved and any(not check.passed for check in axle_checks(recording, geometry)) else set()


def shifted_with(plan: ImportMap, source: str, offsets: Sequence[Offset]) -> tuple[str, ...]:
    """Channels of GROUPS of a source whose own time no offset shows to SHOWN: they are shifted with those that are shown.

    plan: the map; source: its name; offsets: between the clocks as they were.
    """
    shown = {offset.group for offset in offsets if offset.std <= SHOWN}
    others = {channel for group, channels in GROUPS.items() if group not in shown for channel in channels}
    return tuple(name for name, origin in plan.channels.items() if origin.source == source and name in others)


def source_shifts(plan: ImportMap, offsets: Sequence[Offset], late_steering: float = 0.0) -> dict[str, float]:
    """Source -> seconds to add to its times: minus its channels' offsets, weighted by their standard errors.

    plan: the map; the yaw rate's source is the reference and stays; an offset within LEAST_SIGMAS of its error is left, and so is
    one that is not `trusted`; late_steering: seconds by which `steer` seems early without being so.
    """
    reference = plan.channels["omega_z"].source
    sums: dict[str, list[tuple[float, float]]] = {}
    for offset in offsets:
        if not offset.trusted:
            continue
        sources = {plan.channels[c].source for c in GROUPS[offset.group] if c in plan.channels}
        for source in sources - {reference}:
            late = offset.late_s + (late_steering if offset.group == "steer" else 0.0)
            sums.setdefault(source, []).append((late, offset.std))
    shifts = {}
    for source, found in sums.items():
        weights = np.array([1.0 / std**2 for _, std in found])
        late = float(np.average([value for value, _ in found], weights=weights))
        if abs(late) > LEAST_SIGMAS / np.sqrt(weights.sum()):
            shifts[source] = -late
    return shifts
