"""The C library of a model: every file's text, and the folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from softsoil.codegen.c_library.fmi import fmi_files
from softsoil.codegen.c_library.horizon import FILES as HORIZON_FILES
from softsoil.codegen.c_library.horizon import HorizonNumbers, about_horizon, horizon_values
from softsoil.codegen.c_library.kernels import number, write_kernel
from softsoil.codegen.c_library.parts import SAID, SOIL, TOLD, Parts
from softsoil.codegen.c_library.rows import FILES as ROWS_FILES
from softsoil.codegen.c_library.rows import rows_values, rows_words
from softsoil.codegen.c_library.statuses import STATUSES, status_cases, status_enum
from softsoil.codegen.c_library.tables import formulation, readme_tables
from softsoil.codegen.c_library.vehicle import FILES as VEHICLE_FILES
from softsoil.codegen.c_library.vehicle import KERNELS, VehicleNumbers, vehicle_kernels, vehicle_values, vehicle_words
from softsoil.codegen.factor_order import factor_order
from softsoil.codegen.sampling import LONGEST_STEP, STEP
from softsoil.recording.drive import STATE_CHANNELS, UNSEEN
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout

TEMPLATES = {
    "include/softsoil.h": "softsoil.h.in",
    "src/softsoil_filter.c": "softsoil_filter.c.in",
    "src/softsoil_policy.h": "softsoil_policy.h.in",
    "src/softsoil_model.c": "softsoil_model.c.in",
    "src/softsoil_model.h": "softsoil_model.h.in",
    "src/softsoil_lanes.h": "softsoil_lanes.h.in",
    "README.md": "README.md.in",
    "CMakeLists.txt": "CMakeLists.txt.in",
    "example.c": "example.c.in",
}
"""Where each template goes."""
ALPHA, KAPPA, ZETA = 1.0, 0.0, 2.0
"""Scaling of the unscented transform (paper, eqs. (lambda), (W_0c)): no weight is negative."""
CONSISTENCY_WINDOW, INCONSISTENT, INCONSISTENT_SOIL = 80, 1.3, 1.35
"""Updates over which means of normalised innovations run, and where such a mean is beyond noise: four and a half and three
standard deviations above 1."""


@dataclass(frozen=True)
class DriftSum:
    """One channel of the drift monitor: name, allowance (units of its state per s) and limit, the measurement (index, -1 for
    none) whose noise raises it, and the likely class of its cause.
    """

    name: str
    allowance: float
    limit: float
    sensor: int
    likely: str


@dataclass(frozen=True)
class DriftNumbers:
    """Rules of the drift monitor: after, gap (s), turning (m/s^2), steering (rad/s), most (limits); channels, as in C."""

    after: float
    gap: float
    turning: float
    steering: float
    most: float
    channels: tuple[DriftSum, ...]


@dataclass(frozen=True)
class FilterNumbers:
    """The filter's rules for one model; their meaning stands in `softsoil.estimator.tuning`.

    q_std, kick_std (n_x,): process noise, and beside it while the steering is faster than `fastest` (rad/s) and for `run_in`
    (s) after a start; r_std, miss_std (n_y,): of a sensor, and what the model misses; common_error: share of n; std0, ceiling
    (n_x,): of the first state, and largest; gate: in standard deviations; patience, patience_rates: updates outside it; pose
    (n_y,): which measurements the first is for; soil: states that are n; change_after, change_sigmas, change_std, change_error,
    change_samples, change_youngest, change_clip, trial_determined: of a change of soil; standstill (m/s), held_inputs (s), fade
    (s), leap, wheels_turn (rad/s); u_limit (n_u,), y_limit (n_y,): beyond reason; drift. Raises ValueError for numbers that are
    not positive.
    """

    q_std: tuple[float, ...]
    r_std: tuple[float, ...]
    std0: tuple[float, ...]
    gate: float
    miss_std: tuple[float, ...]
    kick_std: tuple[float, ...]
    fastest: float
    run_in: float
    common_error: float
    ceiling: tuple[float, ...]
    patience: int
    patience_rates: int
    pose: tuple[int, ...]
    soil: tuple[str, ...]
    change_after: float
    change_sigmas: float
    change_std: float
    change_error: float
    change_samples: int
    change_youngest: int
    change_clip: float
    trial_determined: float
    standstill: float
    held_inputs: float
    fade: float
    leap: float
    wheels_turn: float
    u_limit: tuple[float, ...]
    y_limit: tuple[float, ...]
    drift: DriftNumbers

    def __post_init__(self) -> None:
        for name in ("q_std", "r_std", "std0"):
            if not all(value > 0 for value in getattr(self, name)):
                raise ValueError(f"C library: expected positive {name}, found {getattr(self, name)}")


def library_files(
    parts: Parts, numbers: FilterNumbers, horizon: HorizonNumbers, dt: float, declared: Mapping[str, object], fmi: bool = False,
    vehicle: VehicleNumbers | None = None,
) -> dict[str, str]:  # fmt: skip
    """Path inside the folder -> text, for every file of the library.

    parts: of the model; numbers: of the filter; horizon: of the moving horizon; dt: nominal step (s);
    declared: what the model was made of, for formulation.json (vehicle, soil, law, effects, versions);
    fmi: whether the FMI unit's files are wanted; vehicle: what is known of its numbers, None for nothing.
    Raises ValueError for numbers that do not fit the model.
    """
    model = parts.model
    if len(numbers.q_std) != len(model.x) or len(numbers.r_std) != len(model.y) or len(numbers.std0) != len(model.x):
        raise ValueError(
            f"C library: expected {len(model.x)} q_std and std0 and {len(model.y)} r_std, "
            f"found {len(numbers.q_std)}, {len(numbers.std0)} and {len(numbers.r_std)}"
        )
    found = formulation(parts, numbers, dt, declared) | about_horizon(parts, horizon)
    text = json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    values = _values(parts, numbers, dt, found) | readme_tables(parts)
    values |= horizon_values(parts, horizon, dt)
    values["magic"] = hashlib.sha256(text.encode()).hexdigest()[:8]
    values["h_magic"] = hashlib.sha256(repr((text, horizon)).encode()).hexdigest()[:8]
    values |= vehicle_words(vehicle is not None, template("README_vehicle.md.in")) | {"h_look": str(int(vehicle is not None))}
    rows = rows_values(model)
    values |= rows | rows_words(bool(rows))
    templates = TEMPLATES | HORIZON_FILES | (ROWS_FILES if rows else {})
    if vehicle is not None:
        values |= vehicle_values(vehicle, parts, horizon.constants["free_step"], values)
        templates |= VEHICLE_FILES
    out = {path: fill(template(name), values) for path, name in templates.items()}
    out |= {"src/softsoil_kernels.h": _kernels(parts), "formulation.json": text}
    if vehicle is not None:
        out[KERNELS] = vehicle_kernels(vehicle)
    return out | fmi_files(parts, values) if fmi else out


def template(name: str) -> str:
    """The text of a template of the C library, by its file's name."""
    return (files("softsoil.codegen.c_library") / "templates" / name).read_text(encoding="utf-8")


