"""The moving horizon of the C library: what stands for each @key@ of its templates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from softsoil.codegen.c_library.kernels import number
from softsoil.codegen.c_library.parts import Parts
from softsoil.symbolic.vehicle import Vehicle

FILES = {
    "include/softsoil_horizon.h": "softsoil_horizon.h.in",
    "src/softsoil_horizon.c": "softsoil_horizon.c.in",
}
"""Where each template goes."""
MOTION = ("x", "y", "psi", "u", "v", "omega_z")
"""States that are unknown at the start of a window."""
MOST = 4
"""Parameters that a horizon estimates at most: with them the jobs of a window fill one vector."""
LANES = 8
"""Jobs of a vector. Those that the parameters leave free ask for the yaw inertia and the axles' forces."""
SHORTEST = 0.8
"""Share of the nominal step that a sample interval may be; shorter ones would need more memory."""
KEPT_MORE = 4
"""Windows kept beyond those that may be linearised again: strides are whole samples."""


@dataclass(frozen=True)
class HorizonNumbers:
    """Numbers of the horizon and of its verdict, as the Python classes have them.

    rules: name -> value of HorizonRules; model_error, recent: of them too; limits, unexplained: of VerdictRules;
    splits, least_part: where a drive is cut into an earlier and a later part, and windows of a part at least;
    constants: of the windows' arithmetic; state_step: of differences by the initial state; verdicts: (word, sentence) of each;
    scale: of a soil's parameter.
    """

    rules: Mapping[str, float]
    model_error: Sequence[float]
    recent: Sequence[int]
    limits: Mapping[str, float]
    unexplained: Sequence[float]
    splits: Sequence[float]
    least_part: int
    constants: Mapping[str, float]
    state_step: Sequence[float]
    verdicts: Sequence[tuple[str, str]]
    scale: float


def promoted(parts: Parts) -> tuple[str, ...]:
    """States that nothing moves: parameters in the place of states.

    Raises ValueError for none, for more than a horizon estimates, or for a model without the states of a vehicle.
    """
    x, u, p = parts.model.symbols()
    rates = parts.model.ode()(x, u, p)
    found = tuple(name for i, name in enumerate(parts.model.x.names) if ca.SX(rates[i]).is_zero())
    if not 1 <= len(found) <= MOST or parts.model.x.names[: len(MOTION)] != MOTION:
        raise ValueError(
            f"C library: expected the states {', '.join(MOTION)} and one to {MOST} promoted parameters, "
            f"found {', '.join(parts.model.x.names)} with {len(found)}"
        )
    return found


def about_horizon(parts: Parts, numbers: HorizonNumbers) -> dict[str, object]:
    """What formulation.json says of it: the parameters that it estimates, and the words of its verdicts."""
    return {"promoted": list(promoted(parts)), "verdicts": [word for word, _ in numbers.verdicts]}


