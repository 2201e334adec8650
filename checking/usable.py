"""A log as estimates use it: from a file, a table in memory or a drive; its channels checked against each other and completed."""

from __future__ import annotations

import warnings as python_warnings
from dataclasses import replace
from pathlib import Path

import pandas as pd

from softsoil.checking.cross_check import check_channels, refuse_contradictions, warnings
from softsoil.checking.geometry_check import beyond_doubt
from softsoil.checking.own_ruts import with_ruts
from softsoil.checking.place import without_misplaced
from softsoil.recording.clock import on_coarse_clock
from softsoil.recording.columns import Source
from softsoil.recording.derive import completed
from softsoil.recording.drive import CHANNEL_UNITS, CHECKED, Recording
from softsoil.recording.forward import with_note_of_gaps, with_note_of_reversing
from softsoil.recording.geometry import Geometry
from softsoil.recording.outliers import without_absurd, without_glimpses
from softsoil.recording.plausible import check_units
from softsoil.recording.read import as_drive


def checked(drive: Recording, geometry: Geometry, late_steering: float = 0.0) -> tuple[Recording, tuple[str, ...]]:
    """The drive marked as checked, with what is doubtful in its notes; and the doubts, one sentence each.

    geometry: of the vehicle; late_steering: seconds by which its road wheels are known to follow `steer`. Raises ValueError for
    channels that contradict each other beyond doubt.
    """
    where, drive = drive.meta.get("path", drive.name), without_glimpses(drive)
    check_units(Path(where), {name: Source(name) for name in CHANNEL_UNITS}, drive.channels)
    checks = check_channels(drive, geometry, late_steering)
    refuse_contradictions(where, checks)
    doubts = warnings(checks)
    notes = (*drive.notes, *(f"warning: {doubt}" for doubt in doubts))
    return mark_checked(without_misplaced(replace(drive, notes=notes), checks)), doubts


def mark_checked(drive: Recording) -> Recording:
    """The drive with the mark that its channels have been checked; `Recording.with_channels` takes it off."""
    return replace(drive, meta={**drive.meta, CHECKED: "yes"})


def usable(
    log: Recording | pd.DataFrame | str | Path, geometry: Geometry | None, late_steering: float = 0.0
) -> Recording:
    """The drive that an estimate runs on: opened, checked once, on a clock no faster than needed, absent channels derived and
    marked.

    log: a drive, a table with the default columns, or a file; geometry: of the vehicle, None where it is not known: nothing is
    checked or derived then; late_steering: as of `checked`. A doubtful channel, or wheels and axles of another vehicle, are a
    UserWarning. Raises ValueError for channels that contradict each other beyond doubt, or where speed, yaw rate or steering
    angle is absent.
    """
    drive = without_absurd(as_drive(log))
    if geometry is None:
        return drive
    if CHECKED in drive.meta:
        return whole(on_coarse_clock(drive), geometry)
    drive, doubts = checked(drive, geometry, late_steering)
    drive = whole(on_coarse_clock(drive), geometry)
    words = [f"{drive.name}: {doubt}" for doubt in doubts]
    if another := beyond_doubt(drive, geometry):
        words.append(f"{another}: another vehicle, or a sensor that is wrong")
    for doubt in words:
        python_warnings.warn(doubt, UserWarning, stacklevel=3)
    return drive


def whole(drive: Recording, geometry: Geometry) -> Recording:
    """The drive with absent channels derived, its own ruts, and notes of what no model runs across; geometry: of the vehicle."""
    return with_note_of_gaps(with_note_of_reversing(with_ruts(completed(drive, geometry), geometry)))
