"""Tables as loggers write them: comma, semicolon or tab, comments, a row of units, ISO or epoch time, decimal comma."""

from __future__ import annotations

import gzip
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from softsoil.importing.message_columns import with_headings
from softsoil.importing.sources import Holding, Series, Spread, ordered
from softsoil.recording.columns import UNITS
from softsoil.recording.drive import Array
from softsoil.recording.table import cells, read_table

COMMENTS = ("#", "%", "//")
EPOCHS = ((1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3), (1e8, 1.0))
"""A time beyond the first number is counted in units of the second (s)."""
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
"""Unit of a time column -> seconds."""
TIME = re.compile(
    r"_*(t|time|timestamp|stamp|time_?stamp|zeit|sec|secs|seconds|utc|rosbagtimestamp|(field\.)?header\.?_?stamp)"
    r"(_(s|sec|ms|us|ns))?\Z", re.I
)  # fmt: skip
UNIT_IN_NAME = re.compile(r"\s*[\[(]([^\])_]+)[\])]\s*\Z")
FEWEST_NUMBERS = 0.5
"""Share of what stands in a column that must be numbers for it to count as one; a slow sensor's cells are empty in most rows."""


@dataclass(frozen=True)
class TimeColumn:
    """Which column of a table is its time, "" where its name says it; unit: of SECONDS, "" where its name or its size says it."""

    name: str = ""
    unit: str = ""


BY_NAME = TimeColumn()
"""A time column that is recognised by its name."""


@dataclass(frozen=True)
class LooseTable:
    """A table: frame with plain column names, unit of each column where the file says it, and its time column."""

    name: str
    frame: pd.DataFrame
    units: dict[str, str]
    time: TimeColumn


def open_table(path: Path, time: TimeColumn = BY_NAME) -> LooseTable:
    """The table at a path; time: its time column as a map names it.

    Raises ValueError naming the file for a table that cannot be read or has no time.
    """
    frame = read_table(path) if path.name.endswith(".parquet") else _text(path)
    names, units = _without_units(list(map(str, frame.columns)))
    frame = frame.set_axis(names, axis=1)
    if len(frame) and _is_units_row(frame):
        units |= {str(c): str(v).strip("[]() ") for c, v in frame.iloc[0].items() if isinstance(v, str)}
        frame = frame.iloc[1:].reset_index(drop=True)
    chosen = time.name or next((c for c in frame.columns if TIME.match(c)), "")
    if chosen not in frame.columns:
        raise ValueError(f"{path}: expected a time column, found {', '.join(map(str, frame.columns))}: name it in the map: "
                         f'[sources."{path.name}"] time = "column"')  # fmt: skip
    return LooseTable(path.name, with_headings(frame), units, TimeColumn(chosen, time.unit))


