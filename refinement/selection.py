"""From a ranking to a verdict: effects accepted one after the other while held-out data support them, and no further."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from refinement.fit import Free
from refinement.trace import Bench, Candidate, fit_base, held_cost, rank
from symbolic.catalogue import catalogue
from symbolic.declaration import Declaration
from symbolic.effects import Effect

LEAST_GAIN = 0.15
"""An effect must remove this share of the held-out cost: the declared model's own error lets any flexible term gain several
per cent."""
LEAST_SIGMAS = 2.0
"""... and this many standard errors of the gain, over held-out windows."""
LEAST_PARAMETER_SIGMAS = 3.0
"""Its leading parameter must stand this many standard errors from absence."""
MOST_EFFECTS = 3
SECOND_LOOK = 8
"""Effects of the first ranking that are looked at again once one has been accepted."""
LIKE_GAIN = 0.03
"""Two effects whose held-out costs differ by less than this share of the cost cannot be told apart."""


@dataclass(frozen=True)
class Selection:
    """What the data support beyond the declared model.

    accepted: effects in order; last_bench: with them in the model; ranking: of the first round; groups: per accepted
    effect, the effects that explain the held-out data as well (itself first).
    """

    accepted: tuple[Candidate, ...]
    bench: Bench
    ranking: tuple[Candidate, ...]
    groups: tuple[tuple[str, ...], ...]


def select(bench: Bench, declaration: Declaration, workers: int, progress: Callable[[float], None]) -> Selection:
    """Forward selection over the catalogue, declared effects left out.

    workers: effects tried at once; progress: called with the share of the first round that is done.
    """
    known = catalogue(declaration.vehicle)
    open_effects = {name: effect for name, effect in known.items() if name not in declaration.vehicle.effects}
    first = rank(bench, open_effects, workers, progress)
    ranking = first
    accepted: list[Candidate] = []
    groups: list[tuple[str, ...]] = []
    while len(accepted) < MOST_EFFECTS:
        best = next((c for c in ranking if supported(c, open_effects[c.name])), None)
        if best is None:
            break
        groups.append((best.name, *like(best, ranking, bench)))
        accepted.append(best)
        bench = accept(bench, best, open_effects[best.name])
        again = [c.name for c in first if c.name not in {a.name for a in accepted}][:SECOND_LOOK]
        ranking = rank(bench, {name: open_effects[name] for name in again}, workers, lambda share: None)
    return Selection(tuple(accepted), bench, tuple(first), tuple(groups))


def supported(candidate: Candidate, effect: Effect) -> bool:
    """Whether held-out data support the effect: gain, its significance, and parameters that are identified."""
    if candidate.gain < LEAST_GAIN or candidate.gain < LEAST_SIGMAS * candidate.std or candidate.fit.at_bound:
        return False
    values = candidate.fit.named()
    strengths = [
        abs(value - effect.parameters[name].nominal) / max(std, 1e-12)
        for name, (value, std) in values.items()
        if name in effect.parameters
    ]
    return max(strengths) >= LEAST_PARAMETER_SIGMAS


def like(best: Candidate, ranking: list[Candidate], bench: Bench) -> tuple[str, ...]:
    """Effects that explain the held-out windows as well as the best one does, window by window."""
    total = float(held_cost(bench, bench.absent).mean())
    names = []
    for other in ranking:
        if other.name == best.name or other.gain < LEAST_GAIN or other.gain < 0.5 * best.gain:
            continue
        apart = other.windows - best.windows
        error = float(apart.std(ddof=1)) / np.sqrt(len(apart))
        if apart.mean() < max(error, LIKE_GAIN * total):
            names.append(other.name)
    return tuple(names)


def accept(bench: Bench, candidate: Candidate, effect: Effect) -> Bench:
    """The bench with the effect in the model at its fitted parameters, which stay free beside the next candidate."""
    own = {f.name for f in candidate.fit.free if f.name in effect.parameters}
    free: list[Free] = [f for f in candidate.fit.free if f.name in own]
    grown = replace(bench, absent=candidate.fit.p, accepted=(*bench.accepted, *free))
    return replace(grown, absent=fit_base(grown).p)
