"""The map of an import, from TOML: which field or column of which source is which channel, and how it is turned into SI.

[channels]
u = "/odom:twist.twist.linear.x"
steer = {source = "steering.csv:wheel", unit = "deg", ratio = 16.0}
omega_fl = {source = "/joints:velocity[front_left]", unit = "m/s"}
x = "/gps:east"
[mount."/gps"]
x = -1.2
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.files.toml_file import read_toml
from softsoil.importing.counters import unwrapped
from softsoil.importing.earth_velocity import EARTH, in_their_place
from softsoil.importing.loose_table import SECONDS, TimeColumn
from softsoil.importing.sources import TABLE_SUFFIXES, Series
from softsoil.recording.columns import UNITS
from softsoil.recording.drive import CHANNEL_UNITS, WHEEL_CHANNELS, Array

CHANNELS = tuple(name for name in CHANNEL_UNITS if name != "t")
ALL_WHEELS = "omega_all"
"""One wheel speed, or a drive motor's over the final ratio, that stands for all four wheels."""
CHANNEL_KEYS = ("source", "unit", "factor", "sign", "offset", "ratio", "table", "compass", "rate", "late")
LATEST = 10.0
"""s: a channel is taken to be late or early by no more."""
TABLE_END = 1e-6
"""Beyond an end of a table by less is rounding."""
TABLE_FILE = re.compile(rf"(.*?(?:{'|'.join(map(re.escape, sorted(TABLE_SUFFIXES, key=len, reverse=True)))})):(.*)", re.I | re.S)
"""A table's field: a colon may stand in the file's name."""
COUNTED = {"rad/s": "rad", "m/s": "m"}
"""Unit of a channel -> unit of what it is the rate of: angles of encoders, ways of odometers, a heading."""
PARTS = {
    "position": ("x", "y"), "heading": ("psi",), "velocity": ("u", "v"), "yaw_rate": ("omega_z",),
    "acceleration": ("a_x_imu", "a_y_imu"),
}  # fmt: skip
"""What of a source may have a place of its own -> its channels: a receiver may bring velocities elsewhere than positions."""
MOUNT_KEYS = ("x", "y", "yaw", "pitch", "roll", "frame", "point")
STEER_COMMAND = "steer_command"
"""What the steering was commanded, or its wheel's angle: becomes `steer` by the vehicle's steering map, or is fitted to it."""
UNITS_BESIDE = {ALL_WHEELS: "rad/s", STEER_COMMAND: "", **dict.fromkeys(EARTH, "m/s")}
"""Entries of [channels] that are no channels of a drive -> their unit."""
CLOCK_KEYS = ("rate_hz", "start", "end")
POINTS = ("here", "front_axle", "centre_of_gravity")
FRAMES = ("z-up", "z-down")


@dataclass(frozen=True)
class Mapped:
    """One channel's origin.

    source; fields: one, or several of which the channel is the mean; scale: to SI, with sign; offset (SI): added last, in the
    vehicle's frame; table: (input, road-wheel angle) pairs or None; over_radius: m/s, divided by the wheel's radius; compass:
    heading clockwise from north; rate: whether the channel is the fields' rate of change; late: seconds by which its samples'
    times are late (negative: early); heading: whether a whole turn of it is nothing; earth: whether it is of EARTH.
    """

    source: str
    fields: tuple[str, ...]
    scale: float = 1.0
    offset: float = 0.0
    table: tuple[tuple[float, float], ...] | None = None
    over_radius: bool = False
    compass: bool = False
    rate: bool = False
    late: float = 0.0
    heading: bool = False
    earth: bool = False

    @property
    def label(self) -> str:
        """source:field, as a person reads it."""
        more = " (rate)" if self.rate else " (turned by psi)" if self.earth else ""
        return f"{self.source}:{' and '.join(self.fields)}{more}"

    def samples(self, series: Series) -> Array:
        """(N,) values of its fields in its source's series, or rates of change: their mean, NaN where one is missing."""
        parts, turn = [series.values[name] for name in self.fields], 2 * math.pi / abs(self.scale)
        if self.rate:
            parts = [_rate(series.t, unwrapped(part)[0], turn) for part in parts]
        elif self.heading:
            parts = [part - turn * np.round((part - parts[0]) / turn) for part in parts]
        values: Array = np.mean(parts, axis=0)
        return values

    def beyond(self, values: Array) -> int:
        """How many of the values (N,) of `samples` lie beyond the ends of its table, where that is constant."""
        if self.table is None:
            return 0
        ends = np.array(self.table)[[0, -1], 0]
        return int(((values * self.scale < ends[0] - TABLE_END) | (values * self.scale > ends[1] + TABLE_END)).sum())

    def wraps(self, series: Series) -> int:
        """How often counts, of which the channel is the rate, started anew in its source's series."""
        return sum(unwrapped(series.values[name])[1] for name in self.fields) if self.rate else 0

    def si(self, values: Array, radius: float) -> Array:
        """values (N,) of `samples` without `offset`, in SI units of the channel; radius: of the wheels (m)."""
        out = values * self.scale
        if self.table is not None:
            out = np.interp(out, *np.array(self.table, dtype=float).T)
        if self.over_radius:
            out = out / radius
        return math.pi / 2 - out if self.compass else out


