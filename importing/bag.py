"""Bags without ROS: rosbag1, rosbag2 (sqlite3, MCAP, compressed), by the library rosbags; messages stream one at a time."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.importing.frames import TRANSFORMS, Transform, frame_of, transforms_of
from softsoil.importing.messages import fields_of, reader_of, stamp_of
from softsoil.importing.sources import BAG_SUFFIXES, Holding, Series, Spread, ordered

SAMPLED = 200
"""Messages of a topic that inspect looks into, from its beginning."""
ANOTHER_CLOCK = 5.0
"""s: header stamps farther than this from the arrival times are of another clock, and are moved by the median difference."""
FARTHEST_PART = 60.0
"""s between the bag files of a folder, of which each goes on where the one before ended."""
LONGEST_OVERLAP = 1.0
"""s by which they may overlap."""
TAILS = (2.0, 20.0, 200.0)
"""s before a bag's end in which a topic's last message is looked for, before all of it is read."""
TELL_EVERY = 2000
"""Messages between two reports of progress."""


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """An open reader of the bag; ValueError where it is none, where it is damaged or where the library is missing."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise ValueError(
            f"{path}: expected the library rosbags for bags, found none: pip install '.[logs]' in the project's folder"
        ) from None
    try:
        with AnyReader(_files(path), default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            _one_recording(path, reader)
            yield reader
    except (AnyReaderError, OSError, KeyError, AssertionError) as error:
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise ValueError(
            f"{path}: expected a rosbag1 or rosbag2 recording, found one that cannot be read: {reason}"
        ) from None


def _files(path: Path) -> list[Path]:
    """What the library is given: a folder with metadata.yaml, or the bag files of a folder without, parts of one recording."""
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        inside = sorted(p for p in path.iterdir() if p.suffix in BAG_SUFFIXES)
        if len({p.suffix for p in inside}) > 1:
            raise ValueError(f"{path}: expected bag files of one kind in the folder, found {', '.join(p.name for p in inside)}")
        return inside
    if path.suffix == ".db3" and (path.parent / "metadata.yaml").is_file():
        return [path.parent]
    return [path]


def _one_recording(path: Path, reader: Any) -> None:
    """Refuse bag files of a folder that are no parts of one recording: far from each other in time, or one topic at one time."""
    parts = sorted((part for part in reader.readers if part.message_count), key=lambda part: int(part.start_time))
    for before, after in pairwise(parts):
        gap = (after.start_time - before.end_time) * 1e-9
        shared = {c.topic for c in before.connections if c.msgcount} & {c.topic for c in after.connections if c.msgcount}
        if gap > FARTHEST_PART or (shared and gap < -LONGEST_OVERLAP):
            where = f"{gap:.0f} s after the end of" if gap > 0.0 else f"with {min(shared)} at the same time as"
            raise ValueError(
                f"{path}: expected parts of one recording in the folder, found {after.path.name} {where} {before.path.name}: "
                "give one of them by its file's name"
            )


def inspect_bag(path: Path, progress: Callable[[float], None] = lambda share: None) -> list[Holding]:
    """Every topic of a bag with its rate, clock and the spread of its fields; progress: called with the share done."""
    found = []
    with opened(path) as reader:
        by_topic: dict[str, list[Any]] = {}
        for connection in reader.connections:  # one for each publisher
            by_topic.setdefault(connection.topic, []).append(connection)
        for i, connections in enumerate(by_topic.values()):
            found.append(_topic(reader, connections, str(path)))
            progress((i + 1) / len(by_topic))
    return [holding for holding in found if holding.count]


def _topic(reader: Any, connections: Sequence[Any], file: str) -> Holding:
    samples: dict[str, list[float]] = {}
    arrivals, stamps, frame = [], [], ""
    transforms: dict[str, Transform] = {}
    first, count = connections[0], sum(int(connection.msgcount) for connection in connections)
    for connection, arrival, raw in reader.messages(connections=connections):
        message = _message(reader, connection, raw)
        if message is None:
            break
        arrivals.append(arrival * 1e-9)
        stamps.append(stamp_of(message))
        frame = frame or frame_of(message)
        if connection.msgtype.endswith(TRANSFORMS):
            transforms |= {one.child: one for one in transforms_of(message)}
        for key, value in fields_of(message):
            samples.setdefault(key, []).append(value)
        if len(arrivals) >= SAMPLED:
            break
    stamped = bool(stamps) and bool(np.isfinite(stamps).all())
    clock = np.sort(np.array(stamps if stamped else arrivals))
    steps = np.diff(clock)
    rate = float(1.0 / np.median(steps)) if len(steps) and np.median(steps) > 0 else float("nan")
    spreads = {key: Spread.of(np.array(values)) for key, values in samples.items()}
    start = float(clock[0]) if len(clock) else float("nan")
    late = float(np.median(np.array(arrivals) - stamps)) if stamped else 0.0
    stop = _last_arrival(reader, connections) - late if len(clock) else start
    return Holding(first.topic, first.msgtype, file, count, rate, start, max(start, stop),
                   "header stamps" if stamped else "arrival", spreads, frame, tuple(transforms.values()))  # fmt: skip


def _last_arrival(reader: Any, connections: Sequence[Any]) -> float:
    """Time (s) at which the last of the connections' messages came."""
    for tail in (*(reader.end_time - int(seconds * 1e9) for seconds in TAILS), reader.start_time):
        arrivals = [arrival for _, arrival, _ in reader.messages(connections=connections, start=max(tail, reader.start_time))]
        if arrivals:
            return float(arrivals[-1]) * 1e-9
    return float("nan")


def _message(reader: Any, connection: Any, raw: bytes) -> Any:
    """The message, or None for a type that the bag does not define."""
    try:
        return reader.deserialize(raw, connection.msgtype)
    except (KeyError, ValueError):
        return None
    except Exception as error:
        if type(error).__module__.startswith("rosbags"):
            return None
        raise


def topics_of(path: Path) -> list[str]:
    """Names of a bag's topics."""
    with opened(path) as reader:
        return sorted({connection.topic for connection in reader.connections})


def read_bag(
    path: Path, wanted: Mapping[str, Sequence[str]], progress: Callable[[float], None] = lambda share: None
) -> list[Series]:
    """The wanted fields of the wanted topics, streamed: memory holds the numbers asked for, never a message twice.

    wanted: topic -> paths of fields, those that the bag lacks are left out; progress: called with the share of messages read.
    """
    readers = {topic: {name: reader_of(name) for name in names} for topic, names in wanted.items()}
    clocks = {topic: (array("d"), array("d")) for topic in wanted}
    numbers = {topic: array("d") for topic in wanted}
    headed: set[str] = set()
    with opened(path) as reader:
        chosen = [c for c in reader.connections if c.topic in wanted]
        total, done = max(sum(c.msgcount for c in chosen), 1), 0
        if not chosen:
            return []
        for connection, arrival, raw in reader.messages(connections=chosen):
            message = _message(reader, connection, raw)
            done += 1
            if done % TELL_EVERY == 0:
                progress(done / total)
            if message is None:
                continue
            arrivals, stamps = clocks[connection.topic]
            arrivals.append(arrival * 1e-9)
            stamps.append(stamp_of(message))
            if hasattr(message, "header"):
                headed.add(connection.topic)
            numbers[connection.topic].extend([read(message) for read in readers[connection.topic].values()])
    there = {connection.topic for connection in chosen if connection.msgcount}
    return [_series(topic, clocks[topic], numbers[topic], list(names), topic in headed)
            for topic, names in wanted.items() if topic in there]  # fmt: skip


def _series(topic: str, clocks: tuple[array, array], numbers: array, names: list[str], headed: bool) -> Series:
    arrivals, stamps = (np.frombuffer(clock) if len(clock) else np.zeros(0) for clock in clocks)
    rows = np.frombuffer(numbers).reshape(-1, len(names)) if len(numbers) else np.zeros((0, len(names)))
    notes: tuple[str, ...] = ()
    t = arrivals
    if len(stamps) and np.isfinite(stamps).mean() > 0.99:
        away = float(np.nanmedian(arrivals - stamps))
        t = stamps
        if abs(away) > ANOTHER_CLOCK:
            t = stamps + away
            notes = (f"{topic}: header stamps are {away:.3g} s behind their arrival, of another clock; moved by that",)
    elif headed and len(stamps):
        notes = (f"{topic}: its header stamps are zero; times of arrival are taken, which transport makes late and uneven",)
    return ordered(topic, t.copy(), {name: rows[:, i].copy() for i, name in enumerate(names)}, notes)
