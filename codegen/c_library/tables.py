"""What the C library says of itself: formulation.json, and the tables of its README."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from softsoil.codegen.c_library.parts import SAID, SOIL, TOLD, Parts
from softsoil.codegen.c_library.statuses import REFUSED, STATUSES
from softsoil.symbolic.signals import Layout


def formulation(parts: Parts, numbers: Any, dt: float, declared: Mapping[str, object]) -> dict[str, object]:
    """formulation.json: states, inputs, parameters, measurements, histories, effects, options, versions."""
    model = parts.model
    return {
        "model": model.name,
        **declared,
        "effects": list(model.effects),
        "states": _signals(model.x),
        "inputs": _signals(model.external),
        "parameters": _signals(model.p),
        "measurements": _signals(model.y),
        "soil_states": list(numbers.soil),
        "past_values": numbers.change_samples,
        "drift_channels": {channel.name: channel.likely for channel in numbers.drift.channels},
        "memory_cells": len(model.cells),
        "provided_inputs": len(model.u) - len(model.external),
        "force": {"soil": list(SOIL), "contact": list(TOLD), "result": list(SAID)},
        "options": {
            "dt": dt,
            "method": "euler",
            "q_std": list(numbers.q_std),
            "r_std": list(numbers.r_std),
            "std0": list(numbers.std0),
            "gate": numbers.gate,
            "gate_patience": numbers.patience,
            "gate_patience_rates": numbers.patience_rates,
            "miss_std": list(numbers.miss_std),
            "kick_std": list(numbers.kick_std),
            "fastest": numbers.fastest,
            "run_in": numbers.run_in,
            "common_error": numbers.common_error,
            "change_after": numbers.change_after,
            "change_sigmas": numbers.change_sigmas,
            "change_std": numbers.change_std,
            "change_error": numbers.change_error,
            "states_on_which_wheels_depend": list(parts.active),
        },
    }


def _signals(layout: Layout) -> list[dict[str, object]]:
    return [
        {
            "name": s.name,
            "unit": s.unit,
            "doc": s.doc,
            "nominal": s.nominal,
            "lower": s.lower if math.isfinite(s.lower) else None,
            "upper": s.upper if math.isfinite(s.upper) else None,
        }
        for s in layout
    ]


def readme_tables(parts: Parts) -> dict[str, str]:
    """The tables of README.md by their place in the template."""
    model = parts.model
    return {
        "table_states": _table("X", model.x),
        "table_inputs": _table("U", model.external),
        "table_parameters": _table("P", model.p),
        "table_measurements": _table("Y", model.y),
        "table_statuses": _statuses(),
    }


def _table(prefix: str, layout: Layout) -> str:
    rows = ["| index | symbol | unit | meaning | nominal |", "|---|---|---|---|---|"]
    for s in layout:
        rows.append(f"| `SOFTSOIL_{prefix}_{s.name}` | {s.name} | {s.unit or '1'} | {s.doc} | {s.nominal:g} |")
    return "\n".join(rows)


def _statuses() -> str:
    rows = ["| value | status | meaning |", "|---|---|---|"]
    names = [name for name, _ in STATUSES]
    for value, (name, text) in enumerate(STATUSES):
        refused = "" if value < names.index(REFUSED) else " *(refused)*"
        rows.append(f"| {value} | `SOFTSOIL_{name}` | {text}{refused} |")
    return "\n".join(rows)
