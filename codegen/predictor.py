"""Prediction of the states over a horizon, with any model's histories rolled forward."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.compiled import CompiledFunction
from softsoil.codegen.discretize import follow_memory, start_memory, step_with_memory
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]


LONGEST_STEP = 0.015
"""s: the lateral motion of a wheeled vehicle settles within some hundredths of a second; a longer step is divided."""


def substeps_for(dt: float) -> int:
    """How many steps of at most LONGEST_STEP make up dt (s)."""
    return max(1, math.ceil(dt / LONGEST_STEP - 1e-9))


class Predictor:
    """A model's one-step map, compiled once and rolled over horizons.

    model; dt: step (s); method, substeps: of `discretize`.
    """

    def __init__(self, model: Model, dt: float, method: str = "euler", substeps: int = 1) -> None:
        self.model, self.dt = model, dt
        self._step = CompiledFunction(step_with_memory(model, dt, method, substeps))
        if model.memories:
            self._start = CompiledFunction(start_memory(model), compiled=False)  # once in a drive: not worth a compilation
            self._follow = CompiledFunction(follow_memory(model, dt))

    def first_memory(self, x0: ArrayLike, u: ArrayLike, p: ArrayLike) -> Array:
        """(n_m,) memory at a standing start with state x0 (n_x,), external input u, parameters p."""
        return np.asarray(self._start(x0, u, p)) if self.model.memories else np.zeros(0)

    def rollout(self, x0: ArrayLike, u_future: ArrayLike, p: ArrayLike, m0: ArrayLike | None = None) -> Array:
        """(N + 1, n_x) states from x0 (n_x,) under external inputs u_future (N, n_u), parameters p (n_p,), memory m0 (n_m,).

        Without m0 the histories start as on a standing start. Raises ValueError for shapes that do not fit.
        """
        u_future = np.asarray(u_future, dtype=float)
        if u_future.ndim != 2 or u_future.shape[1] != len(self.model.external):
            raise ValueError(f"u_future: expected shape (N, {len(self.model.external)}), found {u_future.shape}")
        x = np.empty((len(u_future) + 1, len(self.model.x)))
        x[0] = x0
        m = self.first_memory(x[0], u_future[0], p) if m0 is None and len(u_future) else m0
        into, out = self._step.inputs, self._step.outputs
        into[0][:, 0], into[3][:, 0] = x[0], p
        if self.model.memories:
            into[1][:, 0] = m
        for k, u in enumerate(u_future):
            into[2][:, 0] = u
            self._step.run()
            x[k + 1] = out[0][:, 0]
            into[0][:] = out[0]
            into[1][:] = out[1]
        return x

    def one_step(self, x: ArrayLike, u: ArrayLike, p: ArrayLike, memory: ArrayLike) -> Array:
        """(N, n_x) states one step after each of x (N, n_x), with inputs u (N, n_u), p (n_p,), memory (N, n_m)."""
        x, u, memory = np.asarray(x, dtype=float), np.asarray(u, dtype=float), np.asarray(memory, dtype=float)
        after = np.empty_like(x)
        into, out = self._step.inputs, self._step.outputs
        into[3][:, 0] = p
        for k in range(len(x)):
            into[0][:, 0], into[1][:, 0], into[2][:, 0] = x[k], memory[k], u[k]
            self._step.run()
            after[k] = out[0][:, 0]
        return after

    def track(self, measured: ArrayLike, u: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
        """Everything that a log does not measure, run along it: full states (N, n_x) and memory (N, n_m).

        measured (N, m): the first m states of the model; u (N, n_u): external inputs; p (n_p,). States beyond the measured
        ones start at their nominal values and histories as on a standing start; both then follow the model.
        """
        measured, u = np.asarray(measured, dtype=float), np.asarray(u, dtype=float)
        count = measured.shape[1]
        states = np.tile(self.model.x.nominal, (len(measured), 1))
        states[:, :count] = measured
        if count == len(self.model.x):
            return states, self.track_memory(states, u, p)[0]
        memory = np.zeros((len(states), len(self.model.cells)))
        memory[:1] = self.first_memory(states[0], u[0], p)
        for k in range(len(states) - 1):
            after = self._step(states[k], memory[k], u[k], p)
            states[k + 1, count:], memory[k + 1] = after[0][count:], after[1]
        return states, memory

    def track_memory(self, x: ArrayLike, u: ArrayLike, p: ArrayLike) -> tuple[Array, Array]:
        """Histories along known states: memory (N, n_m) and full inputs (N, n_u_full) for x (N, n_x) and u (N, n_u)."""
        x, u = np.asarray(x, dtype=float), np.asarray(u, dtype=float)
        if not self.model.memories:
            return np.zeros((len(x), 0)), u
        memory, full = np.empty((len(x), len(self.model.cells))), np.empty((len(x), len(self.model.u)))
        memory[0] = self.first_memory(x[0], u[0], p)
        for k in range(len(x)):
            following, full[k] = self._follow(x[k], memory[k], u[k], p)
            if k + 1 < len(x):
                memory[k + 1] = following
        return memory, full
