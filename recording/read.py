"""A drive from a file: columns to channels in SI units, with clock, gaps, missing values and units checked and reported."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsoil.recording.between import only_samples
from softsoil.recording.columns import Source
from softsoil.recording.drive import CHANNEL_UNITS, TRUTH_PREFIX, Array, ChannelState, Recording
from softsoil.recording.log_names import log_name
from softsoil.recording.outliers import without_absurd, without_outliers
from softsoil.recording.plausible import check_units
from softsoil.recording.table import numbers, read_table

REQUIRED = ("t", "u", "omega_z", "steer")
"""The least that a drive has; `softsoil.recording.derive.completed` derives and marks the rest."""
STATES_KEY = "softsoil_channel_states"
"""Key of the metadata of a Parquet file under which the channels' states stand."""
ORIGIN_KEY = "softsoil_origin"
"""Key of that metadata under which latitude and longitude (deg) of the drive's frame stand."""
NAME_KEY = "softsoil_name"
"""Key of that metadata under which the name of what was imported stands."""
IMPORTED = "drive.parquet"
"""What an import calls its drive's file; such a drive has the name of what was imported, every other file's its own."""
TABLE_NAME = "table"
"""Name of a drive from a table in memory."""
SET_BACK, SET_BACK_ROWS = 0.25, 5
"""s, rows: a clock that stays so far behind where it was, for so many rows, has been set back; else a row is late."""
GAP_STEPS = 2.5
"""A step longer than this many median steps is reported as a gap."""
REGULAR = 0.9
"""Share of the steps between a channel's values, in rows, that are as usual: the sensor is slower than the clock."""


def read_drive(
    path: str | Path, columns: Mapping[str, Source] | None = None, required: tuple[str, ...] = REQUIRED
) -> Recording:
    """A drive from CSV, CSV.gz or Parquet.

    columns: channel -> source, for channels whose column has another name or unit; required: channels that must be there.
    `true_*` columns go into `truth`. Missing values stay NaN and are noted, as are gaps in time.
    Raises ValueError naming file, column, row, what was expected and what was found.

    Example:
        >>> import softsoil
        >>> drive = softsoil.read_drive(softsoil.example_logs()[0])
        >>> drive.name, round(drive.dt, 3)
        ('multi_clay_n0.50', 0.012)
    """
    path = Path(path)
    return _drive(read_table(path), path, columns, required, {"path": str(path)})


def _drive(
    table: pd.DataFrame,
    path: Path,
    columns: Mapping[str, Source] | None,
    required: tuple[str, ...],
    meta: Mapping[str, str],
) -> Recording:
    sources = {name: Source(name) for name in CHANNEL_UNITS} | dict(columns or {})
    channels: dict[str, Array] = {}
    for name, source in sources.items():
        if name in required or source.column in table.columns or name in (columns or {}):
            channels[name] = numbers(table, source.column, path) * source.factor + source.offset
    _check_clock(path, sources["t"].column, channels["t"])
    notes = _check_values(path, sources, channels, required)
    notes += _gaps(channels["t"])
    check_units(path, sources, channels)
    truth = {str(c): numbers(table, str(c), path) for c in table.columns if str(c).startswith(TRUTH_PREFIX)}
    states, origin = _states(path, table, channels), _origin(path, table)
    kept = table.attrs.get(NAME_KEY) if path.name == IMPORTED else None
    # Results are called by it: no name leads out of their folder.
    name = (re.sub(r"[\\/]", "_", kept).lstrip(".") if isinstance(kept, str) else "") or log_name(path)
    recording = Recording(name, channels, truth, tuple(notes), meta, states, origin)
    return without_outliers(only_samples(without_absurd(recording)))


def _origin(path: Path, table: pd.DataFrame) -> tuple[float, float] | None:
    """Latitude and longitude (deg) of x = y = 0 that an imported drive carries in its metadata."""
    kept = table.attrs.get(ORIGIN_KEY)
    if kept is None:
        return None
    if not isinstance(kept, list) or len(kept) != 2 or not all(isinstance(value, float) for value in kept):
        raise ValueError(f"{path}: metadata {ORIGIN_KEY}: expected latitude and longitude in degrees, found {kept!r}")
    return kept[0], kept[1]


