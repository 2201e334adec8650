"""Tracing: which effect of the catalogue explains what a declared model leaves, judged on windows that were not fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.moving_horizon import LEAST_NOISE
from softsoil.recording.drive import Recording
from softsoil.recording.states import sample_std, sensor_std
from softsoil.refinement.fit import Fit, Weights, fit
from softsoil.refinement.rules import RULES
from softsoil.refinement.unknown_ground import N_NAMES, free_n, free_road, ground_starts
from softsoil.refinement.vehicle_numbers import KINDS_OF_GROUND, own_layout
from softsoil.refinement.windowing import Windowing
from softsoil.symbolic.bicycle import soil_parameters
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import Effect, neutral
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import Soil
from softsoil.windows.absent_wheels import with_log_wheels
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import Shooting, shooting_drive, shootings
from softsoil.windows.stiffness import needed_substeps

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Candidate:
    """One effect tried beside the declared model.

    name; fit: of its parameters together with the ground; windows (H,): cost of each held-out window; gain: share of the held-out
    cost beyond sensor noise that it removes; std: standard error of the gain, over windows; whole: share of the whole cost,
    noise and all, that it removes; overall: of a contender, the fit to all windows.
    """

    name: str
    fit: Fit
    windows: Array
    gain: float
    std: float
    whole: float = float("nan")
    overall: Fit | None = None


@dataclass(frozen=True)
class Bench:
    """What all candidates share: the model with every effect absent, one or more drives, weights, windows.

    model; absent (D, n_p): parameters with every undeclared effect absent; shootings: one per drive; weights;
    fitted, held: indices of windows per drive; sensor (6,): noise in a sample of each channel, white (6,): the white noise that
    counts as much; ground: what is unknown of it;
    accepted: parameters of effects accepted so far, which stay free; loose: numbers of the vehicle and of its declared effects,
    free within their uncertainty: what a candidate could hide behind.
    """

    model: Model
    absent: Array
    shootings: tuple[Shooting, ...]
    fitted: tuple[NDArray[np.int_], ...]
    held: tuple[NDArray[np.int_], ...]
    weights: Weights
    sensor: Array
    white: Array
    ground: tuple[Free, ...]
    accepted: tuple[Free, ...] = ()
    loose: tuple[Free, ...] = ()

    @property
    def known(self) -> tuple[Free, ...]:
        """What is free beside the ground in every comparison."""
        return (*self.loose, *self.accepted)

    @property
    def sinks(self) -> bool:
        """Whether the ground is a soil, whose n is unknown; else it is hard."""
        return self.ground[0].sets == N_NAMES

    def values(self, free: Sequence[Free]) -> Array:
        """(K,) values that free numbers have on the bench."""
        return np.array([self.absent[f.drives[0], self.model.p.index(f.sets[0])] for f in free])

    @property
    def floor(self) -> float:
        """Mean cost of a window that sensor noise alone makes, over the values that it holds: what no model can remove."""
        share = np.minimum(self.sensor / self.weights.sigma, 1.0) ** 2
        counts = np.concatenate([np.isfinite(shooting.recorded).sum(axis=1) for shooting in self.shootings])  # (W, 6)
        held = counts.sum(axis=1) > 0
        return float(np.mean((counts @ share)[held] / counts.sum(axis=1)[held]))


def open_effects(declaration: Declaration, names: Sequence[str] | None = None) -> dict[str, Effect]:
    """The effects of the catalogue that the declaration does not have, by name, or those of `names` alone.

    Of its own, those of which a drive may have more (`repeats`) are among them: absent, they are as declared.

    Raises ValueError for a name that the catalogue lacks.
    """
    known = catalogue(declaration.vehicle)
    for name in names or ():
        if name not in known:
            raise ValueError(f"candidates: expected names of {', '.join(known)}; found {name!r}")
    declared, wanted = declaration.vehicle.effects, known if names is None else names
    return {
        name: as_declared(effect, declared[name]) if name in declared else effect
        for name, effect in known.items()
        if name in wanted and (name not in declared or effect.repeats)
    }


def as_declared(effect: Effect, values: Mapping[str, float]) -> Effect:
    """The effect with its declared values in the place of those at which it is absent: more or less of it is what is tried."""
    typical = {s.name: effect.typical[s.name] - s.nominal + values.get(s.name, s.nominal) for s in effect.parameters}
    bounded = {s.name: min(max(typical[s.name], s.lower), s.upper) for s in effect.parameters}
    return replace(effect, parameters=effect.parameters.with_nominal(**values), typical=bounded)


def whole_model(declaration: Declaration, names: Sequence[str] | None = None) -> Model:
    """The declared model with its vehicle's numbers as parameters and every open effect added, absent: one compilation serves
    all candidates."""
    vehicle = declaration.vehicle
    model = bicycle(vehicle, declaration.soil, declaration.law, None, own_layout(vehicle))
    for name, effect in open_effects(declaration, names).items():
        model = model if name in model.effects else neutral(model, effect)
    return model


def make_bench(
    recordings: Sequence[Recording],
    declaration: Declaration,
    start: float,
    windowing: Windowing = Windowing(),  # noqa: B008
    names: Sequence[str] | None = None,
    soils: Sequence[Soil] | None = None,
) -> Bench:
    """The tracing's bench for one or more drives; the ground of each drive fitted, weights set from what it leaves.

    start: seconds left out at the beginning of each drive; windowing: of the drives; soils: class of each drive, default the
    declared one for all;
    names: effects that will be tried, default all that are not declared.
    Raises ValueError for drives that shooting cannot use.
    """
    model = with_log_wheels(whole_model(declaration, names), recordings)
    soils = tuple(soils or [declaration.soil] * len(recordings))
    plain, sinks = declaration.plain(), declaration.sinks
    soil_of = [model.p.index(name) for name in plain.p.names]
    drives = [shooting_drive(r, model, start, windowing.smooth(r.dt, sinks)) for r in recordings]
    p = np.tile(model.p.nominal, (len(drives), 1))
    for row, soil in zip(p, soils, strict=True):
        for signal in soil_parameters(soil):
            row[model.p.index(signal.name)] = signal.nominal
    sensor, white = (np.max([std(r, LEAST_NOISE) for r in recordings], axis=0) for std in (sample_std, sensor_std))
    substeps, ground = 0, free_n(len(drives)) if sinks else free_road(soils)
    while (needed := windowing.substeps or needed_substeps(plain, drives, p[:, soil_of])) > substeps:
        substeps = needed  # a stiffer ground than the last one needs shorter steps
        windows = shootings(model, drives, windowing.horizon, substeps)
        counts = [len(shooting.rows) for shooting in windows]
        fitted = tuple(np.arange(max(round(count * RULES.fit_share), 1)) for count in counts)
        held = tuple(np.arange(len(part), count) for part, count in zip(fitted, counts, strict=True))
        weights = _weights(np.maximum(_unexplained(windows, p), sensor), sensor, white)
        bench = Bench(model, p, windows, fitted, held, weights, sensor, white, ground)
        for _ in range(2):  # the ground moves the weights, the weights the ground: twice is enough
            bench = reweighted(replace(bench, absent=fit_base(bench).p))
        p = bench.absent
    return bench


def everything(bench: Bench) -> Bench:
    """The bench with all windows to fit, the held-out ones among them: for what is not judged on them."""
    return replace(bench, fitted=tuple(np.arange(len(shooting.rows)) for shooting in bench.shootings))


def reweighted(bench: Bench) -> Bench:
    """The bench with each channel measured against what the model leaves of it, at least RULES.least_sigma of its noise."""
    left = _unexplained(bench.shootings, bench.absent)
    return replace(bench, weights=_weights(np.maximum(left, RULES.least_sigma * bench.sensor), bench.sensor, bench.white))


def _weights(left: Array, sensor: Array, white: Array) -> Weights:
    """Each channel measured against what is left of it (6,), as large as it is where noise is white: errors that a filter has
    smoothed hardly average out over a window."""
    return Weights(np.sqrt(left**2 + np.maximum(white**2 - sensor**2, 0.0)))


def _unexplained(shootings: Sequence[Shooting], p: Array) -> Array:
    """(6,) rms of what is left per channel, robust against single samples."""
    squares = np.concatenate([s.residual(row).reshape(-1, 6) ** 2 for s, row in zip(shootings, p, strict=True)])
    left = np.ones(squares.shape[1])  # of a channel that is not measured: it has no residual to weigh
    seen = np.isfinite(squares).any(axis=0)
    squares = squares[:, seen]
    left[seen] = np.sqrt(np.nanmean(np.minimum(squares, 25 * np.nanmedian(squares, axis=0) + 1e-18), axis=0))
    return left


def fit_base(bench: Bench) -> Fit:
    """The ground (and what was accepted before), from the best of a few values around what the bench has."""
    ground = ground_starts(bench.ground, bench.values(bench.ground))
    starts = np.column_stack([np.tile(bench.values(bench.known), (len(ground), 1)), ground])
    return fit(bench.shootings, bench.fitted, bench.weights, [*bench.known, *bench.ground], starts, bench.absent)


def held_cost(bench: Bench, p: Array) -> Array:
    """(H,) cost of every held-out window of every drive for parameters p (D, n_p)."""
    parts = zip(bench.shootings, bench.held, p, strict=True)
    return np.concatenate([bench.weights.cost(s.residual(row, held)) for s, held, row in parts])


def try_effect(
    bench: Bench, effect: Effect, starts: Sequence[Mapping[str, float]], fixed: Sequence[str] = ()
) -> Candidate:
    """The effect's parameters fitted together with the ground from the best of the starts, and judged on the held-out windows.

    fixed: parameters of the effect that keep their value of the first start, as which of two kinds of ground it is does, too.
    """
    kept = {*fixed, *(KINDS_OF_GROUND if effect.name not in KINDS_OF_GROUND else ())}
    mine = [_free(effect, name) for name in effect.parameters.names if name not in kept]
    others = [f for f in bench.known if f.name not in effect.parameters]
    free = [*mine, *others, *bench.ground]
    known = bench.values(free[len(mine) :])
    p = bench.absent.copy()
    for name, value in starts[0].items():
        p[:, bench.model.p.index(name)] = value
    rows = np.array([np.concatenate([[values[f.name] for f in mine], known]) for values in starts])
    best = of_effect(bench, fit(bench.shootings, bench.fitted, bench.weights, free, rows, p, settle=False))
    base, mine_cost = held_cost(bench, bench.absent), held_cost(bench, best.p)
    whole = float(1.0 - mine_cost.sum() / base.sum())
    return Candidate(effect.name, best, mine_cost, *gain_of(base, mine_cost, bench.floor), whole)


def of_effect(bench: Bench, found: Fit) -> Fit:
    """The fit of an effect without the bounds that speak against no effect: of what is loose, where they are what is declared of
    it, and of hard ground, whose friction a drive may never reach."""
    loose = {free.name for free in (*bench.loose, *(() if bench.sinks else bench.ground))}
    return replace(found, at_bound=tuple(name for name in found.at_bound if name not in loose))


def gain_of(before: Array, after: Array, floor: float = 0.0) -> tuple[float, float]:
    """Share of the held-out cost beyond sensor noise that is gone, and its standard error over windows.

    before, after (H,): cost of each window; floor: what noise alone makes of it. The error is that of a ratio of two means:
    windows that differ in cost alone do not make the share uncertain.
    """
    mean = float(before.mean())
    beyond = before - min(floor, (1.0 - RULES.least_beyond) * mean)
    gain = float((before - after).sum() / beyond.sum())
    apart = before - after - gain * beyond
    return gain, float(apart.std(ddof=1) / np.sqrt(len(apart)) / beyond.mean())


def _free(effect: Effect, name: str) -> Free:
    signal = effect.parameters[name]
    scale = abs(effect.typical[name] - signal.nominal) or 0.1
    # Weakly known: where a part of a drive says nothing of it, it stays near absence.
    reach = max(signal.upper - signal.nominal, signal.nominal - signal.lower)
    known = (signal.nominal, min(signal.spread, reach / 2))
    return Free(name, (name,), scale, signal.lower, signal.upper, known=known)


def settled(declared: Bench, found: Bench) -> tuple[Bench, Fit]:
    """The bench with the accepted effects, all that is free fitted once more, parameters of declared effects within their
    uncertainty among them; without effects the declared bench itself, with its fit of the ground."""
    if not found.accepted:
        return declared, fit_base(declared)
    last = fit_base(found)
    return replace(found, absent=last.p), last
