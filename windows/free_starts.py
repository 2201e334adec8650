"""Windows with free initial states for fits of a vehicle's numbers: length, weights, and a joint error as one observation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.predictor import substeps_for
from softsoil.files.joint_error import JointError
from softsoil.recording.drive import Recording
from softsoil.recording.states import sensor_std
from softsoil.symbolic.model import Model
from softsoil.windows.free_windows import FreeWindows, Linear, WindowModel
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import MODEL_STD, SEEN, Drive

Array = NDArray[np.float64]

HORIZON = 1.0
"""s: windows of the fit. Longer ones gather what the force law misses, shorter ones see less of the yaw inertia."""
SUBSTEPS = 2
"""Steps of the model inside one of `substeps_for`: what Euler's method misses in one counts as one per cent of yaw inertia."""
NOISE_FLOOR = np.full(6, 1e-4)
FASTEST = 1.5
"""rad/s: no window runs across a faster steering, which no actuator follows."""


def steps_of(dt: float) -> int:
    """Euler steps of a window's model in a sample interval dt (s)."""
    return SUBSTEPS * substeps_for(dt)


def free_windows(compiled: WindowModel, drive: Drive, recording: Recording, floor: Array = NOISE_FLOOR) -> FreeWindows:
    """The windows of one drive, weighted by the noise of the recording's sensors, at least `floor` (6,), and by MODEL_STD."""
    return FreeWindows(compiled, drive, HORIZON, np.hypot(MODEL_STD, sensor_std(recording, floor)), FASTEST, seen=SEEN)


def until(drive: Drive, row: int) -> Drive:
    """The drive before a row."""
    parts = {name: getattr(drive, name)[:row] for name in ("t", "measured", "smooth", "inputs", "driven", "usable", "near")}
    return replace(drive, **parts)


@dataclass(frozen=True)
class JointPrior:
    """What is known of K numbers together, as one observation beside the windows of a drive.

    model: whose parameters they are; names (K,); mean (K,); root (K, K): residuals are root (p - mean), in standard deviations.
    """

    model: Model
    names: tuple[str, ...]
    mean: Array
    root: Array

    @property
    def times(self) -> Array:
        """(1,) time of the observation (s): before the drive."""
        return np.zeros(1)

    @property
    def prior(self) -> bool:
        """It is what is known beforehand."""
        return True

    def residual(self, p: Array) -> Array:
        """(1, K) residuals in standard deviations for parameters p (n_p,)."""
        values = np.array([p[self.model.p.index(name)] for name in self.names])
        return (self.root @ (values - self.mean))[None]

    def linearise(self, p: Array, free: Sequence[Free]) -> Linear:
        """Residuals and derivatives at p (n_p,), without states."""
        columns = [self.root[:, self.names.index(f.name)] if f.name in self.names else np.zeros(len(self.root)) for f in free]
        slope = np.array(columns).reshape(len(free), len(self.root)).T
        return Linear(self.residual(p), np.zeros((1, len(self.root), 0)), slope[None])


def joint_prior(error: JointError, model: Model, mean: dict[str, float]) -> JointPrior:
    """The prior of those numbers in `mean` (name -> value) that the error has, the others unknown."""
    names = tuple(name for name in error.names if name in mean)
    index = [error.names.index(name) for name in names]
    scale = np.array(error.std)[index]
    size, axes = np.linalg.eigh(error.covariance[np.ix_(index, index)] / np.outer(scale, scale))
    # Rounded correlations may leave an eigenvalue at 0: such a direction is known to a thousandth of its scale.
    root = (axes / np.sqrt(np.maximum(size, 1e-6))).T / scale
    return JointPrior(model, names, np.array([mean[name] for name in names]), root)
