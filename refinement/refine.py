"""The loop closed with data: residual, missing effect, refined model, and the error before and after on held-out data."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from softsoil.checking.usable import usable
from softsoil.declaration.ground import idle
from softsoil.declaration.handed import check_declaration
from softsoil.declaration.late_steering import late_steering
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.driveline_choice import Choice, choose_driveline, undeclared
from softsoil.estimator.horizons import HORIZONS, START_UP
from softsoil.estimator.late_clocks import LateClock
from softsoil.estimator.tuning import Tuning, common_error
from softsoil.recording.copies import refuse_copies
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.log_names import distinct
from softsoil.refinement.doubts import loosened, other_ground
from softsoil.refinement.drive_n import DriveN, FittedDrives, not_to_be_used
from softsoil.refinement.excitation import one_wave
from softsoil.refinement.ground import fitted_ground
from softsoil.refinement.handed_on import handed_on, moved
from softsoil.refinement.observations import carried, lacking, ruled_out
from softsoil.refinement.remarks import inseparable, notes, on_bound, one_by_one, would_separate
from softsoil.refinement.residual import unjudged
from softsoil.refinement.result import Refinement
from softsoil.refinement.rules import RULES
from softsoil.refinement.second_look import Look, look_twice, strained_words
from softsoil.refinement.selection import Selection, hidden_by_noise, select
from softsoil.refinement.structure import Structure, structure
from softsoil.refinement.trace import Bench, fit_base, make_bench, open_effects, settled
from softsoil.refinement.windowing import Windowing
from softsoil.refinement.words import either
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import neutral
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import Vehicle
from softsoil.symbolic.wheel import force_law

Array = NDArray[np.float64]


def refine(
    logs: Sequence[Recording | pd.DataFrame | str | Path],
    declaration: Declaration,
    *,
    soils: Sequence[Soil] | None = None,
    start: float = START_UP,
    workers: int = 2,
    candidates: Sequence[str] | None = None,
    windowing: Windowing = Windowing(),  # noqa: B008
    progress: Callable[[float], None] = lambda share: None,
) -> Refinement:
    """What the declared model lacks on one or more drives, from sensor channels only.

    The first two thirds of each drive are fitted, the rest judges, then what is accepted is fitted to the whole; of a drive with
    standstills, its longest stretch forwards. What is unknown of the ground is n of each drive, or with a law of hard ground
    friction and tread, one of each class. logs: drives, files or tables, checked and completed as by `estimate`; soils: class
    of each, default the declared one for all; start: seconds left out at the beginning of each; candidates: names of
    the effects that are tried, default all that are not declared, without those that a measurement excludes or that do nothing
    with the force law; workers: effects tried at once; windowing: how drives are cut.
    Raises ValueError for drives that cannot be used, or another number of soils than of drives, TypeError for what is no
    declaration.

    Example:
        >>> import softsoil
        >>> declaration = softsoil.Declaration(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> found = softsoil.refine(softsoil.example_logs()[:1], declaration, candidates=["steering_offset"])
        >>> found.verdict in ("effect", "contradicts_given", "none", "unexplained")
        True
    """
    check_declaration("refine", declaration)
    began = time.perf_counter()
    soils = tuple(soils or [declaration.soil] * len(logs))
    if len(soils) != len(logs):
        raise ValueError(f"soils: expected one per drive ({len(logs)}), found {len(soils)}")
    classes = sorted({soil.name for soil in soils})
    if classes[1:] and getattr(force_law(declaration.law), "by_class", False):
        words = f"{declaration.law}, whose numbers go by the soil's name; found {', '.join(classes)}: one call for each"
        raise ValueError(f"soils: expected drives on one class with the force law {words}")
    declaration = Declaration(declaration.vehicle, soils[0], declaration.law)
    recordings = distinct([usable(log, declaration.vehicle, late_steering(declaration.vehicle)) for log in logs])
    refuse_copies(recordings)
    choice = _driveline(recordings, declaration, soils, start)
    if choice is not None:
        declaration = replace(declaration, vehicle=declaration.vehicle.with_(driveline=choice.numbers))
    vehicle = declaration.vehicle
    possible = _possible(recordings, declaration, candidates)
    bench = make_bench(recordings, declaration, start, windowing, possible, soils)
    loose, numbers = loosened(bench, vehicle)
    repeated = all(one_wave(recording) for recording in recordings)
    effects_tried = open_effects(declaration, possible)
    lacked = unsupported(recordings, declaration, candidates)
    rivals = {name: channels for name, channels in lacked.items() if name in effects_tried}
    selection = select(loose, {**effects_tried, **other_ground(vehicle)}, numbers, workers, progress, repeated, rivals)
    look = look_twice(recordings, declaration, bench, selection, effects_tried, not repeated, start)
    selection, fits = look.selection, look.fits
    # The declared model: its numbers as declared, or within their joint error where windows with free starts have fitted them.
    declared = look.declared or (bench, fit_base(bench))
    final, last = (fits.final, fits.last) if fits else settled(bench, selection.bench)
    as_declared = moved(vehicle, declared[0])
    shown = final if selection.accepted else declared[0]
    left = _left(recordings, shown, moved(vehicle, shown), start)
    if selection.accepted and any(s.left for s in left) and not (_beyond_doubt(selection) or look.explained):
        # Something of the kind of the accepted effect is there, but it is not that: a name would be a guess. It is none where the
        # drives strain the numbers of an identified vehicle without the effect, and do not with it.
        groups = (*selection.groups, *((c.name,) for c in selection.accepted))
        selection = replace(selection, accepted=(), bench=loose, groups=tuple(dict.fromkeys(groups)))
        final, last, look = bench, fit_base(bench), look.without_effects()
        left = _left(recordings, declared[0], as_declared, start)
    model = replace(declaration, vehicle=as_declared)
    of_declared = FittedDrives(recordings, model, soils, start, *declared, joint=look.declared is not None)
    selection = replace(selection, bench=final)
    out = handed_on(of_declared, declaration, selection, look, effects_tried, (bench, loose), last)
    clocks: tuple[tuple[LateClock, ...], ...] = ()
    if any(one.verdict.word == "inconsistent" for one in out.after) or (look.strain is not None and look.strained):
        clocks = FittedDrives(recordings, declaration, soils, start, bench, fit_base(bench), joint=False).late_clocks()
    unnamed: tuple[str, ...] = ()
    if any(clocks) and selection.accepted:
        # What is named leaves the drives inconsistent, and a clock that is off does not.
        names = ", ".join(candidate.name for candidate in selection.accepted)
        unnamed = (f"not named, since a clock explains the drives and this does not: {names}",)
        selection, look = replace(selection, accepted=(), bench=bench, groups=(), undecided=()), look.without_effects()
        final, last = bench, fit_base(bench)
        left = _left(recordings, declared[0], as_declared, start)
        out = handed_on(of_declared, declaration, selection, look, effects_tried, (bench, loose), last)
    effects, contradicted, refined, after = out.effects, out.contradicted, out.declaration, out.after
    accepted = [candidate.name for candidate in selection.accepted]
    if any(clocks):
        pairs = zip(after, clocks, strict=True)
        after = tuple(not_to_be_used([one], of_drive[0].sentence)[0] if of_drive else one for one, of_drive in pairs)
    if look.strain is not None and look.strained:
        after = not_to_be_used(after, strained_words(look))
    if after:
        refined = replace(refined, soil=refined.soil.with_(n=after[0].n))
    groups = inseparable(selection)
    lines = notes(recordings, declaration, bench, selection)
    lines += look.notes if accepted or not look.selection.accepted else ()
    lines += (strained_words(look),) if look.strain is not None and look.strained else ()
    lines += () if choice is None else (f"no wheel speeds: {choice}",)
    idle_here = _idle(declaration, candidates)
    lines += tuple(f"{name}: not tried, it does nothing with {declaration.law}" for name in idle_here)
    lines += tuple(
        f"{name}: {'not to be named' if name in rivals else 'not tried'}, it rests on {', '.join(channels)}, which the drives do "
        "not measure"
        for name, channels in lacked.items()
        if name not in idle_here
    )
    lines += tuple(
        f"{recording.name}: axle forces are not judged: {unjudged(recording)}"
        for recording, one in zip(recordings, left, strict=True)
        if not one.judged
    )
    hidden = hidden_by_noise(selection, repeated) if look.strain is None else ()
    if hidden:
        missing = f"something is missing: {hidden[0].name} removes much of the held-out cost, too little to be named"
        after = not_to_be_used(after, missing)
    lines += tuple(
        f"{c.name}: not named, it removes {100 * c.gain:.0f} % of the held-out cost beyond sensor noise, "
        f"{100 * c.whole:.0f} % of the whole: something is missing, less noise or more drives would show what"
        for c in hidden[:1]
    )
    if selection.undecided and not (selection.accepted or effects or contradicted or any(clocks)):
        missing = f"something is missing, {either(selection.undecided)}: these data cannot separate them"
        after = not_to_be_used(after, missing)
    lines += tuple(f"{r.name}: {one.sentence}" for r, found in zip(recordings, clocks, strict=False) for one in found) + unnamed
    lacks = bool(selection.unnamable or selection.undecided or hidden or any(clocks)) or _lacks(bench, left, look, after)
    verdict = "effect" if effects else "contradicts_given" if contradicted else "unexplained" if lacks else "none"
    lines += one_by_one(verdict, len(recordings))
    return Refinement(
        verdict=verdict,
        effects=effects,
        contradicted=contradicted,
        fitted=tuple(number for number in out.fitted if number.name not in accepted),
        inseparable=groups,
        would_separate=would_separate(groups, verdict, selection),
        ranking=tuple(sorted(selection.ranking, key=lambda candidate: -candidate.gain)),
        holdout=_holdout(bench),
        before=held_mse(bench, bench.absent, windowing.horizons),
        after=held_mse(final, final.absent, windowing.horizons),
        n_before=out.before,
        n_after=tuple(one.n for one in after),
        n_std=tuple(one.std for one in after),
        judged=tuple(one.verdict for one in after),
        ground=() if bench.sinks else fitted_ground(
            bench.ground, soils, [r.name for r in recordings], bench.values(bench.ground), out.last, [s.left for s in left],
            common_error(Tuning().common_error, bench.model),
        ),
        structure=left,
        strain=look.strain,
        load=look.load,
        declaration=refined,
        bench=bench,
        selection=selection,
        recordings=tuple(recordings),
        soils=soils,
        seconds=time.perf_counter() - began,
        carried=tuple(n for n, e in catalogue(vehicle).items() if carried(e, recordings, vehicle)),
        notes=lines,
    )


def _lacks(bench: Bench, left: Sequence[Structure], look: Look, found: Sequence[DriveN]) -> bool:
    """Whether the drives show that something is missing, whatever it is.

    With a joint error of the vehicle's numbers that is their strain, and the verdicts on n: they see what changes before the axle
    forces do. Else it is what the axle forces lack; where these are not judged, an n on its bound.
    """
    if look.strain is not None:
        return look.strained or any(one.verdict.word == "inconsistent" for one in found)
    return any(s.left for s in left) or (bool(on_bound(bench).any()) and not all(s.judged for s in left))


def _driveline(recordings: Sequence[Recording], declaration: Declaration, soils: Sequence[Soil], start: float) -> Choice | None:
    """The driveline that drives without wheel speeds show, where it is not declared."""
    models = [Declaration(declaration.vehicle, soil, declaration.law).build() for soil in soils]
    if not undeclared(recordings, models[0]):
        return None
    return choose_driveline(recordings, models, [float(soil.n) for soil in soils], start)


def _left(recordings: Sequence[Recording], bench: Bench, vehicle: Vehicle, start: float) -> tuple[Structure, ...]:
    pairs = zip(recordings, bench.absent, strict=True)
    return tuple(structure(recording, bench.model, vehicle, p, start) for recording, p in pairs)


def _beyond_doubt(selection: Selection) -> bool:
    """Whether what the axle forces still lack is no doubt of the effects: the first removes nearly all that is held out, or one
    is of a sensor, and axle forces come from the records as they are, wrong sensors and all."""
    found, known = selection.accepted, selection.tried
    return found[0].gain >= RULES.nearly_all or any("outputs" in known[candidate.name].corrections for candidate in found)


def held_mse(bench: Bench, p: Array, horizons: Sequence[float] = HORIZONS) -> dict[str, dict[str, float]]:
    """Horizon -> state -> mean squared error over the held-out part of every drive, for p (D, n_p); NaN without a window.

    horizons: s.
    """
    table = {}
    for horizon in horizons:
        squares: list[Array] = []
        for shooting, held, row in zip(bench.shootings, bench.held, p, strict=True):
            first = shooting.rows[held[0]] if len(held) else len(shooting.drive.t)
            if len(shooting.starts(horizon)) < 2:
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


def _possible(
    recordings: Sequence[Recording], declaration: Declaration, names: Sequence[str] | None
) -> Sequence[str] | None:
    """Names of the effects to try, without those that a measurement excludes, those of sensors that rest on a channel that a
    drive does not measure, and those that do nothing with the force law."""
    known = open_effects(declaration, names)
    dropped = {n for n in unsupported(recordings, declaration, names) if known[n].kind == "sensor"} | {*_idle(declaration, names)}
    tried = {name: effect for name, effect in known.items() if name not in dropped}
    return [name for name, effect in tried.items() if not ruled_out(effect, recordings, declaration.vehicle)]


def _idle(declaration: Declaration, names: Sequence[str] | None) -> tuple[str, ...]:
    """Open effects that do nothing on hard ground, none on soil; names: of the candidates, default all."""
    if declaration.sinks:
        return ()
    effects, plain = open_effects(declaration, names), declaration.plain()
    tried = {name: idle(neutral(plain, effect), effect.parameters.names) for name, effect in effects.items()}
    return tuple(name for name, still in tried.items() if len(still) == len(effects[name].parameters))


def unsupported(
    recordings: Sequence[Recording], declaration: Declaration, names: Sequence[str] | None = None
) -> dict[str, tuple[str, ...]]:
    """Open effect -> channels that it rests on and that a drive neither measures nor shows.

    names: of the candidates, default all.
    """
    found = {name: lacking(effect, recordings) for name, effect in open_effects(declaration, names).items()}
    return {name: channels for name, channels in found.items() if channels}
