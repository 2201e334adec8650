"""Every open effect tried on a bench, each from plausible starts, ranked by what it removes of the held-out cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from joblib import Parallel, delayed

from softsoil.refinement.rules import RULES
from softsoil.refinement.trace import Bench, Candidate, try_effect
from softsoil.symbolic.effect import Effect


def starts_of(effect: Effect) -> list[dict[str, float]]:
    """Where the fit of an effect starts: plausible sizes, the leading parameter on both sides of absence where it may be."""
    lead = effect.parameters[0]
    mirrored = 2 * lead.nominal - effect.typical[lead.name]
    starts = [dict(effect.typical)]
    if lead.lower <= mirrored:
        starts.append({**effect.typical, lead.name: mirrored})
    return starts


def placed(effect: Effect) -> bool:
    """Whether the effect begins at a place, which is tried, not fitted: a window sees only what it crosses."""
    return bool(effect.place)


def try_places(bench: Bench, effect: Effect) -> Candidate:
    """An effect that begins at a place, tried at places along the first drive; the best on its fit windows."""
    drive = bench.shootings[0].drive
    end = drive.first + (len(drive.t) - drive.first) * RULES.fit_share
    spacing = (end - drive.first) / (RULES.places + 1)
    lead = effect.parameters[0].name

    def at(row: float) -> Candidate:
        place = dict(zip(effect.place, drive.smooth[round(row), :3], strict=True))
        return try_effect(bench, effect, [{lead: size, **place} for size in RULES.place_sizes], effect.place)

    tried = {row: at(row) for row in drive.first + spacing * np.arange(1, RULES.places + 1)}
    best = min(tried, key=lambda row: tried[row].fit.cost)
    tried |= {row: at(row) for row in (best - spacing / 3, best + spacing / 3)}
    return min(tried.values(), key=lambda candidate: candidate.fit.cost)


def rank(
    bench: Bench, effects: Mapping[str, Effect], workers: int, progress: Callable[[float], None]
) -> list[Candidate]:
    """All given effects that the bench's model has, best held-out gain first; workers: threads."""
    effects = {name: effect for name, effect in effects.items() if all(s.name in bench.model.p for s in effect.parameters)}

    def one(effect: Effect) -> Candidate:
        return try_places(bench, effect) if placed(effect) else try_effect(bench, effect, starts_of(effect))

    found: list[Candidate] = []
    if workers <= 1:
        for effect in effects.values():
            found.append(one(effect))
            progress(len(found) / len(effects))
    else:
        # Threads: the rollouts are C that releases the interpreter.
        for candidate in Parallel(n_jobs=workers, prefer="threads", return_as="generator_unordered")(
            delayed(one)(effect) for effect in effects.values()
        ):
            found.append(candidate)
            progress(len(found) / len(effects))
    return sorted(found, key=lambda c: -c.gain)
