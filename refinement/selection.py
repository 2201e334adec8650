"""From a ranking to a verdict: effects accepted one after the other while held-out data support them, and no further."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import stdtrit

from softsoil.refinement.fit import Fit
from softsoil.refinement.folds import cross_validated
from softsoil.refinement.ranking import placed, rank
from softsoil.refinement.rules import RULES
from softsoil.refinement.trace import Bench, Candidate, fit_base, held_cost, reweighted
from softsoil.refinement.vehicle_numbers import KINDS_OF_GROUND
from softsoil.symbolic.effect import Effect


@dataclass(frozen=True)
class Selection:
    """What the data support beyond the declared model.

    accepted: effects in order; bench: with them in the model; ranking: of the first round; groups: per accepted effect, the
    effects that explain the held-out data as well (itself first), and last a group of which none could be named; tried: effects
    and numbers of the vehicle that were tried, by name; rivals: of those, the effects that the drives cannot name, with the
    channels that they rest on and the drives lack; undecided: effects of which each explains what is left well enough to be named
    first, where these data cannot tell which.
    """

    accepted: tuple[Candidate, ...]
    bench: Bench
    ranking: tuple[Candidate, ...]
    groups: tuple[tuple[str, ...], ...]
    tried: Mapping[str, Effect] = field(default_factory=dict)
    rivals: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    undecided: tuple[str, ...] = ()

    @property
    def unnamable(self) -> tuple[str, ...]:
        """Effects that explain what is left as well as any, or better, but rest on channels that the drives lack."""
        accepted = {candidate.name for candidate in self.accepted}
        open_groups = [group for group in self.groups if group[0] not in accepted]
        return tuple(dict.fromkeys(name for group in open_groups for name in group if name in self.rivals))


def select(
    bench: Bench,
    effects: Mapping[str, Effect],
    numbers: Mapping[str, Effect],
    workers: int,
    progress: Callable[[float], None],
    one_wave: bool = False,
    rivals: Mapping[str, tuple[str, ...]] | None = None,
) -> Selection:
    """Forward selection over effects and over numbers of the vehicle that may be declared wrong.

    effects, numbers: what is tried, by name: where a number explains the held-out data as well as an effect does, it is the
    number, which the model has already; workers: effects tried at once; progress: called with the share of the first round that
    is done; one_wave: the steering repeats one wave: more is asked of an effect, and of two that these data cannot separate none
    is named; rivals: effects that the drives cannot name and the channels that they lack for it: where one of them explains the
    held-out data as well as what would be named, nothing is.
    """
    tried, rivals = {**effects, **numbers}, rivals or {}
    first = rank(bench, tried, workers, progress)
    ranking: list[Candidate] = first
    accepted: dict[str, Candidate] = {}
    groups: dict[str, tuple[str, ...]] = {}
    seen: set[frozenset[str]] = set()
    undecided: tuple[str, ...] = ()
    while len(accepted) < RULES.most_effects:
        least = RULES.one_wave_gain if one_wave else RULES.later_gain if accepted else RULES.least_gain
        judged, others = contended(bench, ranking, workers, one_wave)
        ranking = [*judged, *others]
        if not accepted:
            first = ranking
        evident = not (one_wave or accepted)
        named = [
            c for c in judged if supported(c, tried[c.name], least) or (evident and placed_for_sure(c, tried[c.name]))
        ]
        if not named:
            break
        alike = like(named[0], ranking, bench)
        best = next((c for c in named if c.name in numbers and (c is named[0] or c.name in alike)), named[0])
        groups[best.name] = (best.name, *like(best, ranking, bench))
        if {*rivals} & {*groups[best.name]}:
            break
        if len(groups[best.name]) > (1 if one_wave else RULES.most_alike):
            undecided = () if accepted else groups[best.name]
            break
        accepted[best.name] = best
        bench, dropped = accept(bench, best, {name: tried[name] for name in accepted})
        for name in dropped:
            del accepted[name], groups[name]
        if frozenset(accepted) in seen:  # the same set again: no more to gain by exchange
            break
        seen.add(frozenset(accepted))
        again = [c.name for c in first if c.name not in accepted and c.name not in dropped][:RULES.second_look]
        ranking = rank(bench, {name: tried[name] for name in again}, workers, lambda share: None)
    return Selection(tuple(accepted.values()), bench, tuple(first), tuple(groups.values()), tried, rivals, undecided)


def contended(
    bench: Bench, ranking: Sequence[Candidate], workers: int, one_wave: bool
) -> tuple[list[Candidate], list[Candidate]]:
    """The best few of a ranking, judged on the whole drive, and the others as they are; workers, one_wave: as of `select`."""
    fitted = sum(len(part) for part in bench.fitted)
    before = held_cost(replace(bench, held=bench.fitted), bench.absent).sum() + held_cost(bench, bench.absent).sum()

    def removed(candidate: Candidate) -> float:
        """Share of the cost of all windows, fitted and held out, that the candidate's first fit removes."""
        return float(1.0 - (candidate.fit.cost * fitted + candidate.windows.sum()) / before)

    few = [c for c in sorted(ranking, key=lambda c: -removed(c)) if removed(c) >= RULES.contender][:RULES.contenders]
    return cross_validated(bench, few, workers, one_wave), [c for c in ranking if c not in few]