def _without_units(columns: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Names of the columns without a unit in brackets at their end, and the units by name; brackets that tell columns from each
    other (velocity[front_left], velocity[front_right]; speed (m/s), speed (km/h)) stay."""
    found = [UNIT_IN_NAME.search(column) for column in columns]
    plain = [UNIT_IN_NAME.sub("", column).strip() for column in columns]
    kept = [bool(one) and plain.count(name) == 1 for one, name in zip(found, plain, strict=True)]
    names = [name if short else column.strip() for column, name, short in zip(columns, plain, kept, strict=True)]
    said = [(name, one.group(1).strip(), short) for name, one, short in zip(names, found, kept, strict=True) if one]
    return names, {name: unit for name, unit, short in said if short or unit in UNITS}


def _text(path: Path) -> pd.DataFrame:
    opener = gzip.open if path.name.endswith(".gz") else open
    try:
        with opener(path, "rb") as file:
            raw = b"".join(line for _, line in zip(range(200), file, strict=False))
        encoding = _encoding(raw)
        lines = raw.decode(encoding, errors="replace").splitlines(keepends=True)
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: expected a table of text, found one that cannot be read: {error}") from None
    skipped = [i for i, line in enumerate(lines) if not line.strip() or line.lstrip().startswith(COMMENTS)]
    body = [line for i, line in enumerate(lines) if i not in skipped]
    separator = max(",;\t", key=lambda mark: body[0].count(mark)) if body else ","
    names = _marked_header(lines, skipped, body, separator)
    if len(body) + (names is not None) < 2:
        raise ValueError(f"{path}: expected a header and rows of data, found {len(body)} lines")
    if not body[0].count(separator):
        raise ValueError(
            f"{path}: expected columns separated by commas, semicolons or tabs, found {body[0].strip()[:60]!r}"
        )
    decimal = "," if separator != "," and re.search(r"\d,\d", body[-1]) and not re.search(r"\d\.\d", body[-1]) else "."
    try:
        return cells(
            path, sep=separator, skiprows=skipped, decimal=decimal, low_memory=False, encoding=encoding, names=names,
            header="infer" if names is None else None,
        )  # fmt: skip
    except (ValueError, pd.errors.ParserError) as error:
        raise ValueError(
            f"{path}: expected a table, found one that cannot be read: {str(error).splitlines()[0]}"
        ) from None


def _marked_header(lines: Sequence[str], skipped: Sequence[int], body: Sequence[str], separator: str) -> list[str] | None:
    """Names of the columns where the last comment above rows of numbers has them, as rostopic ("%time") and NumPy ("# t") write
    it; None where the first line that is no comment does."""
    first = next((i for i in range(len(lines)) if i not in skipped), 0)
    cells = body[0].split(separator) if body else []
    if first == 0 or not all(_number(cell.replace(",", ".")) or not cell.strip() for cell in cells):
        return None
    marked = lines[first - 1].lstrip()
    mark = next((mark for mark in COMMENTS if marked.startswith(mark)), "")
    names = [name.strip() for name in marked.removeprefix(mark).split(separator)]
    return names if mark and len(names) == len(cells) and all(names) else None


def _encoding(raw: bytes) -> str:
    """UTF-8, or those that programs under Windows write: UTF-16 with its mark, or a code page for degree signs and umlauts."""
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    try:
        raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


def _is_units_row(frame: pd.DataFrame) -> bool:
    """Whether the first row has words in half of the columns where the second has none: times and modes have them in both."""
    if len(frame) < 2:
        return False
    first, second = ([isinstance(v, str) and not _number(v) for v in frame.iloc[row]] for row in (0, 1))
    words = [one for one, other in zip(first, second, strict=True) if not other]
    return bool(words) and sum(words) >= 0.5 * len(words) and any(_number(v) for v in frame.iloc[1])


def _number(value: object) -> bool:
    try:
        return np.isfinite(float(value))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False


def seconds(table: LooseTable, where: str) -> Array:
    """(N,) time of a table in seconds: a number in the unit given, the column's or by epoch size, or ISO 8601 text.

    where: for messages.
    """
    column = table.frame[table.time.name]
    values = pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)
    if np.isfinite(values).mean() < FEWEST_NUMBERS:
        stamps = pd.to_datetime(column, errors="coerce", utc=True, format="ISO8601")
        if stamps.isna().mean() > 1.0 - FEWEST_NUMBERS:
            first = column.iloc[0]
            raise ValueError(
                f"{where}: column {table.time.name!r}, row 1: expected seconds, an epoch or ISO 8601, found {first!r}"
            )
        zero = pd.Timestamp(0, tz="UTC")
        return ((stamps - zero) / pd.Timedelta(seconds=1)).to_numpy(dtype=float)
    named = table.time.unit or table.units.get(table.time.name) or table.time.name.lower().rpartition("_")[2]
    typical = float(np.nanmedian(np.abs(values)))
    return values * (SECONDS.get(named) or next((factor for least, factor in EPOCHS if typical > least), 1.0))


def column(table: LooseTable, name: str, where: str) -> Array:
    """(N,) numbers of the column called `name`; ValueError naming the file (`where`), the column and what there is."""
    if name not in table.frame.columns:
        raise ValueError(
            f"{where}: expected columns of {', '.join(map(str, table.frame.columns))}; found none called {name!r}"
        )
    values = pd.to_numeric(table.frame[name], errors="coerce").to_numpy(dtype=float)
    if not np.isfinite(values).any():
        raise ValueError(f"{where}: column {name!r}: expected numbers, found none in {len(values)} rows")
    return values


def inspect_table(path: Path, progress: Callable[[float], None] = lambda share: None) -> list[Holding]:
    """The table as one source with the spread of its columns; progress: called with the share done."""
    table = open_table(path)
    t = seconds(table, str(path))
    spreads = {}
    for name in table.frame.columns:
        values = pd.to_numeric(table.frame[name], errors="coerce").to_numpy(dtype=float)
        good = values[np.isfinite(values)]
        filled = int(table.frame[name].notna().sum())
        if name != table.time.name and len(good) >= max(FEWEST_NUMBERS * filled, 1):
            spreads[str(name)] = Spread.of(values, table.units.get(str(name), ""))
    steps = np.diff(t[np.isfinite(t)])
    rate = float(1.0 / np.median(steps)) if len(steps) and np.median(steps) > 0 else float("nan")
    progress(1.0)
    return [
        Holding(
            path.name, "table", str(path), len(t), rate, float(np.nanmin(t)), float(np.nanmax(t)), table.time.name, spreads
        )
    ]


def read_columns(path: Path, names: Sequence[str], time: TimeColumn = BY_NAME) -> Series:
    """The columns called `names` of a table as a series; time: its time column."""
    table = open_table(path, time)
    values = {name: column(table, name, str(path)) for name in names}
    return ordered(table.name, seconds(table, str(path)), values)
