"""A map of the soil from drives: which of them are laid on it, in one frame, and n of a place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from softsoil.declaration.ground import refuse_hard_ground
from softsoil.declaration.late_steering import late_steering
from softsoil.estimator.horizons import START_UP
from softsoil.importing.local_frame import other_frame
from softsoil.mapping.cells import Cell, fuse
from softsoil.mapping.drive_soil import DriveSoil, drive_soil, unusable
from softsoil.mapping.place import misplaced
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import distinct
from softsoil.recording.usable import usable
from softsoil.symbolic.model import Model

USED = ("identified", "not_excited")
"""Verdicts of drives that a map uses: one that says too little adds what little it says."""
OFF_THE_MAP = 0.25
"""Cells that a position may leap by."""
FIELD = 2e4
"""m from the first origin within which a drive is on the same piece of ground."""
Origin = tuple[float, float] | None


@dataclass(frozen=True)
class SoilMap:
    """The sinkage exponent per cell of the ground.

    size: of a cell (m); cells: known ones; origin: latitude and longitude (deg) of x = y = 0, None where that is not known;
    drives: all that were given, `left_out` of each that is not on the map says why.
    Example: softsoil.SoilMap(10.0, ()).at(3.0, 4.0) is None
    """

    size: float
    cells: tuple[Cell, ...]
    origin: tuple[float, float] | None = None
    drives: tuple[DriveSoil, ...] = ()

    @cached_property
    def _by_place(self) -> dict[tuple[int, int], Cell]:
        return {(cell.column, cell.row): cell for cell in self.cells}

    def at(self, x: float, y: float) -> Cell | None:
        """The cell of a place x, y (m, in the map's frame), None where nothing is known of it."""
        return self._by_place.get((int(np.floor(x / self.size)), int(np.floor(y / self.size))))

    @property
    def used(self) -> tuple[DriveSoil, ...]:
        """The drives that the map is of."""
        return tuple(one for one in self.drives if not one.left_out)

    @property
    def driven(self) -> int:
        """Cells that the drives of the map ran through, known or not."""
        ways = np.concatenate([one.way for one in self.used] or [np.zeros((0, 2))])
        return len({(int(c), int(r)) for c, r in np.floor(ways[np.isfinite(ways).all(axis=1)] / self.size)})


def map_soil(
    logs: Sequence[Recording | pd.DataFrame | str | Path], model: Model, n0: float | None = None, *,
    cell: float = 10.0, everything: bool = False, start: float = START_UP,
) -> SoilMap:  # fmt: skip
    """The soil along the way of drives over one piece of ground, per cell, from sensor channels only.

    logs: drives, files or tables, with measured positions, in the frame of the first where they have an origin, else taken to
    share one; model: with declared effects; n0: initial guess of n (default: the soil's); cell: size of a cell (m); everything:
    also drives whose verdict says not to use their n; start: seconds left out at the beginning. Drives that are not on the map
    stand in `drives`, with why. Raises ValueError where no drive is on it, for a model of hard ground, and for drives of which
    some have an origin or are farther than FIELD from the first.

    Example:
        >>> import softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> ground = softsoil.map_soil([softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 14.0)], model)
        >>> cell = ground.at(45.0, -5.0)
        >>> cell.verdict, bool(abs(cell.n - 0.5) < 3.0 * cell.std)
        ('identified', True)
    """
    refuse_hard_ground(model)
    drives = distinct([usable(log, model.geometry, late_steering(model.geometry)) for log in logs])
    one_frame(drives)
    guess = float(model.p["n_f"].nominal) if n0 is None else n0
    return laid([surveyed(drive, model, guess, start) for drive in drives], drives, cell, everything)


def surveyed(recording: Recording, model: Model, n0: float, start: float = START_UP) -> DriveSoil:
    """As `drive_soil`, and for a drive that the model cannot use one that is left out, with the reason.

    recording: `usable`; model, n0, start: as of `drive_soil`.
    """
    try:
        return drive_soil(recording, model, n0, start)
    except ValueError as error:
        return unusable(recording.name, str(error), recording.origin, recording.notes)


def laid(surveys: Sequence[DriveSoil], recordings: Sequence[Recording], size: float, everything: bool = False) -> SoilMap:
    """The map of drives in one frame.

    surveys: of each of the recordings; size: of a cell (m); everything: also drives whose verdict says not to use their n.
    Raises ValueError where nothing is left.
    """
    drives = []
    for i, (one, recording) in enumerate(zip(surveys, recordings, strict=True)):
        why = one.left_out or _same_as(recording, recordings[:i]) or misplaced(recording, OFF_THE_MAP * size)
        if not why and not everything and one.verdict is not None and one.verdict.word not in USED:
            why = f"its verdict is {one.verdict.word}"
        drives.append(replace(one, left_out=why))
    used = [one for one in drives if not one.left_out]
    if not used:
        why = "; ".join(f"{one.log}: {one.left_out}" for one in drives)
        raise ValueError(f"map: expected a drive that can be laid on it, found none ({why})")
    origin = one_frame(used)
    drives = [_moved(one, origin) for one in drives]
    cells = fuse([one for one in drives if not one.left_out], size)
    if not cells:
        raise ValueError(f"map: expected two windows of a second in a cell, found none: cells of {size:g} m are too small")
    return SoilMap(size, cells, origin, tuple(drives))


def one_frame(drives: Sequence[Recording] | Sequence[DriveSoil]) -> Origin:
    """The origin of the drives' frame: that of the first.

    Raises ValueError where some have an origin on the globe and others none, or are farther than FIELD from the first.
    """
    first = drives[0].origin
    if {one.origin is None for one in drives} == {True, False}:
        without = next(one for one in drives if one.origin is None)
        name = getattr(without, "log", "") or getattr(without, "name", "")
        raise ValueError(
            f"map: expected a latitude and longitude of the frame of every log or of none; {name} has none: import it with its "
            "fixes"
        )
    for one in drives:
        if one.origin is None or first is None or one.origin == first:
            continue
        (x,), (y,) = other_frame("map", np.zeros(1), np.zeros(1), one.origin, first)
        if (away := float(np.hypot(x, y))) > FIELD:
            raise ValueError(f"map: expected drives over one piece of ground, found one {away / 1e3:.0f} km from the first")
    return first


def _moved(drive: DriveSoil, origin: Origin) -> DriveSoil:
    """A drive in the frame of another origin."""
    if drive.origin is None or origin is None or drive.origin == origin or drive.left_out:
        return drive
    x, y = other_frame("map", drive.x, drive.y, drive.origin, origin)
    way = np.column_stack(other_frame("map", drive.way[:, 0], drive.way[:, 1], drive.origin, origin))
    return replace(drive, x=x, y=y, way=way, origin=origin)


def _same_as(recording: Recording, others: Sequence[Recording]) -> str:
    """Says so where another drive has the same rows."""
    for other in others:
        pairs = ((recording.channels.get(name), other.channels.get(name)) for name in ("x", "y", "u", "omega_z"))
        if all(a is not None and b is not None and np.array_equal(a, b, equal_nan=True) for a, b in pairs):
            return f"it has the rows of {other.name}"
    return ""
