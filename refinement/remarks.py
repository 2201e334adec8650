"""Remarks of a refinement: groups that data cannot separate, what would, and notes on what was held back and why."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from softsoil.declaration.model_file import Declaration
from softsoil.recording.drive import Recording
from softsoil.refinement.observations import carried
from softsoil.refinement.rules import RULES
from softsoil.refinement.selection import Selection, size
from softsoil.refinement.trace import Bench, Candidate
from softsoil.refinement.unknown_ground import N_NAMES
from softsoil.refinement.vehicle_numbers import KINDS_OF_GROUND
from softsoil.refinement.words import with_error
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import Effect


def inseparable(selection: Selection) -> tuple[tuple[str, ...], ...]:
    """Groups that the data cannot separate, of two at least; an effect that was accepted beside the first of its group has
    been separated from it: the data need both."""
    accepted = {candidate.name for candidate in selection.accepted}
    groups = (tuple(name for name in group if name == group[0] or name not in accepted) for group in selection.groups)
    return tuple(group for group in groups if len(group) > 1)


def on_bound(bench: Bench) -> NDArray[np.bool_]:
    """(D,) drives whose n ends on a bound with the declared model; none on hard ground."""
    n, value = bench.model.p[N_NAMES[0]], bench.absent[:, bench.model.p.index(N_NAMES[0])]
    return bench.sinks & ((value <= n.lower + 1e-3) | (value >= n.upper - 1e-3))


def close_calls(selection: Selection, known: Mapping[str, Effect]) -> tuple[tuple[str, str], ...]:
    """(named, other) where an effect that looks like a named one (a signature in common) gained nearly as much: less than one
    standard error of the two gains behind. known: what was tried, by name."""
    gains = {c.name: c for c in selection.ranking}
    return tuple(
        (named.name, other.name)
        for named in selection.accepted
        for other in selection.ranking
        if named.name in gains
        and other.name not in {c.name for c in selection.accepted}
        and known[named.name].looks_like(known[other.name])
        and gains[named.name].gain - other.gain < math.hypot(gains[named.name].std, other.std)
    )


def would_separate(groups: Sequence[Sequence[str]], verdict: str, selection: Selection) -> str:
    """The manoeuvres that would separate what these data cannot, or explain what is left; empty where nothing is asked for."""
    known = selection.tried
    grouped = {frozenset((group[0], name)) for group in groups for name in group[1:]}
    close = [pair for pair in close_calls(selection, known) if frozenset(pair) not in grouped]
    doubtful = [*groups, *close]
    measures = [f"{name}: a log with {', '.join(selection.rivals[name])}" for name in selection.unnamable]
    if doubtful:
        lines = [f"{', '.join(group)}: {_manoeuvres(group, known)}" for group in doubtful]
        return "; ".join([*lines, *measures])
    if measures:
        return "; ".join(measures)
    if verdict == "unexplained":
        return "several speeds, steering rates and headings, straight stretches and tight turns in one drive"
    return ""


def one_by_one(verdict: str, drives: int) -> tuple[str, ...]:
    """What else may be tried where several drives are left unexplained: they may differ in what the model lacks of them."""
    if verdict != "unexplained" or drives < 2:
        return ()
    return ("drives of one call are taken to have the same effects: where load or slope may differ, trace each alone",)


def _manoeuvres(group: Sequence[str], known: Mapping[str, Effect]) -> str:
    """What each effect of a group says of telling it from its like, each said once, with its names where several are."""
    said: dict[str, list[str]] = {}
    for name in group:
        if name in known:
            said.setdefault(known[name].separates, []).append(name)
    return ", or ".join(f"{words} ({', '.join(names)})" if len(said) > 1 else words for words, names in said.items())


def notes(recordings: Sequence[Recording], declaration: Declaration, bench: Bench, selection: Selection) -> tuple[str, ...]:
    """What was held back and why, and what the records themselves say.

    bench: the declared model's.
    """
    lines = [f"{r.name}: {note}" for r in recordings for note in r.notes]
    for effect in catalogue(declaration.vehicle).values():
        for name, words in carried(effect, recordings, declaration.vehicle).items():
            lines.append(f"{name}: {words}; the measured inputs carry it, so the model needs no effect for it")
    accepted, tried = {c.name for c in selection.accepted}, selection.tried
    for candidate in selection.ranking:
        ended = [name for name in candidate.fit.at_bound if name not in KINDS_OF_GROUND]
        if candidate.name not in accepted and candidate.gain > RULES.least_gain and ended:
            lines.append(f"{candidate.name}: not identified ({', '.join(ended)} at a bound)")
    for candidate in selection.ranking:
        small = size(candidate.fit, tried[candidate.name]) < RULES.least_size
        if small and candidate.gain > RULES.least_gain and candidate.name not in accepted:
            lines.append(f"{candidate.name}: not named, smaller than the faults of a declared model ({_lead(candidate, tried)})")
    for group in selection.groups:
        if len(group) > 1 and group[0] not in accepted:
            lines.append(f"not named, since these data cannot separate them: {', '.join(group)}")
        elif group[0] not in accepted and group[0] not in selection.rivals:
            lines.append(
                f"{group[0]} fits best, but leaves more of the axle forces than a known effect would: not named"
            )
    for candidate in selection.ranking:
        if candidate.name in selection.unnamable:
            share = f"{with_error(100 * candidate.gain, 100 * candidate.std)} %"
            lacked = ", ".join(selection.rivals[candidate.name])
            lines.append(
                f"{candidate.name}: explains {share} of what is left ({_lead(candidate, tried)}), but rests on {lacked}, which "
                "the drives do not measure: not named, nor is what explains no more"
            )
    for shooting, stuck in zip(bench.shootings, on_bound(bench), strict=True):
        if stuck:
            lines.append(f"{shooting.drive.name}: with the declared model n ends at a bound of its range: it lacks much")
    if not bench.sinks:
        lines.append(f"neither n nor a verdict on it: nothing sinks with {declaration.law}, where n has no meaning")
    return tuple(lines)


def _lead(candidate: Candidate, known: Mapping[str, Effect]) -> str:
    """The leading parameter of a candidate, as it was fitted."""
    lead = known[candidate.name].parameters[0]
    value, std = candidate.fit.named()[lead.name]
    return f"{lead.name} {with_error(value, std)} {lead.unit}".rstrip()
