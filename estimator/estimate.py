"""The sinkage exponent of a log by the default policy, the same for the command line, the study and Python."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from softsoil.estimator.horizons import START_UP
from softsoil.estimator.terrain import TerrainEstimate, Tuning, estimate_terrain
from softsoil.recording.drive import Recording
from softsoil.recording.read import as_drive
from softsoil.symbolic.model import Model


def estimate(
    log: Recording | str | Path,
    model: Model,
    n0: float | None = None,
    *,
    start: float = START_UP,
    tuning: Tuning | None = None,
    progress: Callable[[float], None] | None = None,
) -> TerrainEstimate:
    """The sinkage exponent along a log, from sensor channels only, by an unscented Kalman filter (paper, section IV).

    log: a drive or its file; model: with its declared effects, of which any ties n of both axles, as the declared effects say
    what differs between them; without effects front and rear have their own, as in the paper; n0: initial guess (default: the
    soil's); start: seconds left out at the beginning; progress: called with the share that is done.
    Raises ValueError for reversing, an initial guess outside the bounds of n, or a log without the channels.

    Example:
        >>> import softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> drive = softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 12.0)
        >>> found = softsoil.estimate(drive, model, n0=0.7)
        >>> bool(abs(found.n_front[-1] - 0.5) < 0.1)
        True
    """
    first = float(model.p["n_f"].nominal) if n0 is None else n0
    tied = bool(model.effects)
    return estimate_terrain(as_drive(log), model, first, tied=tied, tuning=tuning, start=start, progress=progress)
