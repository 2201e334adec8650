"""The yaw inertia that true wheel forces balance with: what a planar model has to find, read to judge only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softsoil.recording.drive import Recording

ROWS = 9
"""Samples over which true forces and yaw rate are averaged."""
START_UP = 2.0
"""s."""


def balanced_inertia(drives: Sequence[Recording], arms: tuple[float, float], tracks: tuple[float, float]) -> float:
    """Yaw inertia (kg m^2) by least squares of the wheel forces' yaw moment on d(omega_z)/dt, the mean of the drives.

    drives: with the columns true_fx_fl to true_fy_rr; arms: of front and rear axle to the centre of gravity, l_f and l_r (m);
    tracks: front and rear (m). It is 0.5 to 2.5 % less than the bodies' own where a body leans and wheels are steered.
    """
    values = []
    kernel = np.ones(ROWS) / ROWS
    for drive in drives:
        moment = np.zeros(len(drive))
        for wheel in ("fl", "fr", "rl", "rr"):
            axle = "fr".index(wheel[0])
            arm, side = (1, -1)[axle] * arms[axle], (0.5 if wheel[1] == "l" else -0.5) * tracks[axle]
            moment += arm * drive.truth[f"true_fy_{wheel}"] - side * drive.truth[f"true_fx_{wheel}"]
        rate = np.convolve(np.gradient(drive["omega_z"], drive.dt), kernel, "same")
        rows = drive.t > START_UP
        columns = np.column_stack([rate, np.ones(len(rate))])[rows]
        values.append(np.linalg.lstsq(columns, np.convolve(moment, kernel, "same")[rows], rcond=None)[0][0])
    return float(np.mean(values))
