"""NMPC in real time: sequential quadratic programming with exact derivatives on a structure-exploiting interior point.

The solver is the C code of `c_controller`, compiled once and kept in the cache: what `softsoil generate --controller` writes.
Two modes. `rti`: one iteration per step, repeated only where it changed the plan much; `prepare()` may run before the
state is known, `make_step(z0)` does the rest. `converged`: iterations until the step is small, with a line search on the
exact L1 merit function. Where a subproblem's reduced Hessian is not positive, each stage's eigenvalues are clipped and it is
solved again.
"""

from __future__ import annotations

import ctypes
import time

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.control.c_controller import HESSIANS, controller_files
from softsoil.control.c_statuses import STATUSES
from softsoil.control.nmpc_binding import CController
from softsoil.control.nmpc_clearance import placed
from softsoil.control.nmpc_settings import SETTINGS
from softsoil.control.nmpc_status import Stats, Status
from softsoil.control.ocp import Ocp

Array = NDArray[np.float64]
DIGITS = 17
"""Significant digits of constants: all there are, since the C is compiled where it is written."""


class Nmpc:
    """Solver of an Ocp, warm-started from its last solution.

    mode: "rti" or "converged"; most: greatest number of iterations of the latter; tolerance: largest change of any
    variable at which it stops; hessian: "gauss_newton", the cost's alone and the default of real-time iterations, or "exact", the
    Lagrangian's and the default of converged solves. z (N + 1, n_z), w (N, n_w): the plan;
    AB (N, n_z, n_v) and end (N, n_z) are the dynamics along it, at the last linearisation.
    Raises ValueError for another mode or Hessian, or where there is no C compiler.

    Example:
        >>> import softsoil
        >>> vehicle = softsoil.load_vehicle("paper")
        >>> ocp = softsoil.Ocp(softsoil.bicycle(vehicle, softsoil.load_soil("clay")), vehicle)
        >>> solver = softsoil.Nmpc(ocp)
        >>> solver.w.shape == (ocp.settings.steps, 2)
        True
    """

    def __init__(
        self, ocp: Ocp, mode: str = "rti", most: int = SETTINGS.most, tolerance: float = SETTINGS.tolerance,
        hessian: str | None = None,
    ) -> None:  # fmt: skip
        if mode not in ("rti", "converged"):
            raise ValueError(f"nmpc: expected mode rti or converged, found {mode!r}")
        self.ocp, self.mode = ocp, mode
        self.controller = CController(ocp, controller_files(ocp, hessian or HESSIANS[mode == "converged"], DIGITS))
        options = self.controller.Options()
        self.controller.c.softsoil_nmpc_defaults(ctypes.byref(options))
        options.converge, options.most, options.tolerance = int(mode == "converged"), most, tolerance
        self.controller.call("init", ctypes.byref(options), ocp.z.nominal)
        n = ocp.settings.steps
        self.z, self.w, self.end = self.controller.view("z"), self.controller.view("w")[:n], self.controller.view("end")
        self._first, self._spent = np.zeros(len(ocp.w)), 0.0
        self.stats = Stats(Status.OUT_OF_ITERATIONS)
        self.set_initial_guess(np.tile(ocp.z.nominal, (n + 1, 1)), np.zeros((n, len(ocp.w))))
        self._asked = False

    def set_parameters(self, s: ArrayLike, r: ArrayLike, ref: ArrayLike, obstacles: ArrayLike | None = None) -> None:
        """s (n_s,): model parameters, slip, slip_gain; r (N, n_r): histories; ref (N + 1, 4): x, y, psi, u of the path;
        obstacles (N + 1, n, 3): x, y, radius over the horizon, or (n, 3) where they stand; one of a radius < 0 is
        not there, nor are any beyond those given.

        Raises ValueError for other shapes or more obstacles than the Ocp watches.
        """
        n = self.ocp.settings.steps
        places = placed(self.ocp, obstacles)
        s, r, ref = (np.ascontiguousarray(value, dtype=float) for value in (s, r, ref))
        for name, value, shape in (
            ("s", s, (len(self.ocp.s),)), ("r", r, (n, len(self.ocp.r))), ("ref", ref, (n + 1, 4)),
        ):  # fmt: skip
            if value.shape != shape:
                raise ValueError(f"{name}: expected shape {shape}, found {value.shape}")
        self.controller.call("parameters", s, r, ref, places)
        self._asked = True

    def histories(self, m: ArrayLike | None, s: ArrayLike) -> Array:
        """(N, n_r) stage parameters: the model's histories from the present memory m (n_m,) along the plan.

        s (n_s,): parameters; zeros for a model without histories. Raises ValueError for other shapes.
        """
        r = np.zeros((self.ocp.settings.steps, len(self.ocp.r)))
        if not self.ocp.model.memories or m is None:
            return r
        m, s = np.ascontiguousarray(m, dtype=float), np.ascontiguousarray(s, dtype=float)
        if m.shape != (len(self.ocp.model.cells),) or s.shape != (len(self.ocp.s),):
            raise ValueError(
                f"histories: expected {len(self.ocp.model.cells)} cells and {len(self.ocp.s)} parameters, "
                f"found shapes {m.shape} and {s.shape}"
            )
        self.controller.call("histories", s, m, r)
        return r

    def model_inputs(self, z: ArrayLike, w: ArrayLike, s: ArrayLike) -> Array:
        """(n_external,) inputs of the model in the state z (n_z,) under w (n_w,), wheel speeds following from the motion.

        s (n_s,): parameters, with the wheels' slip. Raises ValueError for other shapes.
        """
        given = [np.ascontiguousarray(value, dtype=float) for value in (z, w, s)]
        sizes = [(len(layout),) for layout in (self.ocp.z, self.ocp.w, self.ocp.s)]
        if [value.shape for value in given] != sizes:
            raise ValueError(f"inputs: expected shapes {sizes}, found {[value.shape for value in given]}")
        u = np.zeros(len(self.ocp.model.external))
        self.controller.c.softsoil_nmpc_inputs(*[a.ctypes.data_as(ctypes.c_void_p) for a in (*given, u)])
        return u

    def set_initial_guess(self, z: ArrayLike, w: ArrayLike) -> None:
        """z (N + 1, n_z), w (N, n_w): where the next solve starts; multipliers start again.

        Raises ValueError for other shapes, or numbers that are not finite.
        """
        z, w = np.ascontiguousarray(z, dtype=float), np.ascontiguousarray(w, dtype=float)
        if z.shape != self.z.shape or w.shape != self.w.shape:
            raise ValueError(f"guess: expected {self.z.shape} and {self.w.shape}, found {z.shape} and {w.shape}")
        self.controller.call("guess", z, w)

    def shift(self, seconds: float) -> None:
        """Move the last solution on by `seconds`, so that it starts the next solve; ValueError beyond the horizon."""
        self.controller.call("shift", ctypes.c_double(seconds))

    def limit_speed(self, most: float) -> None:
        """Let plans be no faster than `most` (m/s), softly, within the problem's own limits of u."""
        least, greatest = self.ocp.state_box["u"]
        row = list(self.ocp.state_box).index("u")
        self.controller.head.options.limits[row][1] = min(greatest, max(least + SETTINGS.least_room, most))

    def prepare(self) -> None:
        """All that can be done before the state is known: linearisation and Hessian at the present guess."""
        began = time.perf_counter()
        self.controller.call("linearise")
        self._spent = time.perf_counter() - began

    def make_step(self, z0: ArrayLike) -> Array:
        """(n_w,) first input of the plan from the state z0 (n_z,); see `stats`, and `z`, `w` for the plan itself.

        Raises ValueError for another shape, or before `set_parameters` has said what is to be driven.
        """
        if not self._asked:
            raise ValueError("nmpc: expected set_parameters (s, r, ref, obstacles) before make_step, found none was called")
        z0 = np.ascontiguousarray(z0, dtype=float)
        if z0.shape != self.z[0].shape:
            raise ValueError(f"z0: expected shape {self.z[0].shape}, found {z0.shape}")
        if not self.controller.head.prepared:
            self.prepare()
        began = time.perf_counter()
        status = Status[STATUSES[self.controller.call("step", z0, self._first)][0]]
        feedback = time.perf_counter() - began
        h = self.controller.head
        self.stats = Stats(
            status, h.iterations, h.qp_iterations, self._spent + feedback, feedback, h.cost, h.defect, h.step, h.gap, h.touch,
        )  # fmt: skip
        return self._first.copy()
