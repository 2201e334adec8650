"""Following a plan between solves, and what a vehicle does without one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.sampling import STEP
from softsoil.control.nmpc_settings import SETTINGS

Array = NDArray[np.float64]


@dataclass
class PlanFollower:
    """The last good plan; without a new one for `patience` s the wheels are straightened and the vehicle slows down.

    dt: step of the plan (s); tick: time between commands (s). The command is the plan's at its own time; `halt`: its
    steering, but the brakes. patience (s), straighten (rad/s), slowing, braking (m/s^2), stopping: see `SolverSettings`.
    """

    dt: float
    tick: float = STEP
    patience: float = SETTINGS.patience
    straighten: float = SETTINGS.straighten
    slowing: float = SETTINGS.slowing
    braking: float = SETTINGS.braking
    stopping: float = SETTINGS.stopping
    halt: bool = False

    def __post_init__(self) -> None:
        self._t0, self._steer, self._u, self._a = -np.inf, np.zeros(2), np.full(2, 5.0), np.zeros(2)

    def take(self, t0: float, steer: Array, u: Array, a_x: Array, halt: bool = False) -> None:
        """A plan whose first state stands at t0 (s): steer (rad) and u (m/s) (N + 1,), a_x (m/s^2) (N,); halt: to a stand."""
        self._t0, self._steer, self._u, self._a, self.halt = t0, steer.copy(), u.copy(), a_x.copy(), halt

    def forget(self) -> None:
        """There is no plan, whatever the time."""
        self._t0 = -np.inf

    def lost(self, t: float) -> bool:
        """Whether the plan is too old to be followed at t (s)."""
        return t - self._t0 > self.patience

    def command(self, t: float, steer_now: float, lag: float = 0.0) -> tuple[float, float, float]:
        """(steering angle at t, speed, acceleration): of the plan, or the safe ones where it is lost; steer_now: rad; lag: of the
        wheels behind the command, which takes the plan's angle so much later (s)."""
        if self.lost(t):
            away = self.tick * self.straighten
            return steer_now - float(np.clip(steer_now, -away, away)), 0.0, self.slowing
        age = (t - self._t0) / self.dt
        k = min(int(age), len(self._a) - 1)
        places = np.arange(len(self._steer))
        steer = float(np.interp(age + lag / self.dt, places, self._steer))
        if self.halt:
            return steer, 0.0, self.braking
        return steer, float(np.interp(age, places, self._u)), float(self._a[k])

    def must_halt(self, u: float, ahead: float) -> bool:
        """Whether a vehicle at u (m/s) has to brake now for what stands `ahead` (m): stopping distance and a little more."""
        return ahead < u * u / (-2.0 * self.stopping * self.braking) + 1.5