def fill(text: str, values: Mapping[str, str]) -> str:
    """A template's text with @key@ replaced by its value."""
    for key, value in values.items():
        text = text.replace(f"@{key}@", value)
    return text


def _kernels(parts: Parts) -> str:
    """src/softsoil_kernels.h: the equations as C statements."""
    scalar = [write_kernel(getattr(parts, name), f"scalar_{name}") for name in _SCALAR]
    scalar += [write_kernel(law.function, f"scalar_law_{k}") for k, law in enumerate(parts.laws)]
    lanes = [write_kernel(getattr(parts, name), alias, varies) for alias, (name, varies) in _LANES.items()]
    lanes += [write_kernel(law.function, f"kernel_law_{k}", _LAW_VARIES) for k, law in enumerate(parts.laws)]
    lanes += [write_kernel(law.function, f"side_law_{k}", _LAW_VARIES, SIDE) for k, law in enumerate(parts.laws)]
    same = "\n".join(
        [f"#define {alias} scalar_{name}" for alias, (name, _) in _LANES.items()]
        + [f"#define {form}_law_{k} scalar_law_{k}" for k in range(len(parts.laws)) for form in ("kernel", "side")]
    )
    return (
        "/* The model's equations, statement by statement, generated: never edited by hand. */\n"
        "#ifndef SOFTSOIL_KERNELS_H\n#define SOFTSOIL_KERNELS_H\n\n"
        + "\n".join(scalar)
        + f"\n#if SOFTSOIL_LANES == 1\n{write_kernel(parts.measure, 'scalar_measure')}\n{same}\n"
        + "#define SOFTSOIL_SIDE 1\n"
        + "#else\n/* Vectors that side_law_* compute side by side: one alone leaves a processor waiting for itself. */\n"
        + f"#define SOFTSOIL_SIDE {SIDE}\n\n"
        + "\n".join(lanes)
        + f"#endif\n\n{_laws(parts)}#endif\n"
    )


