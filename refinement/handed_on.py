"""What of a refinement is handed on: effects and numbers with their errors, the refined model, and n of each drive with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from softsoil.declaration.model_file import Declaration
from softsoil.refinement.doubts import doubts, grounds
from softsoil.refinement.drive_n import DriveN, FittedDrives
from softsoil.refinement.fit import Fit
from softsoil.refinement.result import FittedNumber, TracedEffect
from softsoil.refinement.second_look import Look
from softsoil.refinement.selection import Selection
from softsoil.refinement.trace import Bench, everything, fit_base, settled
from softsoil.refinement.vehicle_numbers import KINDS_OF_GROUND
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.vehicle import NUMBERS, Vehicle


@dataclass(frozen=True)
class HandedOn:
    """effects: as named; contradicted: numbers of the vehicle that are; fitted: all numbers that were free; declaration: the
    refined one; before, after: n of each drive with the declared model, and with the refined one its verdict; last: fit of the
    numbers."""

    effects: tuple[TracedEffect, ...]
    contradicted: tuple[FittedNumber, ...]
    fitted: tuple[FittedNumber, ...]
    declaration: Declaration
    before: tuple[float, ...]
    after: tuple[DriveN, ...]
    last: Fit


def handed_on(
    of_declared: FittedDrives,
    declaration: Declaration,
    selection: Selection,
    look: Look,
    known: Mapping[str, Effect],
    benches: tuple[Bench, Bench],
    last: Fit,
) -> HandedOn:
    """The result of a selection, judged by the fit to a part of the drives, and fitted to all there is.

    of_declared: drives with the declared model; declaration: as declared; selection: its bench is that of its accepted effects;
    look: free starts on it; known: effects that were tried, by name; benches: of the declared model, and with its numbers free;
    last: fit of the selection.
    """
    vehicle, fits, final = declaration.vehicle, look.fits, selection.bench
    if selection.accepted:
        whole, last = (fits.whole, fits.last) if fits else settled(everything(benches[0]), everything(final))
        free = _fitted(vehicle, whole, last, joint=fits is not None)
    else:
        whole = final
        free = _fitted(vehicle, *(look.declared or (benches[1], fit_base(benches[1]))), joint=look.declared is not None)
    accepted = [candidate.name for candidate in selection.accepted]
    effects = tuple(_traced(known[name], whole, last) for name in accepted if name in known)
    contradicted = tuple(number for number in free if number.name in accepted)
    refined = _refined(declaration, effects, contradicted, whole)
    if selection.accepted:
        with_effects = replace(of_declared, declaration=refined, bench=whole, fit=last, joint=fits is not None)
        return HandedOn(effects, contradicted, free, refined, of_declared.plain(), with_effects.judged(), last)
    after = of_declared.judged()
    return HandedOn(effects, contradicted, free, refined, tuple(one.n for one in after), after, last)


def _fitted(vehicle: Vehicle, bench: Bench, last: Fit, joint: bool) -> tuple[FittedNumber, ...]:
    """The declared numbers that were free in a fit, with what is known of them beforehand: by themselves, or, where the fit had
    that, by the joint error of the vehicle's file whatever the others are."""
    table, values = {**doubts(vehicle), **grounds(vehicle)}, last.named()
    stated = {name: doubt.std for name, doubt in table.items()}
    if joint and vehicle.joint_error is not None:
        stated |= dict(zip(vehicle.joint_error.names, vehicle.joint_error.std, strict=True))
    return tuple(
        FittedNumber(name, table[name].signal.unit, float(table[name].signal.nominal), float(stated[name]), *values[name])
        for name in (free.name for free in bench.known)
        if name in table
    )


def _traced(effect: Effect, final: Bench, last: Fit) -> TracedEffect:
    fitted = last.named()
    at = {s.name: (float(last.p[0, final.model.p.index(s.name)]), 0.0) for s in effect.parameters}
    sizes = {name: size for name, size in effect.sizes({**at, **fitted}).items() if name not in KINDS_OF_GROUND}  # not fitted
    return TracedEffect(effect.name, effect.doc, sizes)


def moved(vehicle: Vehicle, final: Bench) -> Vehicle:
    """The vehicle with its numbers, and the parameters of its declared effects, where a fit has moved them."""
    numbers = {f.name: float(final.absent[0, final.model.p.index(f.name)]) for f in final.known}
    own = {n.name: numbers[n.name] for n in NUMBERS if n.name in numbers}
    known = catalogue(vehicle)
    effects = {
        key: {k: numbers[k] if k in numbers else values[k] for k in known[key].parameters.names if k in numbers or k in values}
        for key, values in vehicle.effects.items()
    }
    return vehicle.moved(effects=effects, **own)


def _refined(
    declaration: Declaration, effects: Sequence[TracedEffect], contradicted: Sequence[FittedNumber], final: Bench
) -> Declaration:
    """The declaration on the first drive's ground with the effects and numbers identified, and the standard errors of both."""
    known = catalogue(declaration.vehicle)
    tables = {e.name: {k: v for k, (v, _, _) in e.parameters.items() if k in known[e.name].parameters} for e in effects}
    stds = {number.name: number.std for number in contradicted}
    stds |= {k: s for e in effects for k, (_, s, _) in e.parameters.items() if k in known[e.name].parameters}
    ground = {f.sets[0].removesuffix("_f"): float(v) for f, v in zip(final.ground, final.values(final.ground), strict=True)
              if f.drive is None or 0 in f.drives}  # fmt: skip
    vehicle = moved(declaration.vehicle, final)
    refined = Declaration(vehicle, declaration.soil.with_(**ground), declaration.law).with_effects(tables)
    vehicle = refined.vehicle
    there = {*(number.name for number in NUMBERS), *(key for values in vehicle.effects.values() for key in values)}
    stated = {k: s for k, s in {**vehicle.uncertainty, **stds}.items() if k in there and np.isfinite(s) and s > 0}
    return Declaration(vehicle.with_(uncertainty=stated), refined.soil, refined.law)
