"""The blind test: drives of the plant with an effect unknown to the tracing, and the score."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from softsoil.declaration.model_file import Declaration
from softsoil.files.json_file import plain
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.mpc_demo.blind_cases import Case, drive_case
from softsoil.mpc_demo.sweep import run_sweep
from softsoil.refinement.refine import refine
from softsoil.refinement.result import Refinement
from softsoil.refinement.words import falls
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.soil import load_soil
from softsoil.symbolic.vehicle import load_vehicle

WITHIN = 0.3
"""A parameter is right within this share of its departure from absence."""
MOST_ALIKE = 2
"""Effects in a group that cannot be separated, of which one is the true one."""


def plant_on(soil: str) -> Declaration:
    """The plant's vehicle with its declared effects on a built-in soil, whose n is the class's: a wrong first guess."""
    return Declaration(load_vehicle(PLANT_VEHICLE), load_soil(soil))


def trace_case(case: Mapping[str, Any]) -> dict[str, Any]:
    """Drive the case on the plant, trace it, score it; JSON values."""
    began = time.perf_counter()
    recording = drive_case(case)
    drove = time.perf_counter() - began
    declared = plant_on(case["soil"])
    names = [effect_of(switch, declared)[0] for switch in case["candidates"]] if "candidates" in case else None
    found = refine([recording], declared, workers=1, candidates=names)
    right, why = score(as_the_catalogue_says(case, declared), found)
    ranking = [
        {"name": c.name, "gain": c.gain, "std": c.std, "whole": c.whole, "values": c.fit.named()}
        for c in found.ranking[:6]
    ]
    content = {
        "right": right,
        "why": why,
        "verdict": found.verdict,
        "effects": found.as_json()["effects"],
        "inseparable": found.inseparable,
        "ranking": ranking,
        "n_before": found.n_before[0],
        "n_after": found.n_after[0],
        "falls": falls(found),
        "left": found.structure[0].share,
        "notes": found.notes,
        "seconds_drive": drove,
        "seconds": found.seconds,
    }
    return plain(content)


def effect_of(switch: str, declared: Declaration) -> tuple[str, tuple[str, ...]]:
    """The effect that answers to a switch of the world, and its parameters that equal what the switch is set to.

    Raises ValueError for a switch to which none answers.
    """
    for effect in catalogue(declared.vehicle).values():
        if switch in effect.answers_to:
            return effect.name, effect.answers_to[switch]
    raise ValueError(f"expected a switch to which an effect of the catalogue answers, found {switch!r}")


def as_the_catalogue_says(case: Mapping[str, Any], declared: Declaration) -> Case:
    """The case with the name of the effect in the place of the world's switch, and the true values of its parameters."""
    if case["kind"] != "effect":
        return {**case, "truth": {}}
    name, parameters = effect_of(case["name"], declared)
    return {**case, "name": name, "truth": dict.fromkeys(parameters, case["truth"])}


def score(case: Mapping[str, Any], found: Refinement) -> tuple[bool, str]:
    """Whether the finding is right, and why not in a few words.

    case: kind, name of the effect and true values of its parameters. An effect: named first, or in the first group of at most
    two, its parameters within 30 %, or no effect where the measured inputs are seen to carry it. Clean: "none". Outside the
    catalogue: no effect named.
    """
    names = [effect.name for effect in found.effects]
    if case["kind"] == "clean":
        return found.verdict == "none", f"{found.verdict} {' '.join(names)}".strip()
    if case["kind"] == "outside":
        return not names, f"{found.verdict} {' '.join(names)}".strip()
    expected = str(case["name"])
    if expected in found.carried and not names:
        return True, "carried by the measured inputs"
    if not names:
        return False, found.verdict
    group = next((g for g in found.inseparable if g[0] == names[0]), (names[0],))
    if names[0] != expected and not (expected in group and len(group) <= MOST_ALIKE):
        return False, f"named {' '.join(names)}"
    off = {name: relative_error(name, value, expected, found) for name, value in case["truth"].items()}
    words = ", ".join(f"{name} {100 * error:+.0f} %" for name, error in off.items())
    return all(abs(error) <= WITHIN for error in off.values()), words


def relative_error(name: str, true: float, effect: str, found: Refinement) -> float:
    """(estimated - true)/(true - absent) of one parameter of an effect, by the final fit or by its own in the ranking."""
    known = catalogue(found.declaration.vehicle)[effect]
    traced = next((e for e in found.effects if e.name == effect), None)
    if traced is not None:
        values = {key: entry[0] for key, entry in traced.parameters.items()}
    else:
        fitted = next(c for c in found.ranking if c.name == effect).fit.named()
        values = {key: entry[0] for key, entry in known.sizes(fitted).items()}
    absent = known.parameters[name].nominal if name in known.parameters else 0.0
    return (values[name] - true) / (true - absent)


def run_blind(
    cases: Sequence[Case], out: Path, workers: int, progress: Callable[[int, dict[str, Any] | None], None]
) -> tuple[list[dict[str, Any] | None], dict[int, str]]:
    """Results of all cases, and the reasons of those that failed; written as they come, resumed where it stopped.

    out: folder of the results; workers: drives at a time; progress: called with each case's place and result.
    """
    results: list[dict[str, Any] | None] = []
    failures: dict[int, str] = {}
    for start in range(0, len(cases), workers):
        done = run_sweep(trace_case, cases[start : start + workers], out, workers)
        for i, result in enumerate(done.results, start):
            results.append(result)
            progress(i, result)
        failures |= {start + i: reason for i, reason in done.failures.items()}
    return results, failures


def totals(cases: Sequence[Case], results: Sequence[dict[str, Any] | None]) -> dict[str, Any]:
    """Drives and right ones per kind and in all; a drive that failed is not right."""
    counts = {}
    for kind in ("effect", "clean", "outside"):
        chosen = [result for case, result in zip(cases, results, strict=True) if case["kind"] == kind]
        counts[kind] = {"drives": len(chosen), "right": sum(1 for r in chosen if r is not None and r["right"])}
    counts["all"] = {key: sum(entry[key] for entry in counts.values()) for key in ("drives", "right")}
    return counts
