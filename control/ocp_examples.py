"""A plain bicycle with saturating tyres, and a course for it: the small problem that solvers are compared on."""

from __future__ import annotations

from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.control.courses import double_lane_change
from softsoil.control.nmpc_status import Stats
from softsoil.control.ocp import Ocp
from softsoil.control.path import Path
from softsoil.symbolic.bicycle import INPUTS, STATES
from softsoil.symbolic.model import Model, Quantities
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import GRAVITY, Vehicle

Array = NDArray[np.float64]


class Solver(Protocol):
    """What `Nmpc` and `CasadiNmpc` have in common."""

    z: Array
    w: Array
    stats: Stats

    def set_parameters(self, s: ArrayLike, r: ArrayLike, ref: ArrayLike, obstacles: ArrayLike | None = None) -> None:
        """See `Nmpc`: s, r, ref, obstacles."""

    def set_initial_guess(self, z: ArrayLike, w: ArrayLike) -> None:
        """See `Nmpc`: z, w."""

    def shift(self, seconds: float) -> None:
        """See `Nmpc`: seconds."""

    def make_step(self, z0: ArrayLike) -> Array:
        """See `Nmpc`: z0."""
        ...


def tanh_bicycle(vehicle: Vehicle) -> Model:
    """Bicycle with axle forces mu F_z tanh(C alpha/(mu F_z)): parameters C (stiffness, N/rad) and mu (friction)."""
    parameters = Layout.of(
        Signal("stiffness", "N/rad", "of an axle", 4e4, 0.0, 1e6),
        Signal("friction", "", "force over load", 0.35, 0.01, 2.0),
    )
    load_f = vehicle.mass * GRAVITY * vehicle.l_r / vehicle.wheelbase
    loads = (load_f, vehicle.mass * GRAVITY - load_f)

    def rhs(q: Quantities) -> Quantities:
        slips = (
            q["steer"] - ca.atan2(q["v"] + vehicle.l_f * q["omega_z"], q["u"]),
            -ca.atan2(q["v"] - vehicle.l_r * q["omega_z"], q["u"]),
        )
        front, rear = (
            q["friction"] * load * ca.tanh(q["stiffness"] * slip / (q["friction"] * load))
            for load, slip in zip(loads, slips, strict=True)
        )
        cos, sin, axle = ca.cos(q["psi"]), ca.sin(q["psi"]), q["v"] + vehicle.l_f * q["omega_z"]
        return {
            "x": q["u"] * cos - axle * sin, "y": q["u"] * sin + axle * cos, "psi": q["omega_z"], "u": q["a_x"],
            "v": (front * ca.cos(q["steer"]) + rear) / vehicle.mass - q["u"] * q["omega_z"],
            "omega_z": (front * ca.cos(q["steer"]) * vehicle.l_f - rear * vehicle.l_r) / vehicle.yaw_inertia,
        }  # fmt: skip

    return Model.of("tanh_bicycle", STATES, INPUTS, parameters, STATES, rhs, lambda q: {n: q[n] for n in STATES.names})


def reference_along(path: Path, along: float, speed: float, ocp: Ocp) -> Array:
    """(N + 1, 4) reference from `along` (m) at `speed` (m/s)."""
    ahead: Array = speed * ocp.settings.dt * np.arange(ocp.settings.steps + 1, dtype=float)
    places = path.at(along + ahead)
    return np.column_stack([places, np.full(len(places), speed)])


def straight_guess(ocp: Ocp, speed: float) -> tuple[Array, Array]:
    """A plan that drives straight on at `speed` (m/s): where a solver may start."""
    n, dt = ocp.settings.steps, ocp.settings.dt
    return np.stack([ocp.z.pack(u=speed, x=speed * dt * k) for k in range(n + 1)]), np.zeros((n, len(ocp.w)))


def closed_loop_cost(ocp: Ocp, solver: Solver, steps: int, speed: float = 7.0) -> tuple[float, Array]:
    """Sum of dt l(z, w, ref) over `steps` of the problem's own model on a double lane change, and seconds per solve (steps,).

    The solver's plan is moved on by one step between solves. speed: m/s.
    """
    path, h = double_lane_change(), ocp.settings.dt
    step, cost = ocp.step(), ocp.cost()
    r = np.zeros((ocp.settings.steps, len(ocp.r)))
    s = ocp.s.nominal
    z, total, seconds = ocp.z.pack(u=speed), 0.0, np.zeros(steps)
    solver.set_initial_guess(*straight_guess(ocp, speed))
    for k in range(steps):
        ref = reference_along(path, path.project(z[0], z[1])[0], speed, ocp)
        solver.set_parameters(s, r, ref)
        w = solver.make_step(z)
        seconds[k] = solver.stats.seconds
        total += h * float(cost(z, w, ref[0]))
        z = np.array(step(z, w, r[0], s)).ravel()
        solver.shift(h)
    return total, seconds
