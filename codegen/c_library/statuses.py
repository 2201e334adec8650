"""What a call of the C library may return, the graver the later, each with its plain sentence."""

from __future__ import annotations

STATUSES = (
    ("OK", "done"),
    ("STANDSTILL", "the vehicle stands, crawls or reverses: the soil's parameters are held"),
    ("NO_MEASUREMENT", "no measurement could be used: the estimate is the prediction"),
    ("MEASUREMENT_REPEATED", "a measurement with a time stamp that it had before, or an older one, was left out"),
    ("MEASUREMENT_GATED", "a measurement too far from its prediction was left out"),
    ("MEASUREMENT_OUT_OF_RANGE", "a measurement beyond reason was left out"),
    ("MEASUREMENT_NOT_FINITE", "a measurement that is not a finite number was left out"),
    ("NEGATIVE_SPEED", "the measured speed is negative: the model does not reverse, the soil's parameters are held"),
    ("INPUT_OUT_OF_RANGE", "an input beyond reason was replaced by its last good value"),
    ("INPUT_NOT_FINITE", "an input that is not a finite number was replaced by its last good value"),
    ("GATE_REOPENED", "a measurement was outside the gate for so long that it is believed: its state was put where it is"),
    ("SOIL_KEPT", "a jump of n is revoked: the seconds after it do not bear it out, what was known of n before counts again"),
    ("SOIL_CHANGED", "innovations say that n has jumped, the soil is another one: n was put there and made uncertain"),
    ("DRIFT", "corrections go to one side for longer than a right model's do: see drift and drift_channel"),
    ("INCONSISTENT", "measurements are further from their predictions than noise explains: wrong soil, vehicle or noise"),
    ("NUMERICAL", "the model had no finite answer: the last estimate was kept"),
    ("MEASUREMENT_LATE", "the measurement is older than one step and was not used"),
    ("MEASUREMENT_EARLY", "the measurement is later than the estimate by more than one step: predict first"),
    ("TIME_NOT_FINITE", "the time stamp is not a finite number: nothing was done"),
    ("DT_ZERO", "the time step is zero: nothing was done"),
    ("DT_NEGATIVE", "the time step is negative: nothing was done"),
    ("DT_NOT_FINITE", "the time step is not a finite number: nothing was done"),
    ("DT_TOO_LONG", "the time step is longer than the library takes: nothing was done"),
    ("BAD_ARGUMENT", "an argument is not a finite number or out of its range: nothing was done"),
    ("NOT_INITIALISED", "the init function of this structure has not been called, or that of another version was"),
    ("NULL_POINTER", "a pointer is null: nothing was done"),
)  # fmt: skip
"""(name, sentence); the C name is SOFTSOIL_<name>, its value the place in this table."""
REFUSED = "MEASUREMENT_LATE"
"""From this one on the call did nothing."""


def status_enum() -> str:
    """The lines of enum softsoil_status."""
    return "\n".join(f"  SOFTSOIL_{name}, /* {text} */" for name, text in STATUSES)


def status_cases() -> str:
    """The cases of softsoil_status_text: a table of pointers would have to be relocated, which some linkers write to."""
    return "\n".join(f'    case SOFTSOIL_{name}:\n      return "{text}";' for name, text in STATUSES)
