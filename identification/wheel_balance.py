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

from softsoil.codegen.discretize import read_memory, start_memory, step_with_memory
from softsoil.codegen.step_loop import StepLoop
from softsoil.symbolic.bicycle import body_force
from softsoil.symbolic.model import Model, Quantities
from softsoil.windows.free_windows import FREE_STEP, FreeWindows, Linear
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


class BalanceModel:
    """A model's balances compiled once, for all drives with one sample interval.

    model: with a force for each wheel (`load_transfer`); dt: sample interval (s); substeps: Euler steps inside it.
    """

    def __init__(self, model: Model, dt: float, substeps: int = 1) -> None:
        self.model = model
        x, _, p = model.symbols()
        m, u = ca.SX.sym("m", len(model.cells)), ca.SX.sym("u", len(model.external))
        full = read_memory(model)(x, u, p, m)
        values = model.correct("balance", _balances).probe(*(f"balance_{name}" for name in BALANCES))(x, full, p)
        after = step_with_memory(model, dt, substeps=substeps)(x, m, u, p)
        self.loop = StepLoop(ca.Function("balance_step", [x, m, u, p], ca.cse([*after, values])))
        self.start = start_memory(model)


def _balances(q: Quantities) -> Quantities:
    wheels = {corner.name: corner for corner in q["wheels"]}
    along = sum(corner.count * body_force(corner)[0] for corner in wheels.values())
    torque = {name: corner.force.m_y for name, corner in wheels.items()}
    apart = {axle: (torque[f"{axle}l"] - torque[f"{axle}r"]) / (q["radius"] * q[f"load_{axle}"]) for axle in "fr"}
    return {
        "balance_longitudinal": along / q["mass"] - q["specific_x"],
        "balance_front": apart["f"],
        "balance_rear": apart["r"],
    }


class WheelBalance:
    """The balances of one drive, averaged over AVERAGED s, in clusters of CLUSTER s.

    compiled; windows: of the drive, whose states it follows: noise of recorded ones goes into the size of slips, and n comes out
    too low; p (n_p,): parameters at which the noise of the balances is taken, along the recorded states; open_axles: whether
    both axle differentials are seen to be open; fastest: steering rate (rad/s) beyond which nothing counts.
    """

    def __init__(self, compiled: BalanceModel, windows: FreeWindows, p: Array, open_axles: bool, fastest: float = np.inf) -> None:
        drive = windows.drive
        self._compiled, self._windows, self._drive = compiled, windows, drive
        self._size = max(round(AVERAGED / drive.dt), 1)
        self._per = max(round(CLUSTER / AVERAGED), 1)
        length = self._size * self._per
        rate = drive.inputs[:, compiled.model.external.index("steer_rate")]
        starts = np.arange(drive.first, len(drive.t) - length + 1, length)
        self._rows = np.array([row for row in starts if np.abs(rate[row : row + length]).max() <= fastest], dtype=int)
        series = self._series(p[None])[0]
        noise = 1.4826 * np.median(np.abs(np.diff(series[drive.first :], n=3, axis=0)), axis=0) / np.sqrt(20)
        sigma = np.hypot(MODEL_STD, noise / np.sqrt(self._size))
        self._sigma = sigma if open_axles else np.array([sigma[0], np.inf, np.inf])

    @property
    def times(self) -> Array:
        """(C,) time of each cluster (s)."""
        return self._drive.t[self._rows]

    def residual(self, p: Array) -> Array:
        """(C, m) residuals in standard deviations for parameters p (n_p,)."""
        return self._averaged(self._series(p[None]))[0]

    def linearise(self, p: Array, free: Sequence[Free]) -> Linear:
        """Residuals and derivatives at p (n_p,), without states."""
        index = self._compiled.model.p.index
        sets, steps = [p], []
        for f in free:
            step = FREE_STEP * f.scale * (-1.0 if p[index(f.sets[0])] + FREE_STEP * f.scale > f.upper else 1.0)
            sets.append(p.copy())
            sets[-1][[index(name) for name in f.sets]] += step
            steps.append(step)
        values = self._averaged(self._series(np.array(sets)))
        slope = (values[1:] - values[0]) / np.array(steps).reshape(-1, 1, 1)
        return Linear(values[0], np.zeros((*values[0].shape, 0)), np.moveaxis(slope, 0, -1))

    def _averaged(self, series: Array) -> Array:
        """(K, C, m) means in standard deviations of the series (K, N, 3)."""
        take = self._rows[:, None] + np.arange(self._size * self._per)
        means = series[:, take].reshape(len(series), len(self._rows), self._per, self._size, len(BALANCES)).mean(axis=3)
        return np.nan_to_num(means / self._sigma).reshape(len(series), len(self._rows), -1)

    def _series(self, p: Array) -> Array:
        """(K, N, 3) balances along the states as estimated so far for parameters p (K, n_p)."""
        drive, compiled = self._drive, self._compiled
        states = self._windows.along(np.arange(len(drive.t)))
        m0 = np.array([compiled.start(states[0], drive.inputs[0], row).full()[:, 0] for row in p]).reshape(len(p), -1)
        rows = np.array([0], dtype=int)
        return compiled.loop.along(np.tile(states, (len(p), 1, 1)), m0, drive.inputs, p, rows)[0]
