"""Derivatives of windows to something that the model lacks: added to every step, carried on by the derivatives of single steps.

What an inertia or a force that is a little wrong does to a window follows from the steps along the drive, so that no other model
is compiled for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.windows.free_windows import STATE_STEP, FreeWindows, N
from softsoil.windows.histories import parted

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Steps:
    """Single steps of the model along a drive, from the first row of the windows `which` to the last.

    which (W,): indices of the windows; first (W,): step at which each of them starts; states (R, 6) at the start of each step;
    change (R, 6): what the step adds to them; by_state (R, 6, 6): derivative of the states after it to those before.
    """

    which: NDArray[np.int_]
    first: NDArray[np.int_]
    states: Array
    change: Array
    by_state: Array


def single_steps(windows: FreeWindows, p: Array, which: NDArray[np.int_]) -> Steps:
    """The steps under the windows `which` (increasing indices) with parameters p (n_p,), from the states as estimated so far."""
    start, stop = int(windows.rows[which[0]]), int(windows.rows[which[-1]]) + windows.steps
    rows = np.arange(start, stop)
    states = windows.along(rows)
    states[:, N:], memory = parted(windows.compiled.model, windows.memories(p[None], rows)[0])
    many = np.tile(states, (1 + N, 1, 1))
    many[1:, :, :N] += STATE_STEP[:, None, None] * np.eye(N)[:, None, :]
    inputs = np.tile(windows.drive.inputs[rows[:, None] + np.arange(2)], (1 + N, 1, 1))
    jobs = len(inputs)
    after = windows.compiled.loop.windows(
        many.reshape(jobs, -1), np.tile(memory, (1 + N, 1)), inputs, np.broadcast_to(p, (jobs, len(p)))
    ).reshape(1 + N, len(rows), 2, 2 * N)[:, :, 1, N:]
    by_state = np.moveaxis((after[1:] - after[0]) / STATE_STEP[:, None, None], 0, -1)
    return Steps(which, windows.rows[which] - start, states[:, :N], after[0] - states[:, :N], by_state)


def by_addition(windows: FreeWindows, steps: Steps, added: Array) -> Array:
    """(W, m) derivative of the windows' residuals to a number that adds itself times added (R, 6) to the states at every step."""
    count = len(steps.which)
    moved, state = np.zeros((count, windows.steps + 1, N)), np.zeros((count, N))
    for k in range(windows.steps):
        state = np.einsum("wij,wj->wi", steps.by_state[steps.first + k], state) + added[steps.first + k]
        moved[:, k + 1] = state
    moved = moved / windows.sigma
    moved[~np.isfinite(windows.recorded[steps.which])] = 0.0
    return moved.reshape(count, -1)
