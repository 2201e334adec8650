"""Numbers of the solver and of the commands that follow its plans."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SolverSettings:
    """restless: a real-time iteration that moves any variable by more than this is repeated, `repeats` in all at most;
    most, tolerance: iterations and largest change of any variable where a solve is iterated to convergence;
    open_defect: a plan that has run out of iterations with a larger gap in its dynamics (any state's unit) is not driven;
    least_curvature: eigenvalues of a clipped stage Hessian; difference: step of the gradient's differences (units of each
    variable, all of order 1); qp_tolerance, qp_most: complementarity and iterations of the subproblem;
    slowest: least speed of a plan that drives straight on (m/s); least_room: between the least and the greatest one (m/s);
    patience: a plan older than this is not followed (s); straighten: the wheels turn back so fast without a plan (rad/s);
    slowing, braking: accelerations without a plan and to a halt (m/s^2); stopping: share of `braking` that soil and brakes
    give for certain; clear_steps: plans in a row that must clear an obstacle before a halted vehicle goes on.
    """

    restless: float = 0.3
    repeats: int = 3
    most: int = 15
    tolerance: float = 3e-3
    open_defect: float = 0.05
    least_curvature: float = 1e-4
    difference: float = 1e-5
    qp_tolerance: float = 1e-6
    qp_most: int = 30
    slowest: float = 1.0
    least_room: float = 0.1
    patience: float = 1.0
    straighten: float = 0.3
    slowing: float = -1.5
    braking: float = -4.0
    stopping: float = 0.6
    clear_steps: int = 20


SETTINGS = SolverSettings()