def _laws(parts: Parts) -> str:
    """The table of force laws: first wheel, number of wheels, and the law in its three forms."""
    return (
        "/* RUN(first wheel, wheels, the law at one point, at a vector of points, at several side by side). */\n"
        f"#define SOFTSOIL_LAWS(RUN) {parts.law_runs('scalar_law', 'kernel_law', 'side_law')}\n\n"
    )


SIDE = 2
"""Groups of points for which the force law is computed side by side: its chain of operations is longer than it is wide."""
_LAW_VARIES = (True, False)
_SCALAR = ("before", "after", "read", "advance", "start", "force")
_LANES = {
    "kernel_before": ("before", (True, False, False)),
    "kernel_after": ("after", (True, False, False, True)),
    "kernel_measure": ("measure", (True, False, False, True)),
    "lanes_before": ("before", (True, True, False)),
    "lanes_after": ("after", (True, True, False, True)),
    "lanes_read": ("read", (True, True, False, True)),
    "lanes_advance": ("advance", (True, True, False, True, False, True)),
}
"""Name in C -> function, and which inputs differ from lane to lane."""


def _values(parts: Parts, numbers: FilterNumbers, dt: float, found: Mapping[str, object]) -> dict[str, str]:
    model, vehicle = parts.model, parts.model.geometry
    size = len(model.x)
    order = [model.x.names[i] for i in factor_order(model)]
    spread = ALPHA**2 * (size + KAPPA)
    centre = (spread - size) / spread
    versions = found["versions"]
    assert isinstance(versions, dict)
    soil_names = numbers.soil
    provided = model.u.nominal[len(model.external) :]
    unseen = dict(zip(STATE_CHANNELS, UNSEEN, strict=True))
    restart = [max(std, unseen.get(name, 0.0)) for name, std in zip(model.x.names, numbers.std0, strict=True)]
    wheels = [name for name in model.external.names if name.startswith("omega_")]
    turns = [
        f"  turning = turning || fabs(s->u[SOFTSOIL_U_{name}]) > {number(numbers.wheels_turn)};" for name in wheels
    ]
    return {
        "model": model.name,
        "effects": f" with {', '.join(model.effects)}" if model.effects else "",
        "version": str(versions["softsoil"]), "casadi": str(versions["casadi"]),
        "n_x": str(size), "n_u": str(len(model.external)), "n_p": str(len(model.p)), "n_y": str(len(model.y)),
        "n_m": str(len(model.cells)), "n_u_full": str(len(model.u)),
        "dt": number(dt), "max_step": number(LONGEST_STEP / STEP * dt),
        "states": _enum("X", model.x), "inputs": _enum("U", model.external), "parameters": _enum("P", model.p),
        "measurements": _enum("Y", model.y),
        "status_enum": status_enum(), "status_cases": status_cases(),
        "soil": f"({', '.join(SOIL)})", "contact": f"({', '.join(TOLD)})", "force": f"({', '.join(SAID)})",
        "n_active": str(len(parts.active)), "calls": str(parts.calls), "n_arguments": str(len(parts.arguments)),
        "n_outputs": str(len(parts.outputs)), "measures_forces": str(int(parts.measures_forces)),
        "n_provided": str(len(model.u) - len(model.external)), "provided_nominal": _list(provided if len(provided) else [0.0]),
        "order": ", ".join(str(model.x.index(name)) for name in order),
        "spread": number(spread), "mean_centre": number(centre), "mean_other": number(1 / (2 * spread)),
        "root_centre": number(np.sqrt(centre + 1 - ALPHA**2 + ZETA)), "root_other": number(np.sqrt(1 / (2 * spread))),
        "lower": _list(model.x.lower), "upper": _list(model.x.upper),
        "is_soil": _list([int(name in soil_names) for name in model.x.names]),
        **_drift(numbers.drift),
        "fade": number(numbers.fade), "l_f": number(vehicle.l_f), "l_r": number(vehicle.l_r), "lock": number(vehicle.max_steer),
        "n_soil": str(len(numbers.soil)), "n_past": str(numbers.change_samples), "leap": number(numbers.leap),
        "soil_indices": ", ".join(str(model.x.index(name)) for name in numbers.soil), "y_pose": _list(list(numbers.pose)),
        "y_wraps": _list([int(s.name == "psi" and s.unit == "rad") for s in model.y]),
        "u_limit": _list(numbers.u_limit), "y_limit": _list(numbers.y_limit),
        "measured": _list([model.x.index(s.name) if s.name in model.x.names else -1 for s in model.y]),
        "wheels_turn": "\n".join(turns) if turns else "  turning = 1;",
        "default_p": _list(model.p.nominal), "default_q": _list(numbers.q_std), "default_r": _list(numbers.r_std),
        "default_gate": number(numbers.gate), "default_standstill": number(numbers.standstill),
        "held_inputs": number(numbers.held_inputs),
        "default_max_std": _list(numbers.ceiling), "default_patience": str(numbers.patience),
        "default_patience_rates": str(numbers.patience_rates), "default_miss": _list(numbers.miss_std),
        "default_kick": _list(numbers.kick_std), "default_fastest": number(numbers.fastest),
        "default_run_in": number(numbers.run_in), "default_common": number(numbers.common_error),
        "change_after": number(numbers.change_after), "change_sigmas": number(numbers.change_sigmas),
        "change_std": number(numbers.change_std), "change_error": number(numbers.change_error),
        "change_clip": number(numbers.change_clip), "change_youngest": str(numbers.change_youngest),
        "trial_determined": number(numbers.trial_determined**2),
        "default_x0": _list(model.x.nominal), "default_std0": _list(numbers.std0), "default_u": _list(model.external.nominal),
        "unseen": _list(UNSEEN), "restart_std": _list(restart),
        **_names(model, soil_names), "active_names": ", ".join(parts.active), "bytes": str(structure_bytes(parts, numbers)),
        "window": str(CONSISTENCY_WINDOW), "inconsistent": number(INCONSISTENT), "inconsistent_soil": number(INCONSISTENT_SOIL),
        "driven": ", ".join(parts.driven), "y_driven": _list([int(name in parts.driven) for name in model.y.names]),
    }  # fmt: skip