def _rate(t: Array, values: Array, turn: float) -> Array:
    """(N,) rate of change of values (N,) over t (N,) (s); an angle that stays within a turn is taken to start anew each turn.

    turn: of an angle, in the values' unit.
    """
    good = np.flatnonzero(np.isfinite(values))
    out = np.full(len(values), np.nan)
    if len(good) > 2:
        angle = values[good]
        out[good] = np.gradient(np.unwrap(angle, period=turn) if np.ptp(angle) < 1.02 * turn else angle, t[good])
    return out


@dataclass(frozen=True)
class Mount:
    """Where a sensor stands and how it is turned on the vehicle.

    x, y: ahead of and left of the centre of gravity (m); yaw (left), pitch (nose down), roll (right side down): rad;
    frame: "z-up" or "z-down" (x forward, y right); point: whether positions are those of the sensor ("here") or were brought to
    the front axle or the centre of gravity by the device.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    frame: str = "z-up"
    point: str = "here"


@dataclass(frozen=True)
class ImportMap:
    """A parsed map.

    channels: channel -> origin; mounts: one of PARTS or source -> mount, "" for all others; times: source -> its time column;
    rate_hz: of the clock, 0 for the yaw rate's own up to 100; start, end: of the drive (s after the sources' first common time).
    """

    channels: Mapping[str, Mapped]
    mounts: Mapping[str, Mount] = field(default_factory=dict)
    times: Mapping[str, TimeColumn] = field(default_factory=dict)
    rate_hz: float = 0.0
    start: float = 0.0
    end: float = math.inf

    def wanted(self) -> dict[str, list[str]]:
        """Source -> fields that channels are made of."""
        found: dict[str, list[str]] = {}
        for origin in self.channels.values():
            fields = found.setdefault(origin.source, [])
            fields += [name for name in origin.fields if name not in fields]
        return found

    def mount_of(self, channel: str) -> Mount | None:
        """The mount of a mapped channel: that of its part, of its source, of all others, or None."""
        part = next((name for name, channels in PARTS.items() if channel in channels), "")
        return self.mounts.get(part, self.mounts.get(self.channels[channel].source, self.mounts.get("")))

    def idle_mounts(self) -> list[str]:
        """Mounts that no mapped channel has."""
        used = set(PARTS) | {origin.source for origin in self.channels.values()} | {""}
        return [name for name in self.mounts if name not in used]

    def idle_times(self) -> list[str]:
        """Sources of time columns that no mapped channel comes from."""
        used = {origin.source for origin in self.channels.values()}
        return [name for name in self.times if name not in used]


def load_map(path: Path) -> ImportMap:
    """The map in a TOML file; ValueError naming file, key, expected and found."""
    return map_from_table(read_toml(path, "map"), str(path))


def map_from_table(table: Mapping[str, Any], where: str) -> ImportMap:
    """The map in a parsed table; ValueError naming `where`, the key, what was expected and what was found."""
    for key in table:
        if key not in ("channels", "mount", "sources", "clock"):
            raise ValueError(f"{where}: expected tables channels, mount, sources, clock; found {key!r}")
    entries = table.get("channels")
    if not isinstance(entries, dict) or not entries:
        raise ValueError(f"{where}: expected a table [channels] with an entry per channel, found none")
    channels: dict[str, Mapped] = {}
    for name, entry in entries.items():
        if name not in (*CHANNELS, *UNITS_BESIDE):
            raise ValueError(f"{where}: expected channels of {', '.join((*CHANNELS, *UNITS_BESIDE))}; found {name!r}")
        channels[name] = _channel(entry, name, where)
    channels = in_their_place(channels, where)
    if ALL_WHEELS in channels:
        one = channels.pop(ALL_WHEELS)
        channels |= {name: channels.get(name, one) for name in WHEEL_CHANNELS}
    mounts = _mounts(_table(table, "mount", where), where)
    times, clock = _times(_table(table, "sources", where), where), _clock(_table(table, "clock", where), where)
    return ImportMap(channels, mounts, times, *clock)


def _times(table: Mapping[str, Any], where: str) -> dict[str, TimeColumn]:
    found = {}
    for name, entry in table.items():
        at = f"{where}: sources.{name}"
        if not isinstance(entry, dict) or not entry or set(entry) - {"time", "time_unit"}:
            raise ValueError(f'{at}: expected time = "column" and, or, time_unit; found {entry!r}')
        column, unit = entry.get("time", ""), entry.get("time_unit", "")
        if not isinstance(column, str):
            raise ValueError(f"{at}.time: expected the name of a column, found {column!r}")
        if unit not in ("", *SECONDS):
            raise ValueError(f"{at}.time_unit: expected one of {', '.join(SECONDS)}; found {unit!r}")
        found[name] = TimeColumn(column, unit)
    return found


def _clock(table: Mapping[str, Any], where: str) -> tuple[float, float, float]:
    """Rate (Hz, 0 where the yaw rate's own), start and end (s) of the drive."""
    for key in table:
        if key not in CLOCK_KEYS:
            raise ValueError(f"{where}: clock: expected keys of {', '.join(CLOCK_KEYS)}; found {key!r}")
    rate = _number(table.get("rate_hz", 0.0), f"{where}: clock.rate_hz")
    if rate and not 1.0 <= rate <= 1000.0:
        raise ValueError(f"{where}: clock.rate_hz: expected 1 to 1000, found {rate:g}")
    start = _number(table.get("start", 0.0), f"{where}: clock.start")
    end = _number(table["end"], f"{where}: clock.end") if "end" in table else math.inf
    if not 0.0 <= start < end:
        raise ValueError(f"{where}: clock: expected start of 0 s or more and end after it, found start {start:g} and end {end:g}")
    return rate, start, end


def _table(table: Mapping[str, Any], key: str, where: str) -> dict[str, Any]:
    value = table.get(key, {})
    if not isinstance(value, dict):
        raise ValueError(f"{where}: expected a table [{key}], found {value!r}")
    return value


def _channel(entry: Any, name: str, where: str) -> Mapped:
    at = f"{where}: channels.{name}"
    table = entry if isinstance(entry, dict) else {"source": entry}
    source, fields = _source(table.get("source"), at)
    for key in table:
        if key not in CHANNEL_KEYS:
            raise ValueError(f"{at}: expected keys of {', '.join(CHANNEL_KEYS)}; found {key!r}")
    rate, compass = (_flag(table.get(key, False), f"{at}.{key}") for key in ("rate", "compass"))
    plain = CHANNEL_UNITS.get(name, UNITS_BESIDE.get(name, ""))
    if rate and plain not in COUNTED:
        raise ValueError(f"{at}: expected rate for a channel in {' or '.join(COUNTED)}, found one in {plain or '-'}")
    plain, per_radius = (COUNTED[plain], "m") if rate else (plain, "m/s")
    unit = table.get("unit", plain)
    known, factor = UNITS.get(unit, ("", 0.0)) if isinstance(unit, str) else ("", 0.0)
    si = "rad" if (name, known) == (STEER_COMMAND, "rad") else plain
    over_radius = name in (ALL_WHEELS, *WHEEL_CHANNELS) and known == per_radius
    if factor == 0.0 or not (known == si or over_radius):
        units = ", ".join(u for u, (to, _) in UNITS.items() if to == si and u)
        raise ValueError(f"{at}: expected a unit of {units}; found {unit!r}")
    numbers = {key: _number(table.get(key, 1.0), f"{at}.{key}") for key in ("factor", "sign", "ratio")}
    if 0.0 in (numbers["ratio"], numbers["factor"]) or numbers["sign"] not in (1.0, -1.0):
        raise ValueError(f"{at}: expected sign of 1 or -1 and a ratio and factor other than 0, found {table!r}")
    scale = factor * numbers["factor"] * numbers["sign"] / numbers["ratio"]
    pairs = table.get("table")
    bent = None if pairs is None else _pairs(pairs, f"{at}.table")
    offset = _number(table.get("offset", 0.0), f"{at}.offset")
    late = _number(table.get("late", 0.0), f"{at}.late")
    if abs(late) > LATEST:
        raise ValueError(f"{at}.late: expected at most {LATEST:g} s, found {late:g}")
    return Mapped(source, fields, scale, offset, bent, over_radius, compass, rate, late, name == "psi")


def _source(value: Any, at: str) -> tuple[str, tuple[str, ...]]:
    """Source and fields of "source:field", or of a list of such."""
    entries = value if isinstance(value, list) else [value]
    if not entries or not all(isinstance(one, str) and ":" in one for one in entries):
        raise ValueError(f'{at}: expected "source:field", a list of such, or {{source = "source:field", ...}}, found {value!r}')
    parts = [split_label(one) for one in entries]
    if len({source for source, _ in parts}) > 1:
        raise ValueError(f"{at}: expected fields of one source, whose mean it then is; found {value!r}")
    return parts[0][0], tuple(field for _, field in parts)


def split_label(label: str) -> tuple[str, str]:
    """Source and field of "source:field"."""
    table = TABLE_FILE.fullmatch(label)
    source, field_of = table.groups() if table else label.split(":", 1)
    return source.strip(), field_of.strip()


def _pairs(value: Any, where: str) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list) or len(value) < 2 or not all(isinstance(p, list) and len(p) == 2 for p in value):
        raise ValueError(
            f"{where}: expected pairs [[steering-wheel angle, road-wheel angle], ...] in rad, found {value!r}"
        )
    pairs = tuple((_number(a, where), _number(b, where)) for a, b in value)
    if any(b[0] <= a[0] for a, b in zip(pairs, pairs[1:], strict=False)):
        raise ValueError(f"{where}: expected increasing steering-wheel angles, found {value!r}")
    return pairs


def _mounts(table: Mapping[str, Any], where: str) -> dict[str, Mount]:
    plain = {k: v for k, v in table.items() if not isinstance(v, dict)}
    found = {"": _mount(plain, f"{where}: mount")} if plain else {}
    return found | {k: _mount({**plain, **v}, f"{where}: mount.{k}") for k, v in table.items() if isinstance(v, dict)}


def _mount(table: Mapping[str, Any], where: str) -> Mount:
    values: dict[str, Any] = {}
    for key, value in table.items():
        if key not in MOUNT_KEYS:
            raise ValueError(f"{where}: expected keys of {', '.join(MOUNT_KEYS)}; found {key!r}")
        if key in ("frame", "point"):
            allowed = FRAMES if key == "frame" else POINTS
            if value not in allowed:
                raise ValueError(f"{where}.{key}: expected one of {', '.join(allowed)}; found {value!r}")
            values[key] = value
        else:
            values[key] = _number(value, f"{where}.{key}")
    return Mount(**values)


def _flag(value: Any, where: str) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{where}: expected true or false, found {value!r}")
    return value


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{where}: expected a finite number, found {value!r}")
    return float(value)
