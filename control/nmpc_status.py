"""How a solve ended, each outcome with a sentence."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Status(Enum):
    """Outcome of one solve; the value is its sentence."""

    CONVERGED = "the step and the residuals are below their tolerances"
    ITERATED = "one real-time iteration was taken; the next one goes on from it"
    OUT_OF_ITERATIONS = "the iterations ran out before the tolerances were met; the last iterate is used"
    BLOCKED = "the plan meets an obstacle that it finds no way around; the vehicle follows it and brakes before it"
    POSITION_UNKNOWN = "position and velocity not measured for too long, or position too uncertain; the vehicle brakes to a halt"
    STEERING_STUCK = "the measured steering angle does not follow its command; the vehicle brakes to a halt"
    SENSORS_DISAGREE = "measurements of the motion contradict each other, as with a wrong unit, sign or axis; it brakes to a halt"
    NO_STATE = "x, y, psi and u were not yet all measured within half a second; the command is the safe one"
    NOT_CLOSED = "the iterations ran out on a plan that breaks the dynamics; the previous plan goes on"
    NOT_CONVEX = "the convexified subproblem still had no positive reduced Hessian; the previous plan goes on"
    NOT_FINITE = "a value was not finite; the previous plan goes on"
    BAD_STATE = "the measured state is not finite or far outside the model's range; the previous plan goes on"
    LATE = "the solution came after its time; the previous plan was followed meanwhile"
    SOLVER_FAILED = "the solver gave up; the previous plan goes on"

    @property
    def usable(self) -> bool:
        """Whether the solution may be driven."""
        return self in (
            Status.CONVERGED, Status.ITERATED, Status.OUT_OF_ITERATIONS, Status.BLOCKED, Status.POSITION_UNKNOWN,
            Status.STEERING_STUCK, Status.SENSORS_DISAGREE, Status.LATE,
        )  # fmt: skip


@dataclass(frozen=True)
class Stats:
    """Of one solve: status; iterations of the outer method; qp_iterations in all; seconds, of which `feedback` came after
    the state was known; cost of the objective with slacks; defect: largest violation of the dynamics, of a real-time iteration
    what its step was to close; step: largest change; gap: least planned distance to an obstacle (m), touch: first stage of the
    plan that touches one, -1 for none.
    """

    status: Status
    iterations: int = 0
    qp_iterations: int = 0
    seconds: float = 0.0
    feedback: float = 0.0
    cost: float = float("nan")
    defect: float = float("nan")
    step: float = float("nan")
    gap: float = float("inf")
    touch: int = -1

    @property
    def sentence(self) -> str:
        """The status in words."""
        return self.status.value
