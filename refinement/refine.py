"""The loop closed with data: residual, missing effect, refined model, and the error before and after on held-out data."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.horizons import HORIZONS, START_UP
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.forward import forward_part
from softsoil.recording.usable import usable
from softsoil.refinement.excitation import one_wave
from softsoil.refinement.fit import N_NAMES, Fit
from softsoil.refinement.observations import carried, ruled_out
from softsoil.refinement.rules import RULES
from softsoil.refinement.selection import Selection, select, size
from softsoil.refinement.structure import Structure, structure
from softsoil.refinement.trace import Bench, Candidate, everything, fit_base, loosened, make_bench, open_effects
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.vehicle import Vehicle

Array = NDArray[np.float64]



@dataclass(frozen=True)
class TracedEffect:
    """An effect that the data support: parameters name -> (value, standard error, unit)."""

    name: str
    doc: str
    parameters: dict[str, tuple[float, float, str]]


@dataclass(frozen=True)
class Refinement:
    """What refine found.

    verdict: "effect", "none" or "unexplained"; effects: in the order found, parameters fitted to the whole drives;
    inseparable: groups that these data cannot tell apart; would_separate: the manoeuvre that would; ranking: all candidates
    of the first round; holdout: (from, to) of the first drive (s); before, after: horizon -> state -> mean squared error on
    held-out windows, declared model and refined model, both fitted on the fit windows alone; n_before (fit windows), n_after
    (whole drives): per drive; structure: what is left at the end; declaration: the refined one, by the whole drives; bench:
    the declared model's; selection, its bench fitted on the fit windows; recordings: what was used of the drives;
    carried: effects that the measured inputs are seen to contain; notes; seconds.
    """

    verdict: str
    effects: tuple[TracedEffect, ...]
    inseparable: tuple[tuple[str, ...], ...]
    would_separate: str
    ranking: tuple[Candidate, ...]
    holdout: tuple[float, float]
    before: dict[str, dict[str, float]]
    after: dict[str, dict[str, float]]
    n_before: tuple[float, ...]
    n_after: tuple[float, ...]
    structure: tuple[Structure, ...]
    declaration: Declaration
    bench: Bench
    selection: Selection
    recordings: tuple[Recording, ...]
    seconds: float
    carried: tuple[str, ...] = ()
    notes: tuple[str, ...] = field(default_factory=tuple)

    def as_json(self) -> dict[str, Any]:
        """The content of refine.json."""
        effects = [
            {
                "name": e.name,
                "parameters": {k: {"value": v, "std": s, "unit": unit} for k, (v, s, unit) in e.parameters.items()},
            }
            for e in self.effects
        ]
        return {
            "verdict": self.verdict,
            "effects": effects,
            "inseparable": [list(group) for group in self.inseparable],
            "would_separate": self.would_separate,
            "ranking": [{"name": c.name, "holdout_gain": c.gain, "std": c.std} for c in self.ranking],
            "holdout": {"from": self.holdout[0], "to": self.holdout[1]},
            "before": {"mse": self.before},
            "after": {"mse": self.after},
            "n": {"before": list(self.n_before), "after": list(self.n_after)},
            "unexplained": [{"share": s.share, "correlations": s.correlations} for s in self.structure],
            "notes": list(self.notes),
            "seconds": self.seconds,
        }


def refine(
    logs: Sequence[Recording | pd.DataFrame | str | Path],
    declaration: Declaration,
    *,
    start: float = START_UP,
    workers: int = 2,
    candidates: Sequence[str] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Refinement:
    """What the declared model lacks on one or more drives of one soil class, from sensor channels only.

    The first two thirds of each drive are fitted, the rest judges, then what was found is fitted to the whole; of a drive with
    standstills, its longest stretch forwards. logs: drives, files or tables, checked and completed as by `estimate`; start:
    seconds left out at the beginning of each; candidates: names of the effects that are tried, default all that are not
    declared, without those that a measurement excludes;
    workers: effects tried at once. Raises ValueError for drives that cannot be used.

    Example:
        >>> import softsoil
        >>> declaration = softsoil.Declaration(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> found = softsoil.refine(softsoil.example_logs()[:1], declaration, candidates=["steering_offset"])
        >>> found.verdict in ("effect", "none", "unexplained")
        True
    """
    began = time.perf_counter()
    recordings = [forward_part(usable(log, declaration.vehicle)) for log in logs]
    names = _possible(recordings, declaration, candidates)
    bench = make_bench(recordings, declaration, start, names=names)
    repeated = all(one_wave(recording) for recording in recordings)
    selection = select(loosened(bench, declaration), declaration, workers, progress, repeated, names)
    final, last = settled(bench, selection.bench)
    left = _left(recordings, final, declaration.vehicle, start)
    if selection.accepted and any(s.left for s in left) and not _beyond_doubt(declaration, selection.accepted):
        # Something of the kind of what was found is there, but it is not that: a name would be a guess.
        groups = (*selection.groups, *((c.name,) for c in selection.accepted))
        selection = replace(selection, accepted=(), groups=tuple(dict.fromkeys(groups)))
        final, last = bench, fit_base(bench)
        left = _left(recordings, final, declaration.vehicle, start)
    selection = replace(selection, bench=final)
    # Judged by the fit to a part; what is handed on is fitted to all there is.
    whole, last = settled(everything(bench), everything(final)) if selection.accepted else (final, last)
    effects = tuple(_traced(declaration, candidate.name, whole, last) for candidate in selection.accepted)
    index = bench.model.p.index("n_f")
    n_before, n_after = tuple(bench.absent[:, index]), tuple(whole.absent[:, index])
    groups = inseparable(selection)
    notes = _notes(recordings, declaration, bench, selection)
    notes += tuple(
        f"{name}: not tried, it rests on {', '.join(lacking)}, which the drives do not measure"
        for name, lacking in unsupported(recordings, declaration, candidates).items()
    )
    notes += tuple(
        f"{recording.name}: axle forces are not judged: v and omega_z are not both measured"
        for recording, one in zip(recordings, left, strict=True)
        if not one.judged
    )
    # Where axle forces are not judged, an n on its bound is what shows that something is left.
    lacks = any(s.left for s in left) or (_on_bound(bench).any() and not all(s.judged for s in left))
    verdict = "effect" if effects else ("unexplained" if lacks else "none")
    return Refinement(
        verdict=verdict,
        effects=effects,
        inseparable=groups,
        would_separate=_would_separate(declaration, groups, verdict, selection),
        ranking=selection.ranking,
        holdout=_holdout(bench),
        before=held_mse(bench, bench.absent),
        after=held_mse(final, final.absent),
        n_before=n_before,
        n_after=n_after,
        structure=left,
        declaration=_refined(declaration, effects, whole, float(np.mean(n_after))),
        bench=bench,
        selection=selection,
        recordings=tuple(recordings),
        seconds=time.perf_counter() - began,
        carried=tuple(n for n, e in catalogue(declaration.vehicle).items() if carried(e, recordings, declaration.vehicle)),
        notes=notes,
    )


def inseparable(selection: Selection) -> tuple[tuple[str, ...], ...]:
    """Groups that the data cannot separate, of two at least; an effect that was accepted beside the first of its group has
    been told from it: the data need both."""
    accepted = {candidate.name for candidate in selection.accepted}
    groups = (tuple(name for name in group if name == group[0] or name not in accepted) for group in selection.groups)
    return tuple(group for group in groups if len(group) > 1)


def _on_bound(bench: Bench) -> NDArray[np.bool_]:
    """(D,) drives whose n ends on a bound with the declared model."""
    n, value = bench.model.p[N_NAMES[0]], bench.absent[:, bench.model.p.index(N_NAMES[0])]
    return (value <= n.lower + 1e-3) | (value >= n.upper - 1e-3)


def _left(recordings: Sequence[Recording], bench: Bench, vehicle: Vehicle, start: float) -> tuple[Structure, ...]:
    pairs = zip(recordings, bench.absent, strict=True)
    return tuple(structure(recording, bench.model, vehicle, p, start) for recording, p in pairs)


def _beyond_doubt(declaration: Declaration, found: Sequence[Candidate]) -> bool:
    """Whether what the axle forces still lack is no doubt of the effects: the first removes nearly all that is held out, or one
    is of a sensor, and axle forces come from the records as they are, wrong sensors and all."""
    known = catalogue(declaration.vehicle)
    return found[0].gain >= RULES.nearly_all or any("outputs" in known[candidate.name].corrections for candidate in found)


def settled(declared: Bench, found: Bench) -> tuple[Bench, Fit]:
    """The bench with the effects found, all that is free fitted once more, parameters of declared effects within their
    uncertainty among them; without effects the declared bench itself, with its fit of n."""
    if not found.accepted:
        return declared, fit_base(declared)
    last = fit_base(found)
    return replace(found, absent=last.p), last


def held_mse(bench: Bench, p: Array) -> dict[str, dict[str, float]]:
    """Horizon -> state -> mean squared error over the held-out part of every drive, for p (D, n_p); NaN without a window."""
    table = {}
    for horizon in HORIZONS:
        squares: list[Array] = []
        for shooting, held, row in zip(bench.shootings, bench.held, p, strict=True):
            drive = shooting.drive
            first = shooting.rows[held[0]] if len(held) else len(drive.t)
            if (len(drive.t) - drive.first - 1) * drive.dt < 2 * horizon:
                continue
            windows = shooting.ahead(horizon)
            squares += [windows.residual(row)[windows.rows >= first].reshape(-1, len(STATE_CHANNELS)) ** 2]
        joined = np.concatenate(squares) if squares else np.empty((0, len(STATE_CHANNELS)))
        known = np.isfinite(joined)
        count = known.sum(axis=0)
        means = np.where(count > 0, np.where(known, joined, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)
        table[f"{horizon:.1f}"] = dict(zip(STATE_CHANNELS, map(float, means), strict=True))
    return table


def _holdout(bench: Bench) -> tuple[float, float]:
    shooting, held = bench.shootings[0], bench.held[0]
    t = shooting.drive.t
    last = min(shooting.rows[held[-1]] + shooting.steps, len(t) - 1)
    return float(t[shooting.rows[held[0]]]), float(t[last])


def _traced(declaration: Declaration, name: str, final: Bench, last: Fit) -> TracedEffect:
    effect = catalogue(declaration.vehicle)[name]
    fitted = last.named()
    at = {s.name: (float(last.p[0, final.model.p.index(s.name)]), 0.0) for s in effect.parameters}
    return TracedEffect(effect.name, effect.doc, effect.sizes({**at, **fitted}))


def _refined(declaration: Declaration, effects: Sequence[TracedEffect], final: Bench, n: float) -> Declaration:
    known = catalogue(declaration.vehicle)
    tables = {e.name: {k: v for k, (v, _, _) in e.parameters.items() if k in known[e.name].parameters} for e in effects}
    moved = {f.name: float(final.absent[0, final.model.p.index(f.name)]) for f in final.loose}
    for name, values in declaration.vehicle.effects.items():
        if name in tables:
            continue
        tables[name] = {key: moved.get(key, value) for key, value in values.items()}
    return declaration.with_effects(tables).with_n(n)


def close_calls(selection: Selection, known: Mapping[str, Effect]) -> tuple[tuple[str, str], ...]:
    """(named, other) where an effect that looks like a named one (a signature in common) gained nearly as much: less than one
    standard error of the two gains behind."""
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


def _would_separate(
    declaration: Declaration, groups: Sequence[Sequence[str]], verdict: str, selection: Selection
) -> str:
    known = catalogue(declaration.vehicle)
    grouped = {frozenset((group[0], name)) for group in groups for name in group[1:]}
    close = [pair for pair in close_calls(selection, known) if frozenset(pair) not in grouped]
    doubtful = [*groups, *close]
    if doubtful:
        return "; ".join(f"{', '.join(group)}: {known[group[0]].separates}" for group in doubtful)
    if verdict == "unexplained":
        return "several speeds, steering rates and headings, straight stretches and tight turns in one drive"
    return ""


def _possible(
    recordings: Sequence[Recording], declaration: Declaration, names: Sequence[str] | None
) -> Sequence[str] | None:
    """Names of the effects to try, without those that a measurement excludes and those that rest on a channel that a drive does
    not measure."""
    dropped = unsupported(recordings, declaration, names)
    tried = {name: effect for name, effect in open_effects(declaration, names).items() if name not in dropped}
    return [name for name, effect in tried.items() if not ruled_out(effect, recordings, declaration.vehicle)]


def unsupported(
    recordings: Sequence[Recording], declaration: Declaration, names: Sequence[str] | None = None
) -> dict[str, tuple[str, ...]]:
    """Open effect -> channels that it rests on and that a drive does not measure; names: of the candidates, default all."""
    found = {}
    for name, effect in open_effects(declaration, names).items():
        lacking = tuple(channel for channel in effect.rests_on if not all(r.measured(channel) for r in recordings))
        if lacking:
            found[name] = lacking
    return found


def _lead(candidate: Candidate, known: Mapping[str, Effect]) -> str:
    """The leading parameter of a candidate, as it was fitted."""
    lead = known[candidate.name].parameters[0]
    return f"{lead.name} {candidate.fit.named()[lead.name][0]:.2g} {lead.unit}".rstrip()


def _notes(recordings: Sequence[Recording], declaration: Declaration, bench: Bench, selection: Selection) -> tuple[str, ...]:
    notes = [f"{r.name}: {note}" for r in recordings for note in r.notes]
    for effect in catalogue(declaration.vehicle).values():
        for name, words in carried(effect, recordings, declaration.vehicle).items():
            notes.append(f"{name}: {words}; the measured inputs carry it, so the model needs no effect for it")
    accepted = {c.name for c in selection.accepted}
    for free in selection.bench.loose:
        at = bench.model.p.index(free.name)
        now, declared = selection.bench.absent[0, at], bench.absent[0, at]
        notes.append(
            f"{free.name} of the declared model was fitted again with what was found: {declared:.3g} -> {now:.3g}"
        )
    for candidate in selection.ranking:
        if candidate.name not in accepted and candidate.gain > RULES.least_gain and candidate.fit.at_bound:
            notes.append(f"{candidate.name}: not identified ({', '.join(candidate.fit.at_bound)} at a bound)")
    tried = open_effects(declaration)
    for candidate in selection.ranking:
        small = size(candidate.fit, tried[candidate.name]) < RULES.least_size
        if small and candidate.gain > RULES.least_gain and candidate.name not in accepted:
            notes.append(f"{candidate.name}: not named, smaller than the faults of a declared model ({_lead(candidate, tried)})")
    for group in selection.groups:
        if len(group) > 1 and group[0] not in accepted:
            notes.append(f"not named, since these data cannot separate them: {', '.join(group)}")
        elif group[0] not in accepted:
            notes.append(
                f"{group[0]} fits best, but leaves more of the axle forces than a known effect would: not named"
            )
    values = bench.absent[:, bench.model.p.index(N_NAMES[0])]
    for shooting, value, stuck in zip(bench.shootings, values, _on_bound(bench), strict=True):
        if stuck:
            notes.append(f"{shooting.drive.name}: with the declared model n ends at its bound, {value:.2f}")
    return tuple(notes)
