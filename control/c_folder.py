"""Estimator and controller of a declared model as one folder of C."""

from __future__ import annotations

from softsoil.codegen.c_library.kernels import number
from softsoil.codegen.c_library.library import fill, template
from softsoil.codegen.c_library.vehicle import vehicle_words
from softsoil.codegen.sampling import STEP
from softsoil.control.c_controller import HESSIANS, controller_files, controller_values
from softsoil.control.c_driver import driver_files
from softsoil.control.c_estimator import c_library_texts, c_parts
from softsoil.control.c_fmu import driver_fmi_files
from softsoil.control.c_statuses import STATUSES
from softsoil.control.declared import for_control
from softsoil.control.driver_types import DriverSettings
from softsoil.control.ocp import Ocp, OcpSettings
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.tuning import N_NAMES
from softsoil.symbolic.signals import Layout

EXAMPLE_OBSTACLES = ((62.0, 1.6, 1.0, 0.0, 0.0), (90.0, 2.4, 1.0, 0.0, 0.0))
"""x, y, radius (m) and velocity (m/s) of the obstacles in example_drive.c."""


def controller_texts(
    declared: Declaration, dt: float = STEP, fmi: bool = False, settings: OcpSettings | None = None, hessian: str = HESSIANS[0],
    driver: DriverSettings | None = None,
) -> dict[str, str]:  # fmt: skip
    """Every file of estimator and controller, path -> text, for a declared model.

    The model gets the effects of `for_control` where its vehicle declares none, as everywhere in control. dt: nominal step of the
    estimator (s); fmi: with the FMI unit's files; settings: of the optimal control problem; hessian: of the controller;
    driver: declared numbers of the driver, which without them ticks every dt. Raises ValueError for a step or a Hessian that is
    not possible.
    """
    driver = driver or DriverSettings(tick=dt, plan_every=max(round(DriverSettings().period / dt), 1))
    declared = for_control(declared)
    ocp = Ocp(declared.build(), declared.vehicle, settings)
    values = controller_values(ocp) | _tables(ocp)
    model = c_parts(declared).model
    soil = ", ".join(f"SOFTSOIL_X_{name}" for name in model.x.names if name in N_NAMES)
    obstacles = ", ".join(f"{{{', '.join(number(v) for v in place)}}}" for place in EXAMPLE_OBSTACLES)
    values |= {"soil_indices": soil, "example_obstacles": obstacles, "example_n": number(declared.soil.n)}
    unit = driver_fmi_files(declared.soil.n, values, driver.tick) if fmi else {}
    own = {"example_drive.c": "example_drive.c.in", "CONTROLLER.md": "CONTROLLER.md.in"}
    library = c_library_texts(declared, dt, fmi)
    values |= vehicle_words("include/softsoil_vehicle.h" in library, "")
    return {
        **library,
        **controller_files(ocp, hessian),
        **driver_files(ocp, model, values, driver),
        **unit,
        **{path: fill(template(name), values) for path, name in own.items()},
    }


def _tables(ocp: Ocp) -> dict[str, str]:
    """The tables of CONTROLLER.md by their place in the template."""
    statuses = ["| value | status | meaning |", "|---|---|---|"]
    statuses += [f"| {value} | `SOFTSOIL_NMPC_{name}` | {text} |" for value, (name, text) in enumerate(STATUSES)]
    return {
        "table_z": _table("Z", ocp.z), "table_w": _table("W", ocp.w), "table_s": _table("S", ocp.s),
        "table_nmpc_statuses": "\n".join(statuses),
    }  # fmt: skip


def _table(prefix: str, layout: Layout) -> str:
    rows = ["| symbol | unit | meaning | nominal |", "|---|---|---|---|"]
    rows += [f"| `SOFTSOIL_NMPC_{prefix}_{s.name}` | {s.unit or '1'} | {s.doc} | {s.nominal:g} |" for s in layout]
    return "\n".join(rows)
