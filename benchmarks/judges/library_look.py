"""What a vehicle's generated library says of a drive: n by its moving horizon, the verdict, and the look at the vehicle."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass

import numpy as np

from benchmarks.judges.vehicle_judge import TRUSTED
from softsoil.codegen.c_library.binding import CLibrary
from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.codegen.c_library.vehicle_binding import CVehicle
from softsoil.control.c_estimator import c_library_texts
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.moving_horizon import LEAST_NOISE
from softsoil.estimator.verdict import IDENTIFIED
from softsoil.recording.drive import Recording
from softsoil.recording.states import sensor_std
from softsoil.windows.shooting import shooting_drive

GUESS = 0.7
START = 2.0
"""s left out at the beginning, as by `estimate`."""


@dataclass(frozen=True)
class LibrarySays:
    """n of the front axle and the verdict at the end; share of the mass by which the vehicle is heavier, its standard deviation,
    and the strain of its numbers; first time at which the vehicle was said to have changed (s), NaN where it never was; how long
    n was called identified (s), and how long while it was more than TRUSTED off."""

    n: float
    verdict: str
    load: float
    load_std: float
    strain: float
    changed_at: float
    identified_for: float
    wrong_for: float


def by_library(declared: Declaration, log: Recording, n: float) -> LibrarySays:
    """Run the library of `declared`, whose vehicle's file states a joint error, over a log on soil of true `n`."""
    drive = shooting_drive(log, declared.build(), START, live=True)
    with tempfile.TemporaryDirectory() as folder:
        write_library(folder, c_library_texts(declared, drive.dt))
        horizon = CHorizon(CLibrary(folder))
    horizon.options.dt, horizon.options.start_up, horizon.options.guess[:] = drive.dt, START, [GUESS] * len(horizon.names)
    horizon.options.r_std[:] = sensor_std(log, LEAST_NOISE)
    horizon.start(float(drive.t[0]))
    look, changed_at, identified, wrong = CVehicle(horizon), np.nan, 0, 0
    for t, u, y in zip(drive.t, drive.inputs, drive.measured, strict=True):
        horizon.push(u, y, t)
        horizon.update()
        look.update()
        if np.isnan(changed_at) and look.change in ("strained", "other_mass"):
            changed_at = float(t)
        said = horizon.verdict == IDENTIFIED
        identified, wrong = identified + said, wrong + (said and abs(horizon.n[0] / n - 1.0) > TRUSTED)
    head = look.head
    return LibrarySays(
        float(horizon.n[0]), horizon.verdict, head.load, head.load_std, head.strain, changed_at,
        identified * drive.dt, wrong * drive.dt,
    )  # fmt: skip