def horizon_values(parts: Parts, numbers: HorizonNumbers, dt: float) -> dict[str, str]:
    """Key -> text for the templates of the horizon; dt: nominal step (s)."""
    names, model, rules = promoted(parts), parts.model, numbers.rules
    soil = [name in ("n", "n_f", "n_r") for name in names]
    signals = [model.x[name] for name in names]
    active = [name for name in MOTION if name not in _passive(parts)]
    passive = [name for name in MOTION if name not in active]
    columns = {name: 1 + i for i, name in enumerate([*active, *names])}
    free = LANES - 1 - len(active) - len(names)
    inertia, forces = min(max(free, 0), 1), min(max(free - 1, 0), 2)
    vehicle = model.geometry if isinstance(model.geometry, Vehicle) else None
    forces = forces if vehicle is not None else 0
    apart = -(-(7 + len(names)) // LANES) * LANES
    columns |= {name: apart + i for i, name in enumerate(passive)}
    least = SHORTEST * dt
    held = rules["again"] + rules["length"] + 2 * rules["settling"] + rules["smoothing"] + 0.5
    scales = [numbers.scale if own else (s.upper - s.lower) / 10 for own, s in zip(soil, signals, strict=True)]
    spread = [rules["prior"] if own else 3 * scale for own, scale in zip(soil, scales, strict=True)]
    fast = "steer_rate" in model.external.names
    return {
        "promoted": str(len(names)), "h_k": str(len(names)),
        "h_rows": str(math.ceil(held / least)), "h_windows": str(round(rules["longest"] / rules["stride"]) + 1),
        "h_kept": str(math.ceil(rules["again"] / rules["stride"]) + KEPT_MORE),
        "h_longest_window": str(math.ceil(rules["length"] / least)), "h_min_dt": number(least),
        "h_parameters": ", ".join(f"SOFTSOIL_HORIZON_{name}" for name in names),
        **{f"h_{name}": number(value) for name, value in {**rules, **numbers.constants}.items()},
        "h_model_error": _list(numbers.model_error), "h_recents": str(len(numbers.recent)),
        "h_recent": ", ".join(map(str, numbers.recent)), "h_state_step": _list(numbers.state_step),
        "h_at_state": ", ".join(f"SOFTSOIL_X_{name}" for name in names),
        "h_other_state": ", ".join(f"SOFTSOIL_X_{name}" for name in model.x.names if name not in (*MOTION, *names)) or "0",
        "horizon_strings": ", ".join(f'"{name}"' for name in names),
        "h_is_soil": ", ".join(str(int(own)) for own in soil), "h_scale": _list(scales),
        "h_lower": _list([s.lower for s in signals]), "h_upper": _list([s.upper for s in signals]),
        "h_guess": _list([s.nominal for s in signals]), "h_guess_std": _list(spread),
        "h_state_column": ", ".join(str(columns[name]) for name in MOTION),
        "h_free_column": ", ".join(str(columns[name]) for name in names),
        "h_asked": str(len(names) + inertia + forces), "h_asks_inertia": str(inertia), "h_forces": str(forces),
        "h_to_front": number(vehicle.l_f if vehicle else 1.0), "h_to_rear": number(vehicle.l_r if vehicle else 1.0),
        "h_gyration_2": number(vehicle.yaw_inertia / vehicle.mass if vehicle else 1.0),
        "h_law_percent": f"{100 * rules['law_error']:g}", "h_splits": str(len(numbers.splits)),
        "h_inertia_column": str(1 + len(active) + len(names)),
        "h_split": _list(numbers.splits), "h_least_part": str(numbers.least_part),
        "h_active": str(1 + len(active) + len(names) + inertia + forces), "h_passive": str(len(passive)),
        "h_fast_steering": "  row->blocked = row->blocked || fabs(row->u[SOFTSOIL_U_steer_rate]) > fastest;" if fast else "",
        **{f"v_{name}": number(value) for name, value in numbers.limits.items()},
        "v_unexplained": _list(numbers.unexplained),
        "verdict_enum": "\n".join(f"  {_word(word)}, /* {text} */" for word, text in numbers.verdicts),
        "verdict_cases": "\n".join(f'    case {_word(word)}:\n      return "{text}";' for word, text in numbers.verdicts),
        "table_verdicts": "\n".join(
            ["| value | verdict | meaning |", "|---|---|---|"]
            + [f"| {i} | `{_word(word)}` | {text} |" for i, (word, text) in enumerate(numbers.verdicts)]
        ),
    }  # fmt: skip


def _passive(parts: Parts) -> tuple[str, ...]:
    """States of the motion on which neither wheels nor histories depend: their derivatives need no forces of their own."""
    seen = set(parts.active)
    for function in (parts.read, parts.advance, parts.start):
        if function.size1_out(0):
            _, columns = function.sparsity_jac(0, 0).get_triplet()
            seen |= {parts.model.x.names[column] for column in columns}
    return tuple(name for name in MOTION if name not in seen)


def _word(word: str) -> str:
    return f"SOFTSOIL_VERDICT_{word.upper()}"


def _list(values: Sequence[float]) -> str:
    return ", ".join(number(float(value)) for value in values)