def _states(path: Path, table: pd.DataFrame, channels: Mapping[str, Array]) -> dict[str, ChannelState]:
    """States that an imported drive carries in its metadata, of the channels that it has."""
    kept = table.attrs.get(STATES_KEY, {})
    if not isinstance(kept, dict) or not all(value in ("measured", "derived", "absent") for value in kept.values()):
        raise ValueError(f"{path}: metadata {STATES_KEY}: expected a state of each channel, found {kept!r}")
    return {name: state for name, state in kept.items() if name in channels}


def as_drive(log: Recording | pd.DataFrame | str | Path) -> Recording:
    """The drive itself, or from a table in memory or a file with the default columns."""
    if isinstance(log, pd.DataFrame):
        return _drive(log, Path(TABLE_NAME), None, REQUIRED, {})
    return log if isinstance(log, Recording) else read_drive(log)


def write_drive(recording: Recording, path: str | Path, named: bool = False) -> Path:
    """Write a drive as CSV, CSV.gz or Parquet with the default column names; returns the path. Parquet keeps channel
    states, the origin of the frame and, where it is `named`, what an import calls it.

    Example:
        >>> import softsoil, tempfile
        >>> drive = softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 1.0)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = softsoil.write_drive(drive, f"{folder}/short.csv")
        ...     len(softsoil.read_drive(path)) == len(drive)
        True
    """
    path = Path(path)
    table = pd.DataFrame({**recording.channels, **recording.truth})
    table.attrs[STATES_KEY] = {name: recording.state_of(name) for name in recording.channels}
    if named:
        table.attrs[NAME_KEY] = recording.name
    if recording.origin is not None:
        table.attrs[ORIGIN_KEY] = list(recording.origin)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".parquet":
        table.to_parquet(path, index=False)
    else:
        table.to_csv(path, index=False)
    return path


def _check_clock(path: Path, column: str, t: Array) -> None:
    bad = ~np.isfinite(t)
    if bad.any():
        row = int(np.argmax(bad))
        raise ValueError(f"{path}: column {column!r}, row {row + 1}: expected a time in s, found {t[row]}")
    if len(t) < 2:
        raise ValueError(f"{path}: expected at least 2 rows, found {len(t)}")
    back = np.diff(t) <= 0
    if back.any():
        row = int(np.argmax(back)) + 1
        again = len(t) >= row + SET_BACK_ROWS and t[row : row + SET_BACK_ROWS].max() < t[row - 1] - SET_BACK
        cure = "the clock was set back, or another log begins: split them there" if again else (
            "`softsoil import` puts repeated and late rows in order"
        )
        raise ValueError(
            f"{path}: column {column!r}, row {row + 1}: expected time to increase, found {t[row]:g} after {t[row - 1]:g}: {cure}"
        )


def _check_values(path: Path, sources: Mapping[str, Source], channels: Mapping[str, Array], required) -> list[str]:
    """What the notes say of values that are missing; ValueError for a needed channel of which all are."""
    alike: dict[str, list[str]] = {}
    for name, values in channels.items():
        missing = ~np.isfinite(values)
        if missing.all() and name in required:
            raise ValueError(
                f"{path}: column {sources[name].column!r}: expected numbers, found none in {len(values)} rows"
            )
        if missing.any():
            alike.setdefault(_missing(channels["t"], missing), []).append(name)
    return [f"{', '.join(names)}: {words}" for words, names in alike.items()]


def _missing(t: Array, missing: NDArray[np.bool_]) -> str:
    """In words: a sensor that is slower than the clock t (N,), or values that are missing (N,)."""
    rows = np.flatnonzero(~missing)
    steps = np.diff(rows)
    usual = np.median(steps) if len(steps) else 1.0
    if usual > 1 and np.mean(np.abs(steps - usual) <= 1) > REGULAR:
        apart = np.diff(t[rows])
        rate = 1.0 / float(np.mean(apart[apart <= 1.75 * np.median(apart)]))  # of rows of another clock, now more, now fewer
        return f"of a sensor of {rate:.3g} Hz, in {len(rows)} of {len(t)} rows"
    return f"{int(missing.sum())} of {len(t)} values missing, the first in row {int(np.argmax(missing)) + 1}"


def _gaps(t: Array) -> list[str]:
    steps = np.diff(t)
    typical = float(np.median(steps))
    long = np.flatnonzero(steps > GAP_STEPS * typical)
    return [f"t: gap of {steps[i]:.3g} s after row {i + 1} (typical step {typical:.3g} s)" for i in long[:20]] + (
        [f"t: {len(long) - 20} more gaps"] if len(long) > 20 else []
    )
