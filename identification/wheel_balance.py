"""Measured wheel speeds as observations of a vehicle's geometry: what drives the wheels must balance.

Along the states that windows with free starts have estimated so far, the force law gives each wheel's force and torque from its
measured speed. Three balances hold whatever the soil: longitudinally, sum F_x/M is what an accelerometer reads, which pins the
radius; and an open differential drives both wheels of an axle alike, (m_y,left - m_y,right)/(r F_z) = 0, which pins the tracks
and, while steering, the scrub.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.symbolic.bicycle import body_force, radius_of
from softsoil.symbolic.model import Model, Quantities
from softsoil.windows.free_windows import FreeWindows, Linear
from softsoil.windows.parameters import Free

Array = NDArray[np.float64]

CLUSTER = 1.0
"""s: observations inside one are not taken for independent."""
AVERAGED = 0.25
"""s over which a balance is averaged: sensor noise goes, the motion stays."""
MODEL_STD = np.array([0.3, 0.03, 0.03])
"""What a right model leaves (m/s^2, 1, 1): the force law's longitudinal error, 3 % of the weight, and as much of the axle's load
between the wheels of an axle, the friction of its differential among it."""
BALANCES = ("longitudinal", "front", "rear")


def balances(model: Model) -> ca.Function:
    """CasADi function [x, u, p] -> [y]: the BALANCES of a model with a force for each wheel (`load_transfer`)."""
    return model.correct("balance", _balances).probe(*(f"balance_{name}" for name in BALANCES))


def _balances(q: Quantities) -> Quantities:
    wheels = {corner.name: corner for corner in q["wheels"]}
    along = sum(corner.count * body_force(corner)[0] for corner in wheels.values())
    pull = {name: corner.force.m_y / radius_of(q, corner) for name, corner in wheels.items()}
    apart = {axle: (pull[f"{axle}l"] - pull[f"{axle}r"]) / q[f"load_{axle}"] for axle in "fr"}
    return {
        "balance_longitudinal": along / q["mass"] - q["specific_x"],
        "balance_front": apart["f"],
        "balance_rear": apart["r"],
    }


class WheelBalance:
    """The balances of one drive, averaged over AVERAGED s, in clusters of CLUSTER s.

    windows: of the drive, by a model with the `balances` beside it, whose states it follows: noise of recorded ones goes into the
    size of slips, and n comes out too low; p (n_p,): parameters at which the noise of the balances is taken, along the recorded
    states; open_axles: whether both axle differentials are seen to be open; fastest: steering rate (rad/s) beyond which nothing
    counts, as where the drive is not `driven`.
    """

    def __init__(self, windows: FreeWindows, p: Array, open_axles: bool, fastest: float = np.inf) -> None:
        drive = windows.drive
        self._windows, self._drive = windows, drive
        self._size = max(round(AVERAGED / drive.dt), 1)
        self._per = max(round(CLUSTER / AVERAGED), 1)
        length = self._size * self._per
        rate = drive.inputs[:, windows.compiled.model.external.index("steer_rate")]
        starts = np.arange(drive.first, len(drive.t) - length + 1, length)
        fast = (np.abs(rate) > fastest) | ~drive.driven
        self._rows = np.array([row for row in starts if not fast[row : row + length].any()], dtype=int)
        series = windows.series(p[None])[0]
        noise = 1.4826 * np.median(np.abs(np.diff(series[drive.first :], n=3, axis=0)), axis=0) / np.sqrt(20)
        sigma = np.hypot(MODEL_STD, noise / np.sqrt(self._size))
        self._sigma = sigma if open_axles else np.array([sigma[0], np.inf, np.inf])

    @property
    def prior(self) -> bool:
        """It is measured."""
        return False

    @property
    def times(self) -> Array:
        """(C,) time of each cluster (s)."""
        return self._drive.t[self._rows]

    def residual(self, p: Array) -> Array:
        """(C, m) residuals in standard deviations for parameters p (n_p,)."""
        return self._averaged(self._windows.series(p[None]))[0]

    def linearise(self, p: Array, free: Sequence[Free]) -> Linear:
        """Residuals and derivatives at p (n_p,), without states."""
        sets, steps = self._windows.moved(p, free)
        values = self._averaged(self._windows.series(sets))
        slope = (values[1:] - values[0]) / steps.reshape(-1, 1, 1)
        return Linear(values[0], np.zeros((*values[0].shape, 0)), np.moveaxis(slope, 0, -1))

    def _averaged(self, series: Array) -> Array:
        """(K, C, m) means in standard deviations of the series (K, N, 3)."""
        take = self._rows[:, None] + np.arange(self._size * self._per)
        means = series[:, take].reshape(len(series), len(self._rows), self._per, self._size, len(BALANCES)).mean(axis=3)
        return np.nan_to_num(means / self._sigma).reshape(len(series), len(self._rows), -1)
