"""From a ranking to a verdict: effects accepted one after the other while held-out data support them, and no further."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from softsoil.refinement.fit import Fit
from softsoil.refinement.folds import cross_validated
from softsoil.refinement.ranking import placed, rank
from softsoil.refinement.trace import Bench, Candidate, fit_base, held_cost, open_effects, reweighted
from softsoil.symbolic.declaration import Declaration
from softsoil.symbolic.effect import Effect

LEAST_GAIN = 0.2
"""An effect must remove this share of the held-out cost beyond sensor noise: the declared model's own error lets any flexible
term gain some, up to 17 % on multi-sine drives with nothing added."""
LATER_GAIN = 0.35
"""A second effect must remove this share of what the first has left: the smaller the remainder, the more of it is the declared
model's own error."""
LEAST_WHOLE = 0.15
"""An effect must remove this share of the whole held-out cost, sensor noise and all: less would not show in what the model
predicts, and what the catalogue lacks can look like one of its entries by as much (12 % for odd tyres as a payload)."""
LEAST_WHOLE_APART = 0.08
"""The same for an effect of the outputs alone or of a place. Kinematics and places are nothing that a force law knows of, so that
the declared model's own error hardly looks like it (3 % at most where nothing was added)."""
ONE_WAVE_GAIN = 0.5
"""A first effect must remove this share where the steering repeats one wave: few ways of moving make any two effects alike, and
the declared model's own error has made one gain 37 %."""
LEAST_SIZE = 0.05
"""An effect must reach this share of its plausible spread: every declared model has a fault of smaller size (44 N m of yaw moment
on a drive with nothing added), and without noise the smallest one stands out."""
CHANCE = 0.05
"""Chance that a candidate reaches its gain by the scatter of the held-out windows alone (Student's t, few as they are). Its
parameter is tested on the windows of the fit, so that the chance of both, over all candidates, is about one per cent."""
LEAST_PARAMETER_SIGMAS = 3.0
"""Its leading parameter must stand this many standard errors from absence, unless the held-out windows alone leave no doubt."""
BEYOND_DOUBT = 0.0004
"""Chance of a gain by scatter alone that over all candidates makes one per cent: a size that trades with n is uncertain even
where absence is out of the question."""
PLACE_SIGMAS = 4.5
"""A change at a place that stands so many standard errors from absence in a fit to the whole drive needs no size of gain: places
are nothing that the declared model's own error knows of, so that standard errors hold (the best place of eight stood 3.9 of them
from absence at most on 95 drives without a change), and where n hardly moves the forces it moves the predictions little."""
MOST_EFFECTS = 3
MOST_ALIKE = 2
"""Of more effects than this that explain the data alike none is named: that would be a guess."""
CONTENDERS, CONTENDER = 5, 0.04
"""How many of the best over all windows are judged on the whole drive, and the share of the cost from which on they are: the last
third alone may hold little of what an effect changes."""
SECOND_LOOK = 8
"""Effects of the first ranking that are looked at again once one has been accepted."""
LIKE_GAIN = 0.03
"""Two effects whose held-out costs differ by less than this share of the cost cannot be told apart."""


@dataclass(frozen=True)
class Selection:
    """What the data support beyond the declared model.

    accepted: effects in order; bench: with them in the model; ranking: of the first round; groups: per accepted effect, the
    effects that explain the held-out data as well (itself first), and last a group of which none could be named.
    """

    accepted: tuple[Candidate, ...]
    bench: Bench
    ranking: tuple[Candidate, ...]
    groups: tuple[tuple[str, ...], ...]


def select(
    bench: Bench,
    declaration: Declaration,
    workers: int,
    progress: Callable[[float], None],
    one_wave: bool = False,
    names: Sequence[str] | None = None,
) -> Selection:
    """Forward selection over the catalogue, declared effects left out unless a drive may have more of them.

    workers: effects tried at once; progress: called with the share of the first round that is done; one_wave: the steering
    repeats one wave: more is asked of an effect, and of two that these data cannot separate none is named; names: of the effects
    that are tried, default all.
    """
    tried = open_effects(declaration, names)
    first = rank(bench, tried, workers, progress)
    ranking: list[Candidate] = first
    accepted: dict[str, Candidate] = {}
    groups: dict[str, tuple[str, ...]] = {}
    seen: set[frozenset[str]] = set()
    while len(accepted) < MOST_EFFECTS:
        least = ONE_WAVE_GAIN if one_wave else LATER_GAIN if accepted else LEAST_GAIN
        judged, others = contended(bench, ranking, workers, one_wave)
        ranking = [*judged, *others]
        if not accepted:
            first = ranking
        evident = not (one_wave or accepted)
        best = next(
            (
                c
                for c in judged
                if supported(c, tried[c.name], least) or (evident and placed_for_sure(c, tried[c.name]))
            ),
            None,
        )
        if best is None:
            break
        groups[best.name] = (best.name, *like(best, ranking, bench))
        if len(groups[best.name]) > (1 if one_wave else MOST_ALIKE):
            break
        accepted[best.name] = best
        bench, dropped = accept(bench, best, {name: tried[name] for name in accepted})
        for name in dropped:
            del accepted[name], groups[name]
        if frozenset(accepted) in seen:  # the same set again: no more to gain by exchange
            break
        seen.add(frozenset(accepted))
        again = [c.name for c in first if c.name not in accepted and c.name not in dropped][:SECOND_LOOK]
        ranking = rank(bench, {name: tried[name] for name in again}, workers, lambda share: None)
    return Selection(tuple(accepted.values()), bench, tuple(first), tuple(groups.values()))


