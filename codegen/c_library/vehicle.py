"""The C library's look at the vehicle, where the errors of its numbers are known: values of the templates' keys."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.c_library.kernels import number, write_kernel
from softsoil.codegen.c_library.parts import Parts

Array = NDArray[np.float64]

FILES = {
    "include/softsoil_vehicle.h": "softsoil_vehicle.h.in",
    "src/softsoil_vehicle.c": "softsoil_vehicle.c.in",
}
"""Where each template goes."""
KERNELS = "src/softsoil_vehicle_kernels.h"
_FUNCTIONS = ("before", "after", "measure", "read", "advance")


@dataclass(frozen=True)
class VehicleNumbers:
    """What is known of a vehicle's numbers, and of its load.

    parts: of the model with the numbers, the mass of a load and the steering's scale, as parameters; names (K,): of the numbers;
    std (K,): their standard deviations; information (K, K): inverse of their joint covariance; load: name of the mass of a load
    (kg); mass: of the vehicle (kg); load_known: standard deviation of a load that nothing is known of, as a share of the mass;
    load_std: of the declared load, as a share of it; loads: shares of the mass between which a load is believed; substeps: steps
    of the model inside one of the horizon's; best_sensor (n_y,): least standard deviations that sensors are believed to have;
    scale: name of the steering's scale; ratio: the declared one; scale_known: standard deviation of it.
    """

    parts: Parts
    names: Sequence[str]
    std: Array
    information: Array
    load: str
    mass: float
    load_known: float
    load_std: float
    loads: tuple[float, float]
    substeps: int
    best_sensor: Sequence[float]
    scale: str
    ratio: float
    scale_known: float


def vehicle_values(numbers: VehicleNumbers, own: Parts, free_step: float, horizon: dict[str, str]) -> dict[str, str]:
    """Key -> text for the templates of the look at the vehicle.

    numbers: what is known of it; own: the parts of the library's model, whose parameters the caller may change; free_step: of
    differences, as a share of what a number may move in a step of a fit; horizon: values of the horizon's templates.
    """
    model, p = numbers.parts.model, numbers.parts.model.p
    there = own.model.p.names
    units = [*numbers.std, numbers.mass, numbers.ratio]
    # Half a standard deviation, and a tenth of mass or steering, are what a fit moves in a step.
    steps = [free_step / 2] * len(numbers.names) + [free_step / 10] * 2
    moved = (*numbers.names, numbers.load, numbers.scale)
    scaled = numbers.information * np.outer(numbers.std, numbers.std)
    rows = ", ".join("{" + ", ".join(number(float(value)) for value in row) + "}" for row in scaled)
    about = (model.name, tuple(p), rows, units, numbers.load_known, numbers.load_std, horizon["h_magic"])
    return {
        "o_numbers": str(len(numbers.names)), "o_samples": str(int(horizon["h_longest_window"]) + 1),
        "o_n_p": str(len(p)), "o_calls": str(numbers.parts.calls), "o_arguments": str(len(numbers.parts.arguments)),
        "o_outputs": str(len(numbers.parts.outputs)), "o_magic": hashlib.sha256(repr(about).encode()).hexdigest()[:8],
        "o_shared": ", ".join(str(there.index(name) if name in there else -1) for name in p.names),
        "o_declared": _list(p.nominal), "o_at": ", ".join(str(p.names.index(name)) for name in moved),
        "o_unit": _list(units), "o_step": _list(steps), "o_known": rows, "o_known_load": number(numbers.load_known**-2),
        "o_known_scale": number(numbers.scale_known**-2),
        "o_load_std": number(numbers.load_std), "o_lightest": number(numbers.loads[0]), "o_heaviest": number(numbers.loads[1]),
        "o_substeps": str(numbers.substeps), "o_best_sensor": _list(numbers.best_sensor),
    }  # fmt: skip


def vehicle_words(there: bool, about: str) -> dict[str, str]:
    """Key -> text for README and example; there: whether the library looks at its vehicle, else all are empty; about: what the
    README says of it."""
    words = {
        "about_vehicle": about.rstrip("\n"),
        "vehicle_row": "| `include/softsoil_vehicle.h`, `src/softsoil_vehicle.c`, "
        f"`{KERNELS}` | whether the vehicle is the one that was identified |",
        "vehicle_include": '#include "softsoil_vehicle.h"',
        "vehicle_declare": "  static softsoil_vehicle_t look;\n  softsoil_vehicle_init(&look);",
        "vehicle_update": "    softsoil_vehicle_update(&look, &h);",
        "vehicle_say": '  if (look.windows == 0) printf("vehicle: not looked at yet\\n");\n'
        '  else printf("vehicle: load %+.1f +- %.1f %% of its mass, strain %.1f%s\\n", 100 * look.load, 100 * look.load_std,\n'
        '              look.strain, look.change == SOFTSOIL_VEHICLE_UNKNOWN ? ", a load would not show yet" : "");\n'
        '  if (look.change == SOFTSOIL_VEHICLE_OTHER_STEERING)\n'
        '    printf("steering: road wheels turn %+.1f +- %.1f %% farther than steer says\\n", 100 * look.steering,\n'
        '           100 * look.steering_std);',
    }
    return {key: f"{text}\n" if there else "" for key, text in words.items()}


def vehicle_kernels(numbers: VehicleNumbers) -> str:
    """src/softsoil_vehicle_kernels.h: the equations with the vehicle's numbers as parameters, one scalar at a time.

    numbers: what is known of the vehicle, with the model's parts.
    """
    parts = numbers.parts
    kernels = [write_kernel(getattr(parts, name), f"own_{name}") for name in _FUNCTIONS]
    kernels += [write_kernel(law.function, f"own_law_{k}") for k, law in enumerate(parts.laws)]
    return (
        "/* The model's equations with the vehicle's numbers as parameters, generated: never edited by hand. */\n"
        "#ifndef SOFTSOIL_VEHICLE_KERNELS_H\n#define SOFTSOIL_VEHICLE_KERNELS_H\n\n"
        + "\n".join(kernels)
        + f"\n/* RUN(first wheel, wheels, the law). */\n#define SOFTSOIL_OWN_LAWS(RUN) {parts.law_runs('own_law')}\n\n#endif\n"
    )


def _list(values: Sequence[float] | Array) -> str:
    return ", ".join(number(float(value)) for value in values)
