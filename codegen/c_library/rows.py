"""The C library's rows from sensors of different rates: values of the templates' keys."""

from __future__ import annotations

from softsoil.codegen.c_library.kernels import number
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.forward import HELD_INPUTS
from softsoil.symbolic.model import Model

FILES = {
    "include/softsoil_rows.h": "softsoil_rows.h.in",
    "src/softsoil_rows.c": "softsoil_rows.c.in",
}
"""Where each template goes."""
INPUTS = ("steer", "steer_rate", "a_x", *WHEEL_CHANNELS)
TOGETHER, LONGEST, PAUSE, SLOPE = 0.5, 1.0, 5.0, 0.06
"""s: age of samples that a first state is made of, longest delay, silence after which rows begin anew, and to either side of a
row the speeds whose slope stands for an accelerometer."""
FARTHEST = 1e12
"""s: beyond it a time stamp is none."""


def rows_values(model: Model) -> dict[str, str]:
    """Key -> text for the templates of the rows; empty for a model that is not of a vehicle's six states and usual inputs."""
    if model.y.names != STATE_CHANNELS or {*model.external.names} != {*INPUTS}:
        return {}
    numbers = {"gap": HELD_INPUTS, "together": TOGETHER, "longest": LONGEST, "pause": PAUSE, "slope": SLOPE, "farthest": FARTHEST}
    sensors = ", ".join(f"SOFTSOIL_SENSOR_{name}" for name in model.y.names)
    return {f"rows_{key}": number(value) for key, value in numbers.items()} | {"rows_measured_by": sensors}


def rows_words(there: bool) -> dict[str, str]:
    """Key -> text for the README; there: whether the library has them, else all are empty."""
    words = {
        "rows_row": "| `include/softsoil_rows.h`, `src/softsoil_rows.c` | rows from sensors of different rates, late and out of "
        "order |",
        "about_rows": "- **Sensors of different rates** (`softsoil_rows.h`): `softsoil_rows_put` in each callback; a fixed\n"
        "  delay later `softsoil_rows_next` gives rows, inputs interpolated, NaN for what is not there. The latest value of\n"
        "  each topic in the place of it makes n wrong: a steering angle lags by half a period and its latency.",
    }
    return {key: f"{text}\n" if there else "" for key, text in words.items()}