def contended(
    bench: Bench, ranking: Sequence[Candidate], workers: int, one_wave: bool
) -> tuple[list[Candidate], list[Candidate]]:
    """The best few of a ranking, judged on the whole drive, and the others as they are; workers, one_wave: as of `select`."""
    fitted = sum(len(part) for part in bench.fitted)
    before = held_cost(replace(bench, held=bench.fitted), bench.absent).sum() + held_cost(bench, bench.absent).sum()

    def removed(candidate: Candidate) -> float:
        """Share of the cost of all windows, fitted and held out, that the candidate's first fit removes."""
        return float(1.0 - (candidate.fit.cost * fitted + candidate.windows.sum()) / before)

    few = [c for c in sorted(ranking, key=lambda c: -removed(c)) if removed(c) >= CONTENDER][:CONTENDERS]
    return cross_validated(bench, few, workers, one_wave), [c for c in ranking if c not in few]


def supported(candidate: Candidate, effect: Effect, least: float = LEAST_GAIN) -> bool:
    """Whether held-out data support the effect: a gain of at least `least`, its significance, a leading parameter identified."""
    sigmas = least_sigmas(len(candidate.windows))
    if not (
        candidate.gain >= least and candidate.gain >= sigmas * candidate.std and candidate.whole >= least_whole(effect)
    ):
        return False
    lead = effect.parameters[0].name
    if any(name == lead or name not in effect.parameters for name in candidate.fit.at_bound):
        return False
    if size(candidate.fit, effect) < LEAST_SIZE:
        return False
    beyond_doubt = candidate.gain >= least_sigmas(len(candidate.windows), BEYOND_DOUBT) * candidate.std
    return beyond_doubt or strength(candidate.fit, effect) >= LEAST_PARAMETER_SIGMAS


def placed_for_sure(candidate: Candidate, effect: Effect) -> bool:
    """Whether all windows leave no doubt of a change at a place, which must also predict what was held out better than none."""
    if not placed(effect) or candidate.overall is None or candidate.overall.at_bound:
        return False
    sure = strength(candidate.overall, effect) >= PLACE_SIGMAS
    return sure and candidate.gain > 0.0 and size(candidate.overall, effect) >= LEAST_SIZE


def least_whole(effect: Effect) -> float:
    """Share of the whole held-out cost that the effect must remove."""
    return LEAST_WHOLE_APART if set(effect.corrections) == {"outputs"} or placed(effect) else LEAST_WHOLE


def least_sigmas(windows: int, chance: float = CHANCE) -> float:
    """Standard errors that a gain over so many held-out windows reaches by scatter with this chance; NaN for a single one."""
    return float(stdtrit(windows - 1, 1.0 - chance)) if windows > 1 else float("nan")


def size(fit: Fit, effect: Effect) -> float:
    """The effect's departure from absence over its plausible spread: of the leading parameter or one of its kind (its unit)."""
    values, lead = fit.named(), effect.parameters[0]
    return max(
        (
            abs(values[s.name][0] - s.nominal) / s.spread
            for s in effect.parameters
            if s.name in values and s.unit == lead.unit and np.isfinite(s.spread)
        ),
        default=float("inf"),
    )


def strength(fit: Fit, effect: Effect) -> float:
    """How many standard errors the effect's best determined parameter stands from absence; 0 where none is free."""
    values = fit.named()
    return max(
        (
            abs(values[s.name][0] - s.nominal) / max(values[s.name][1], 1e-12)
            for s in effect.parameters
            if s.name in values
        ),
        default=0.0,
    )


def like(best: Candidate, ranking: list[Candidate], bench: Bench) -> tuple[str, ...]:
    """Effects that explain the held-out windows as well as the best one does, window by window."""
    total = float(held_cost(bench, bench.absent).mean())
    names = []
    for other in ranking:
        if other.name == best.name or other.gain < LEAST_GAIN or other.gain < 0.5 * best.gain:
            continue
        if len(other.windows) != len(best.windows):  # not among those that were judged on the whole drive
            continue
        apart = other.windows - best.windows
        error = float(apart.std(ddof=1)) / np.sqrt(len(apart))
        if apart.mean() < max(error, LIKE_GAIN * total):
            names.append(other.name)
    return tuple(names)


def accept(bench: Bench, candidate: Candidate, effects: Mapping[str, Effect]) -> tuple[Bench, tuple[str, ...]]:
    """The bench with the candidate in the model, and the names of earlier effects that it has made superfluous.

    effects: all accepted ones, the candidate's among them. Their parameters stay free; an effect that no longer stands off
    its absence was in the place of this one, and goes. Channels are weighted anew by what the grown model leaves of them:
    against the first model's errors a second effect would hardly show.
    """
    own = [f for f in candidate.fit.free if f.name in effects[candidate.name].parameters]
    grown = replace(bench, absent=candidate.fit.p, accepted=(*bench.accepted, *own))
    refit = fit_base(grown)
    grown = replace(grown, absent=refit.p)
    dropped = tuple(
        name
        for name, effect in effects.items()
        if name != candidate.name and strength(refit, effect) < LEAST_PARAMETER_SIGMAS
    )
    if not dropped:
        return reweighted(grown), ()
    p, gone = grown.absent.copy(), {s.name for name in dropped for s in effects[name].parameters}
    for name in dropped:
        for signal in effects[name].parameters:
            p[:, grown.model.p.index(signal.name)] = signal.nominal
    grown = replace(grown, absent=p, accepted=tuple(f for f in grown.accepted if f.name not in gone))
    return reweighted(replace(grown, absent=fit_base(grown).p)), dropped
