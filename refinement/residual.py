"""What a model leaves unexplained in a drive: per channel, axle and horizon, integrated over shooting windows.

Differences of noisy samples say nothing, so nothing is differentiated. Channels and horizons: in each window the model runs
free from the recorded state, and the residual is what the recorded states depart from it. Axles: a window's free run would
answer a missing force with a little side slip and hide it, so there the model's accelerations are taken at the recorded
states and integrated; the slope of what recorded v and omega_z depart from that integral is the mean of the missing
acceleration under a parabolic weight. The two are split over the axles:
dF_f = (M l_r e_v + I e_r)/L, dF_r = (M l_f e_v - I e_r)/L.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from softsoil.checking.usable import usable
from softsoil.declaration.handed import check_declaration
from softsoil.declaration.late_steering import late_steering
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.consistency import whiteness_p
from softsoil.estimator.horizons import HORIZONS, START_UP, Replay
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import check_n
from softsoil.symbolic.vehicle import Vehicle

Array = NDArray[np.float64]

WINDOW = 0.5
"""s: shooting window of the channel and axle residuals; short enough that errors do not feed back on themselves."""
FEWEST = 4
"""Measured rows of a window that its rates need."""
JUDGED_BY = ("v", "omega_z")
"""States whose rates say what force an axle lacks."""


@dataclass(frozen=True)
class DriveResidual:
    """What the model leaves unexplained in one drive.

    t (M,): middle of each window (s); end (M, 6): recorded - predicted state at the end of each window, in the order of
    STATE_CHANNELS; rate_v, rate_r (M,): unexplained dv/dt (m/s^2) and d(omega_z)/dt (rad/s^2); force_f, force_r (M,): the
    same as lateral force of each axle (N); mse: horizon -> state -> mean squared error.
    """

    t: Array
    end: Array
    rate_v: Array
    rate_r: Array
    force_f: Array
    force_r: Array
    mse: dict[str, dict[str, float]]

    @property
    def channels(self) -> dict[str, dict[str, float]]:
        """State -> rms of the end-of-window residual, and the p-value of its whiteness from window to window."""
        return {
            name: {"rms": rms(self.end[:, i]), "whiteness_p": whiteness_p(self.end[:, i])}
            for i, name in enumerate(STATE_CHANNELS)
        }

    @property
    def axles(self) -> dict[str, dict[str, float]]:
        """Axle -> rms of the unexplained lateral force (N)."""
        return {"front": {"rms": rms(self.force_f)}, "rear": {"rms": rms(self.force_r)}}


def residual(
    log: Recording | pd.DataFrame | str | Path, declaration: Declaration, n: float | None = None, *, start: float = START_UP
) -> DriveResidual:
    """What a declared model leaves unexplained in a log, per channel, axle and horizon.

    log: a drive, file or table, checked and completed as by `estimate`; n: sinkage exponent of both axles, default the soil's;
    start: seconds left out at the beginning.
    Raises ValueError for an n outside its bounds, or a log with no whole window after the start-up, TypeError for what is no
    declaration.

    Example:
        >>> import softsoil
        >>> vehicle, soil = softsoil.load_vehicle("reference"), softsoil.load_soil("clay")
        >>> log = softsoil.example_logs()[0]
        >>> full = softsoil.residual(log, softsoil.Declaration(vehicle, soil))
        >>> paper = softsoil.residual(log, softsoil.Declaration(softsoil.load_vehicle("paper"), soil))
        >>> full.axles["rear"]["rms"] < paper.axles["rear"]["rms"]
        True
    """
    check_declaration("residual", declaration)
    if n is not None:
        check_n("n", n)
    model = declaration.build()
    p = model.p.pack() if n is None else model.p.pack(n_f=n, n_r=n)
    vehicle = declaration.vehicle
    return drive_residual(usable(log, vehicle, late_steering(vehicle)), model, vehicle, p, start)


def drive_residual(
    recording: Recording, model: Model, vehicle: Vehicle, p: ArrayLike | None = None, start: float = START_UP
) -> DriveResidual:
    """The residual of `model` with parameters p (n_p,), default nominal, on a drive.

    vehicle: its mass, inertia and axle distances split the residual; start: seconds left out at the beginning.
    Raises ValueError for a log with no whole window after the start-up.
    """
    p = model.p.nominal if p is None else np.asarray(p, dtype=float)
    replay = Replay(recording, model, start)
    windows = replay.windows(p, WINDOW)
    if not len(windows.rows):
        held = max(float(replay.t[-1] - replay.t[0]), 0.0)
        raise ValueError(
            f"{recording.name}: expected more than {start + WINDOW:g} s of forward driving in which a window begins where all "
            f"states are measured, found {'none in ' if held > start + WINDOW else ''}{held:.4g} s"
        )
    departure = -windows.error
    clock = np.asarray(replay.dt * np.arange(departure.shape[1]), dtype=float)
    integral = np.vstack([np.zeros(len(STATE_CHANNELS)), np.cumsum(replay.rates(p), axis=0) * replay.dt])
    apart = replay.true_record(p) - integral  # NaN for a derived channel: it judges no force
    within = windows.rows[:, None] + np.arange(departure.shape[1])
    rate_v, rate_r = (slope(clock, apart[within, STATE_CHANNELS.index(name)]) for name in ("v", "omega_z"))
    force_f, force_r = split_by_axle(rate_v, rate_r, vehicle)
    t = replay.t[windows.rows] + clock[-1] / 2
    return DriveResidual(t, departure[:, -1], rate_v, rate_r, force_f, force_r, replay.mse(p, HORIZONS))


def split_by_axle(rate_v: Array, rate_r: Array, vehicle: Vehicle) -> tuple[Array, Array]:
    """Unexplained lateral force (N) of front and rear axle.

    rate_v, rate_r: unexplained dv/dt (m/s^2) and d(omega_z)/dt (rad/s^2); vehicle: mass, inertia and axle distances.
    """
    force, moment = vehicle.mass * rate_v, vehicle.yaw_inertia * rate_r
    return (force * vehicle.l_r + moment) / vehicle.wheelbase, (force * vehicle.l_f - moment) / vehicle.wheelbase


def slope(clock: Array, values: Array) -> Array:
    """(M,) least-squares slopes of values (M, N) over clock (N,) by those that are there; NaN where fewer than FEWEST are."""
    good = np.isfinite(values)
    count = good.sum(axis=1, keepdims=True)
    away = np.where(good, clock - np.where(good, clock, 0.0).sum(axis=1, keepdims=True) / np.maximum(count, 1), 0.0)
    slopes = (away * np.where(good, values, 0.0)).sum(axis=1) / np.maximum((away**2).sum(axis=1), 1e-12)
    return np.where(count[:, 0] >= FEWEST, slopes, np.nan)


def unjudged(recording: Recording) -> str:
    """Why the axle forces of a recording are not judged, in words."""
    absent = [name for name in JUDGED_BY if not recording.measured(name)]
    if absent:
        return f"{' and '.join(absent)} {'are' if len(absent) > 1 else 'is'} not measured"
    seen = {name: recording.t[np.isfinite(recording[name])] for name in JUDGED_BY}
    apart = {name: float(np.median(np.diff(t))) if len(t) > 1 else np.inf for name, t in seen.items()}
    slowest = max(apart, key=lambda name: apart[name])
    if apart[slowest] * (FEWEST - 1) > WINDOW:
        return f"{slowest} is measured at {1.0 / apart[slowest]:.2g} Hz, fewer than {FEWEST} times in {WINDOW:g} s"
    return f"{' and '.join(JUDGED_BY)} are not measured together for {WINDOW:g} s often enough"


def rms(values: Array) -> float:
    """Root mean square of the finite values; NaN without any."""
    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else float("nan")