def supported(candidate: Candidate, effect: Effect, least: float = RULES.least_gain, whole: float | None = None) -> bool:
    """Whether held-out data support the effect: a gain of at least `least`, and `whole` of the whole cost (default least_whole),
    its significance, a leading parameter identified."""
    sigmas, whole = least_sigmas(len(candidate.windows)), least_whole(effect) if whole is None else whole
    if not (candidate.gain >= least and candidate.gain >= sigmas * candidate.std and candidate.whole >= whole):
        return False
    lead = effect.parameters[0].name
    ended = [name for name in candidate.fit.at_bound if name not in KINDS_OF_GROUND]
    if any(name == lead or name not in effect.parameters for name in ended):
        return False
    if size(candidate.fit, effect) < RULES.least_size:
        return False
    beyond_doubt = candidate.gain >= least_sigmas(len(candidate.windows), RULES.beyond_doubt) * candidate.std
    return beyond_doubt or strength(candidate.fit, effect) >= RULES.least_parameter_sigmas


def hidden_by_noise(selection: Selection, one_wave: bool) -> tuple[Candidate, ...]:
    """Where nothing has been accepted, the candidates that explain much beyond noise for sure, and yet too little of the whole to
    be named: something is missing, and noise does not let one say what. one_wave: as of `select`."""
    least = RULES.one_wave_gain if one_wave else RULES.later_gain
    tried = [] if selection.accepted else [c for c in selection.ranking if c.name in selection.tried]
    return tuple(c for c in tried if supported(c, selection.tried[c.name], least, 0.0))


def placed_for_sure(candidate: Candidate, effect: Effect) -> bool:
    """Whether all windows leave no doubt of a change at a place, which must also predict what was held out better than none."""
    if not placed(effect) or candidate.overall is None or candidate.overall.at_bound:
        return False
    sure = strength(candidate.overall, effect) >= RULES.place_sigmas
    return sure and candidate.gain > 0.0 and size(candidate.overall, effect) >= RULES.least_size


def least_whole(effect: Effect) -> float:
    """Share of the whole held-out cost that the effect must remove."""
    return RULES.least_whole_apart if set(effect.corrections) == {"outputs"} or placed(effect) else RULES.least_whole


def least_sigmas(windows: int, chance: float = RULES.chance) -> float:
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
        if other.name == best.name or other.gain < RULES.least_gain or other.gain < 0.5 * best.gain:
            continue
        if len(other.windows) != len(best.windows):  # not among those that were judged on the whole drive
            continue
        apart = other.windows - best.windows
        error = float(apart.std(ddof=1)) / np.sqrt(len(apart))
        if apart.mean() < max(error, RULES.like_gain * total):
            names.append(other.name)
    return tuple(names)


def accept(bench: Bench, candidate: Candidate, effects: Mapping[str, Effect]) -> tuple[Bench, tuple[str, ...]]:
    """The bench with the candidate in the model, and the names of earlier effects that it has made superfluous.

    effects: all accepted ones, the candidate's among them. Their parameters stay free; an effect that no longer stands off
    its absence was in the place of this one, and goes. Channels are weighted anew by what the grown model leaves of them:
    against the first model's errors a second effect would hardly show.
    """
    own = [f for f in candidate.fit.free if f.name in effects[candidate.name].parameters]
    loose = tuple(f for f in bench.loose if f.name not in effects[candidate.name].parameters)
    grown = replace(bench, absent=candidate.fit.p, accepted=(*bench.accepted, *own), loose=loose)
    refit = fit_base(grown)
    grown = replace(grown, absent=refit.p)
    dropped = tuple(
        name
        for name, effect in effects.items()
        if name != candidate.name and strength(refit, effect) < RULES.least_parameter_sigmas
    )
    if not dropped:
        return reweighted(grown), ()
    p, gone = grown.absent.copy(), {s.name for name in dropped for s in effects[name].parameters}
    for name in dropped:
        for signal in effects[name].parameters:
            p[:, grown.model.p.index(signal.name)] = signal.nominal
    grown = replace(grown, absent=p, accepted=tuple(f for f in grown.accepted if f.name not in gone))
    return reweighted(replace(grown, absent=fit_base(grown).p)), dropped
