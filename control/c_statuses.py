"""What a call of the controller in C may return, each with its plain sentence."""

from __future__ import annotations

from softsoil.control.nmpc_status import Status

STATUSES = (
    ("OK", "done"),
    *((status.name, status.value) for status in (
        Status.CONVERGED, Status.ITERATED, Status.OUT_OF_ITERATIONS, Status.BLOCKED, Status.NOT_CLOSED, Status.NOT_CONVEX,
        Status.NOT_FINITE, Status.BAD_STATE, Status.POSITION_UNKNOWN, Status.STEERING_STUCK,
        Status.SENSORS_DISAGREE, Status.NO_STATE,
    )),
    ("BAD_ARGUMENT", "an argument is not a finite number or out of its range: nothing was done"),
    ("NOT_INITIALISED", "softsoil_nmpc_init has not been called for this structure, or another version of it was"),
    ("NULL_POINTER", "a pointer is null: nothing was done"),
)  # fmt: skip
"""(name, sentence); the C name is SOFTSOIL_NMPC_<name>, its value the place in this table."""


def status_enum() -> str:
    """The lines of enum softsoil_nmpc_status."""
    return "\n".join(f"  SOFTSOIL_NMPC_{name}, /* {text} */" for name, text in STATUSES)


def status_cases() -> str:
    """The cases of softsoil_nmpc_status_text."""
    return "\n".join(f'    case SOFTSOIL_NMPC_{name}:\n      return "{text}";' for name, text in STATUSES)
