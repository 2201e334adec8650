"""What a recording holds: sources (bag topics or tables), each with fields, rate and clock; and its samples as series."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from softsoil.importing.frames import Transform
from softsoil.recording.drive import Array

BAG_SUFFIXES = (".bag", ".mcap", ".db3")
TABLE_SUFFIXES = (".csv", ".csv.gz", ".tsv", ".tsv.gz", ".txt", ".parquet")
GAP = 2.5
"""A step longer than this many median steps is a gap."""


@dataclass(frozen=True)
class Spread:
    """Values of a field as sampled: least, largest, whether they change; unit: as the file says it, empty where it does not;
    median: NaN where it is not known."""

    least: float
    largest: float
    changes: bool
    unit: str = ""
    median: float = float("nan")

    @classmethod
    def of(cls, values: Array, unit: str = "") -> Spread:
        """That of the numbers among values (N,)."""
        good = values[np.isfinite(values)]
        if not len(good):
            return cls(float("nan"), float("nan"), False, unit)
        return cls(float(good.min()), float(good.max()), bool(np.ptp(good) > 0), unit, float(np.median(good)))

    @property
    def middle(self) -> float:
        """Its median, or half way between least and largest."""
        return self.median if np.isfinite(self.median) else 0.5 * (self.least + self.largest)


@dataclass(frozen=True)
class Holding:
    """One source of a recording.

    name: topic or file name; kind: message type or "table"; file; count: messages or rows; rate_hz; start_s, stop_s: of its
    clock; clock: "header stamps", "arrival" or the column that is the time; fields: path or column -> spread of sampled values;
    frame: of its values, where it names one; transforms: between frames, that it holds.
    """

    name: str
    kind: str
    file: str
    count: int
    rate_hz: float
    start_s: float
    stop_s: float
    clock: str
    fields: Mapping[str, Spread] = field(default_factory=dict)
    frame: str = ""
    transforms: tuple[Transform, ...] = ()

    def as_json(self) -> dict[str, object]:
        """The entry of inspect.json."""
        fields = {
            k: {"min": s.least, "max": s.largest, "changes": s.changes, "unit": s.unit} for k, s in self.fields.items()
        }
        return {"name": self.name, "kind": self.kind, "file": self.file, "count": self.count, "rate_hz": self.rate_hz,
                "start_s": self.start_s, "stop_s": self.stop_s, "clock": self.clock, "frame": self.frame,
                "fields": fields}  # fmt: skip


@dataclass(frozen=True)
class Series:
    """Samples of one source.

    name; t (N,): increasing times (s) on the source's clock; values: field -> (N,), NaN where a sample lacks it; notes; origin:
    latitude and longitude (deg) of the local frame of its fields east and north.
    """

    name: str
    t: Array
    values: Mapping[str, Array]
    notes: tuple[str, ...] = ()
    origin: tuple[float, float] | None = None

    @property
    def rate_hz(self) -> float:
        """One over the median step."""
        return float(1.0 / np.median(np.diff(self.t))) if len(self.t) > 1 else float("nan")

    @property
    def gaps(self) -> int:
        """Number of steps longer than GAP median steps."""
        steps = np.diff(self.t)
        return int(np.sum(steps > GAP * np.median(steps))) if len(steps) else 0


RESTART, RESTART_SAMPLES = 0.25, 5
"""s, samples: a clock that stays so far behind where it was, for so many samples, has been set back."""


def ordered(name: str, t: Array, values: Mapping[str, Array], notes: tuple[str, ...] = ()) -> Series:
    """A series called `name`, its samples values (N,) in order of t (N,); one sample per time, none without.

    Single samples that come late are put in their place. Raises ValueError for a clock that was set back.
    """
    good = np.isfinite(t)
    _refuse_restart(name, t[good])
    order = np.argsort(np.where(good, t, np.inf), kind="stable")[: int(good.sum())]
    keep = np.ones(len(order), dtype=bool)
    keep[1:] = np.diff(t[order]) > 0
    dropped, unordered = len(t) - int(keep.sum()), int(np.sum(np.diff(t[good]) < 0))
    if dropped:
        notes = (*notes, f"{name}: {dropped} samples without a time of their own left out")
    if unordered:
        notes = (*notes, f"{name}: {unordered} samples out of order sorted by their time")
    order = order[keep]
    return Series(name, t[order], {key: v[order] for key, v in values.items()}, notes)


def _refuse_restart(name: str, t: Array) -> None:
    if len(t) < 2 * RESTART_SAMPLES or np.mean(np.diff(t) < 0) > 0.01:  # rows in another order than that of time are sorted
        return
    ahead = np.maximum.accumulate(t)
    count = np.cumsum(np.r_[0, ahead - t > RESTART])
    run = np.flatnonzero(count[RESTART_SAMPLES:] - count[:-RESTART_SAMPLES] == RESTART_SAMPLES)
    if len(run):
        first = int(run[0])
        raise ValueError(
            f"{name}: sample {first + 1}: expected a clock that runs forward, found {t[first]:.6g} s after {ahead[first]:.6g} s: "
            "it was set back or restarted; import each part as a recording of its own"
        )


def is_bag(path: Path) -> bool:
    """Whether the path is a bag: a .bag, .mcap or .db3 file, or a folder with metadata.yaml or such a file."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file() or any(any(path.glob(f"*{suffix}")) for suffix in BAG_SUFFIXES)
    return path.suffix in BAG_SUFFIXES


def is_table(path: Path) -> bool:
    """Whether the path is a table by its name."""
    return path.is_file() and path.name.endswith(TABLE_SUFFIXES)


def check_source(path: Path) -> None:
    """Raise ValueError where there is no recording at the path."""
    if not path.exists():
        raise ValueError(f"{path}: expected a bag or a table, found no such file")
    if not (is_bag(path) or is_table(path)):
        kinds = ", ".join((*BAG_SUFFIXES, *TABLE_SUFFIXES))
        raise ValueError(f"{path}: expected a bag (file or folder) or a table ({kinds}), found neither")
