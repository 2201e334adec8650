"""A map of the soil from drives: which of them are laid on it, in one frame, and n of a place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from softsoil.checking.usable import usable
from softsoil.declaration.ground import refuse_hard_ground
from softsoil.declaration.handed import check_model
from softsoil.declaration.late_steering import late_steering
from softsoil.estimator.horizons import START_UP
from softsoil.mapping.cells import Cell, fuse
from softsoil.mapping.drive_soil import DriveSoil, drive_soil, unusable
from softsoil.mapping.frame import Origin, frame_of, placed
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import distinct
from softsoil.symbolic.model import Model

USED = ("identified", "not_excited")
"""Verdicts of drives that a map uses: one that says too little adds what little it says."""


@dataclass(frozen=True)
class SoilMap:
    """The sinkage exponent per cell of the ground.

    size: of a cell (m); cells: known ones; origin: latitude and longitude (deg) of x = y = 0, None where that is not known;
    drives: all that were given, `left_out` of each that is not on the map says why; driven: cells that those on it ran through,
    known or not.
    Example: softsoil.SoilMap(10.0, ()).at(3.0, 4.0) is None
    """

    size: float
    cells: tuple[Cell, ...]
    origin: tuple[float, float] | None = None
    drives: tuple[DriveSoil, ...] = ()
    driven: int = 0

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


def map_soil(
    logs: Sequence[Recording | pd.DataFrame | str | Path], model: Model, n0: float | None = None, *,
    cell: float = 10.0, everything: bool = False, start: float = START_UP, origin: Origin = None,
) -> SoilMap:  # fmt: skip
    """The soil along the way of drives over one piece of ground, per cell, from sensor channels only.

    logs: drives, files or tables, with measured positions; model: with declared effects; n0: initial guess of n (default: the
    soil's); cell: size of a cell (m); everything: also drives whose verdict says not to use their n; start: seconds left out at
    the beginning; origin: latitude and longitude (deg) of the map's frame, default as of `frame_of`. Where none
    has one, logs are taken to share one frame. Drives that are not on the map stand in `drives`, with why. Raises ValueError
    where no drive is on it, for a model of hard ground, and for an origin to logs that have none, TypeError for what is no model.

    Example:
        >>> import softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> ground = softsoil.map_soil([softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 14.0)], model)
        >>> cell = ground.at(45.0, -5.0)
        >>> cell.verdict, bool(abs(cell.n - 0.5) < 3.0 * cell.std)
        ('identified', True)
    """
    check_model("map_soil", model)
    refuse_hard_ground(model)
    drives = distinct([usable(log, model.geometry, late_steering(model.geometry)) for log in logs])
    frame = frame_of(drives, origin)
    guess = float(model.p["n_f"].nominal) if n0 is None else n0
    reasons = placed(drives, frame, cell)
    return laid([surveyed(*each, model, guess, start) for each in zip(drives, reasons, strict=True)], frame, cell, everything)


def surveyed(recording: Recording, why: str, model: Model, n0: float, start: float = START_UP) -> DriveSoil:
    """As `drive_soil`, and one that is left out, with the reason, for a drive that is not to be on a map (why: as of `placed`) or
    that the model cannot use.

    recording: `usable`; model, n0, start: as of `drive_soil`.
    """
    if not why:
        try:
            return drive_soil(recording, model, n0, start)
        except ValueError as error:
            why = str(error)
    return unusable(recording.name, why, recording.origin, recording.notes)


def laid(surveys: Sequence[DriveSoil], frame: Origin, size: float, everything: bool = False) -> SoilMap:
    """The map of drives in one frame.

    surveys: `surveyed` drives; frame: as of `frame_of`; size: of a cell (m); everything: also drives whose verdict says not to
    use their n. Raises ValueError where nothing is left.
    """
    drives = []
    for one in surveys:
        why = one.left_out
        if not why and not everything and one.verdict is not None and one.verdict.word not in USED:
            why = f"its verdict is {one.verdict.word}"
        drives.append(replace(one, left_out=why) if why else one.moved(frame))
    used = [one for one in drives if not one.left_out]
    if not used:
        why = "; ".join(f"{one.log}: {one.left_out}" for one in drives)
        raise ValueError(f"map: expected a drive that can be laid on it, found none ({why})")
    if not (cells := fuse(used, size)):
        raise ValueError(f"map: expected two windows of a second in a cell, found none: cells of {size:g} m are too small")
    ways = np.concatenate([one.way for one in used])
    driven = len({(int(c), int(r)) for c, r in np.floor(ways[np.isfinite(ways).all(axis=1)] / size)})
    return SoilMap(size, cells, frame, tuple(drives), driven)
