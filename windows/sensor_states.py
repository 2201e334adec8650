"""States and what sensors say of them: effects of sensors stand between the two."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.compiled import CompiledFunction
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]

CORRECTIONS = 4
"""Steps of the contraction that finds the states whose outputs were recorded."""


def outputs_of(model: Model) -> ca.Function:
    """CasADi function [x, p] -> [y]: outputs do not look at inputs or histories, measured states are outputs of the states.

    Raises ValueError for a model whose outputs do.
    """
    x, u, p = model.symbols()
    outputs = ca.cse(model.measurement()(x, u, p))
    if ca.depends_on(outputs, u):
        raise ValueError(f"model {model.name}: expected outputs of the states alone, found some of the inputs")
    return ca.Function("outputs", [x, p], [outputs], ["x", "p"], ["y"])


def senses(model: Model) -> bool:
    """Whether an effect of sensors stands between the first six states and the outputs of a bicycle `model`, one that can be
    taken off: outputs that look at inputs say no state."""
    x, u, p = model.symbols()
    outputs = model.measurement()(x, u, p)
    return not ca.depends_on(outputs, u) and not all(ca.is_equal(outputs[i], x[i], 0) for i in range(len(STATE_CHANNELS)))


def along(outputs: ca.Function, rows: int) -> CompiledFunction:
    """`outputs_of` a model at so many rows with one p, with buffers of its own."""
    return CompiledFunction(outputs.map("outputs_along", "serial", rows, [1], []), compiled=False)


def settle(outputs: CompiledFunction, p: Array, recorded: Array, found: Array, sensed: NDArray[np.bool_]) -> None:
    """Correct states in place until their outputs are those of the record.

    outputs: `along` M rows or more; p (n_p,); recorded (M, 6); found (M, n_x): states, at the record to begin with; sensed (6,):
    channels that a sensor measures: in a derived one there is nothing of it.
    Outputs differ from states by a sensor's small effect: a contraction.
    """
    count = len(found)
    outputs.inputs[1][:, 0] = p
    for _ in range(1 + CORRECTIONS):
        outputs.inputs[0][:, :count] = found.T
        outputs.run()
        missing = np.where(sensed, recorded - outputs.outputs[0].T[:count], 0.0)
        if np.abs(missing).max() < 1e-9:
            break
        found[:, : len(STATE_CHANNELS)] += missing