def _names(model: Model, soil_names: tuple[str, ...]) -> dict[str, str]:
    """Lists of names for the example and the README."""
    soil = [name for name in model.x.names if name in soil_names]
    return {
        "y_names": ", ".join(model.y.names),
        "input_strings": ", ".join(f'"{name}"' for name in model.external.names),
        "measurement_strings": ", ".join(f'"{name}"' for name in model.y.names),
        "state_strings": ", ".join(f'"{name}"' for name in model.x.names),
        "soil_symbols": ", ".join(f"SOFTSOIL_X_{name}" for name in soil),
        "soil_state": f"SOFTSOIL_X_{soil[0]}",
    }


def structure_bytes(parts: Parts, numbers: FilterNumbers) -> int:
    """sizeof(softsoil_t) where doubles have eight bytes and are aligned to them."""
    model = parts.model
    x, u, p, y, full = len(model.x), len(model.external), len(model.p), len(model.y), len(model.u)
    head = 4 * (1 + len(STATUSES) + 2 + 3 + 3 + y)
    middle = 4 * (y + 2)
    doubles = 2 + 2 * x + 2 * y + 3 + x * x + max(len(model.cells), 1) + u + full + y + p + 3 * x + 2 * y + 9
    doubles += 2 + 2 * (numbers.change_samples + 1) * len(numbers.soil) + 6 + 2 * len(numbers.drift.channels)
    return -(-head // 8) * 8 + -(-middle // 8) * 8 + 8 * doubles + 8


def _drift(drift: DriftNumbers) -> dict[str, str]:
    channels = drift.channels
    rows = [f"  SOFTSOIL_DRIFT_{c.name}, /* {c.likely} */" for c in channels]
    return {
        "n_drift": str(len(channels)), "drift_enum": "\n".join(rows),
        "drift_after": number(drift.after), "drift_gap": number(drift.gap),
        "drift_allowance": _list([c.allowance for c in channels]), "drift_limit": _list([c.limit for c in channels]),
        "drift_sensor": _list([c.sensor for c in channels]), "drift_turning": number(drift.turning),
        "drift_steering": number(drift.steering), "drift_most": number(drift.most),
    }  # fmt: skip


def _enum(prefix: str, layout: Layout) -> str:
    return ", ".join(f"SOFTSOIL_{prefix}_{name}" for name in layout.names)


def _list(values) -> str:
    return ", ".join(str(v) if isinstance(v, int) else number(float(v)) for v in values)
