"""What n owes to the other parameters of the soil's class and to the force law: an error of any moves it, and a drive hardly
shows that.

n and these parameters change the same forces: a friction angle a tenth larger can move n by a fifth while the model leaves hardly
more than before. n is therefore that of the class as declared. So is a lateral force that the law makes a little too large: on
steady curves near saturation, where a hundredth more force takes much more sinkage, 1 % of an axle's force is 4 to 5 % of n, in
quick changes of direction 1 to 2 %. What either is worth follows from the windows of an estimate: with H the sum of their
quadratics, the n that balances a change of a number is dn = -H_nn^-1 H_nk dk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.moving_horizon import MovingHorizon
from softsoil.estimator.step_changes import Steps, by_addition, single_steps
from softsoil.estimator.summary import LEAST_CURVATURE
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import CLASS_NUMBERS
from softsoil.symbolic.vehicle import Vehicle
from softsoil.windows.free_windows import FreeWindows, Linear
from softsoil.windows.parameters import Free
from softsoil.windows.window_fit import reduce_windows

Array = NDArray[np.float64]


U, V, YAW = (STATE_CHANNELS.index(name) for name in ("u", "v", "omega_z"))
LAW_ERROR = 0.01
"""Share of an axle's lateral force by which a right law is taken to miss it over a whole drive."""


@dataclass(frozen=True)
class SoilError:
    """What the soil's other parameters and the force law make of the n of a drive.

    tenth: parameter -> change of n at the front axle, as a share, where it is a tenth larger than declared; std: standard
    deviation of n, as a share, by the errors that the soil's file states of its parameters; 0 where it states none; forces:
    change of n at the front axle, as a share, where the lateral force of the front, of the rear axle is 1 % larger than the
    law's; law_std: standard deviation of n, as a share, by errors of LAW_ERROR of both, of the axle where it is larger; flat:
    of any n, whatever the drive (`HorizonRules.common_error`).
    """

    tenth: dict[str, float]
    std: float
    forces: tuple[float, float] = (0.0, 0.0)
    law_std: float = 0.0
    flat: float = 0.0

    @property
    def more(self) -> float:
        """Standard deviation of n, as a share, by class and law, beyond what that of any n holds for the law."""
        return float(np.sqrt(self.std**2 + max(self.law_std**2 - self.flat**2, 0.0)))


def soil_error(windows: FreeWindows, horizon: MovingHorizon) -> SoilError:
    """How far errors of the class and of the law move n; windows: of the drive; horizon: run to its end."""
    layout, count = windows.compiled.model.p, len(horizon.free)
    values = {name: float(layout[name].nominal) for name in CLASS_NUMBERS if layout[name].nominal > 0.0}
    others = tuple(Free(name, (name,), 0.1 * value, 0.0, np.inf) for name, value in values.items())
    last = len(windows.rows) - 1
    which = np.arange(horizon.since, last + 1)
    x0, p = np.array(horizon.summary.states)[which], horizon.parameters(horizon.n)
    linear = windows.linearise(p, x0, (*horizon.free, *others), which)
    forces = _by_forces(windows, single_steps(windows, p, which))
    sound = np.isfinite(forces).all(axis=(1, 2))
    by_free = np.concatenate([linear.by_free, forces], axis=2)[sound]
    reduced = reduce_windows(Linear(linear.residual[sound], linear.by_state[sound], by_free))
    hessian = np.einsum("w,wkl->kl", horizon.weight(last)[which][sound], np.nan_to_num(reduced.hessian))
    curvature = hessian[:count, :count] + LEAST_CURVATURE * np.eye(count)
    shares = -np.linalg.solve(curvature, hessian[:count, count:]) / np.maximum(horizon.n, 1e-9)[:, None]
    moved = shares[0]
    by_tenth = {name: float(0.1 * values[name] * one) for name, one in zip(values, moved, strict=False)}
    std = _by_class(windows.compiled.model, dict(zip(values, moved, strict=False)))
    front, rear = (float(LAW_ERROR * one) for one in moved[len(values) :])
    law = float(LAW_ERROR * np.hypot(*shares[:, -2:].T).max())
    return SoilError(by_tenth, std, (front, rear), law, horizon.rules.common_error)


def _by_class(model: Model, moved: dict[str, float]) -> float:
    """Standard deviation of n, as a share, by what the soil's file states of the errors of its parameters.

    moved: parameter -> share of n that it moves n by, per its unit.
    """
    joint = None if model.together is None else model.together.only(moved.keys())
    names = () if joint is None else joint.names
    by = np.array([moved[name] for name in names])
    together = 0.0 if joint is None else float(by @ joint.covariance @ by)
    alone = [model.p[name].spread * one for name, one in moved.items() if name not in names and np.isfinite(model.p[name].spread)]
    return float(np.sqrt(max(together, 0.0) + np.sum(np.square(alone))))


def _by_forces(windows: FreeWindows, steps: Steps) -> Array:
    """(W, m, 2) derivatives of the windows' residuals to the shares by which the lateral forces of front and rear are larger.

    The forces are those that balance the steps' changes of lateral velocity and yaw rate.
    """
    vehicle, dt = windows.compiled.model.geometry, windows.drive.dt
    if not isinstance(vehicle, Vehicle):
        return np.zeros((len(steps.which), windows.recorded[0].size, 2))
    sideways = steps.change[:, V] / dt + steps.states[:, U] * steps.states[:, YAW]
    turning = steps.change[:, YAW] / dt * vehicle.yaw_inertia / vehicle.mass
    columns = []
    for other, arm in ((vehicle.l_r, vehicle.l_f), (vehicle.l_f, -vehicle.l_r)):
        force = (sideways * other + np.sign(arm) * turning) / vehicle.wheelbase  # over the mass
        added = np.zeros_like(steps.change)
        added[:, V], added[:, YAW] = force * dt, arm * force * vehicle.mass / vehicle.yaw_inertia * dt
        columns.append(by_addition(windows, steps, added))
    return np.stack(columns, axis=-1)
