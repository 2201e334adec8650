"""Tracing: which effect of the catalogue explains what a declared model leaves, judged on windows that were not fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.inputs import sensor_std
from softsoil.estimator.shooting import Shooting, shooting_drive
from softsoil.recording.drive import Recording
from softsoil.refinement.fit import N_NAMES, Fit, Free, Weights, fit
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.declaration import Declaration
from softsoil.symbolic.effect import Effect, neutral
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Signal
from softsoil.symbolic.soil import SOIL_SIGNALS

Array = NDArray[np.float64]

HORIZON = 2.0
"""s: windows of the tracing: long against the vehicle's lateral dynamics, short enough for many of them."""
FIT_SHARE = 2 / 3
"""The first part of a drive is fitted, the rest judges."""
LEAST_SIGMA = 0.5
"""A channel's weight is its own unexplained rms, but at least this many sensor standard deviations."""
DECLARED_WITHIN = 0.4
"""Parameters of declared effects are known to this share of what they declare: the declared model may use it up before another
effect is called for."""
LEAST_BEYOND = 0.2
"""Share of the cost that counts as beyond noise at least: the noise of the sensors is not known better."""


@dataclass(frozen=True)
class Candidate:
    """One effect tried beside the declared model.

    name; fit: of its parameters together with n; windows (H,): cost of each held-out window; gain: share of the held-out
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

    model; absent (n_p,): parameters with every undeclared effect absent; shootings: one per drive; weights;
    fitted, held: indices of windows per drive; sensor (6,): noise of the channels;
    accepted: parameters of effects accepted so far, which stay free; loose: those of declared effects, free within their
    uncertainty: what a candidate could hide behind.
    """

    model: Model
    absent: Array
    shootings: tuple[Shooting, ...]
    fitted: tuple[NDArray[np.int_], ...]
    held: tuple[NDArray[np.int_], ...]
    weights: Weights
    sensor: Array
    accepted: tuple[Free, ...] = ()
    loose: tuple[Free, ...] = ()

    @property
    def known(self) -> tuple[Free, ...]:
        """What is free beside n in every comparison."""
        return (*self.loose, *self.accepted)

    @property
    def floor(self) -> float:
        """Mean cost of a window that sensor noise alone makes: what no model can remove."""
        return float(np.mean((self.sensor / self.weights.sigma) ** 2))


def open_effects(declaration: Declaration, names: Sequence[str] | None = None) -> dict[str, Effect]:
    """The effects of the catalogue that the declaration does not have, by name, or those of `names` alone.

    Raises ValueError for a name that the catalogue lacks.
    """
    known = catalogue(declaration.vehicle)
    for name in names or ():
        if name not in known:
            raise ValueError(f"candidates: expected names of {', '.join(known)}; found {name!r}")
    wanted = known if names is None else names
    return {name: known[name] for name in known if name in wanted and name not in declaration.vehicle.effects}


def whole_model(declaration: Declaration, names: Sequence[str] | None = None) -> Model:
    """The declared model with every open effect added, absent: one compilation serves all candidates."""
    model = declaration.build()
    for effect in open_effects(declaration, names).values():
        model = neutral(model, effect)
    return model


def make_bench(
    recordings: Sequence[Recording],
    declaration: Declaration,
    start: float,
    horizon: float = HORIZON,
    names: Sequence[str] | None = None,
) -> Bench:
    """The tracing's bench for one or more drives on one class of soil; n of each drive fitted, weights set from what it leaves.

    start: seconds left out at the beginning of each drive; horizon: of the shooting windows (s);
    names: effects that will be tried, default all that are not declared.
    Raises ValueError for drives that shooting cannot use.
    """
    model = whole_model(declaration, names)
    drives = [shooting_drive(recording, model, start) for recording in recordings]
    shootings = tuple(Shooting(model, drive, horizon) for drive in drives)
    counts = [len(shooting.rows) for shooting in shootings]
    fitted = tuple(np.arange(max(round(count * FIT_SHARE), 1)) for count in counts)
    held = tuple(np.arange(len(part), count) for part, count in zip(fitted, counts, strict=True))
    p = np.tile(model.p.nominal, (len(drives), 1))
    sensor = np.max([sensor_std(r, np.array([1e-3, 1e-3, 1e-4, 1e-3, 1e-3, 1e-4])) for r in recordings], axis=0)
    bench = Bench(model, p, shootings, fitted, held, Weights(np.maximum(_unexplained(shootings, p), sensor)), sensor)
    for _ in range(2):  # n moves the weights, the weights n: twice is enough
        base = fit_base(bench)
        bench = reweighted(Bench(model, base.p, shootings, fitted, held, bench.weights, sensor))
    return bench


def everything(bench: Bench) -> Bench:
    """The bench with all windows to fit, the held-out ones among them: for what is not judged on them."""
    return replace(bench, fitted=tuple(np.arange(len(shooting.rows)) for shooting in bench.shootings))


def loosened(bench: Bench, declaration: Declaration) -> Bench:
    """The bench with the parameters of declared effects (not the drawn ones) free within DECLARED_WITHIN, fitted with n."""
    loose = tuple(
        _within(effect.parameters[name], value)
        for key, values in declaration.vehicle.effects.items()
        for effect in (catalogue(declaration.vehicle)[key],)
        for name, value in values.items()
        if value != effect.parameters[name].nominal and name not in effect.drawn
    )
    grown = replace(bench, loose=loose)
    return reweighted(replace(grown, absent=fit_base(grown).p)) if loose else bench


def _within(signal: Signal, declared: float) -> Free:
    spread = DECLARED_WITHIN * abs(declared - signal.nominal)
    lower, upper = max(declared - spread, signal.lower), min(declared + spread, signal.upper)
    return Free(signal.name, (signal.name,), spread / 2, lower, upper, known=(declared, spread))


def reweighted(bench: Bench) -> Bench:
    """The bench with each channel measured against what the present model leaves of it, at least LEAST_SIGMA of its noise."""
    left = _unexplained(bench.shootings, bench.absent)
    return replace(bench, weights=Weights(np.maximum(left, LEAST_SIGMA * bench.sensor)))


def _unexplained(shootings: Sequence[Shooting], p: Array) -> Array:
    """(6,) rms of what is left per channel, robust against single samples."""
    squares = np.concatenate([s.residual(row).reshape(-1, 6) ** 2 for s, row in zip(shootings, p, strict=True)])
    return np.sqrt(np.nanmean(np.minimum(squares, 25 * np.nanmedian(squares, axis=0) + 1e-18), axis=0))


def free_n(bench: Bench) -> list[Free]:
    """The sinkage exponent of each drive, one for both axles."""
    n = SOIL_SIGNALS["n"]
    return [Free(f"n_{i}", N_NAMES, 0.1, n.lower, n.upper, drive=i) for i in range(len(bench.shootings))]


def fit_base(bench: Bench) -> Fit:
    """n of each drive (and what was accepted before), from the best of a few values around what the bench has."""
    n = bench.absent[:, bench.model.p.index("n_f")]
    first = [bench.absent[0, bench.model.p.index(f.name)] for f in bench.known]
    starts = [np.concatenate([first, np.clip(n + shift, 0.25, 1.5)]) for shift in (-0.25, -0.12, 0.0, 0.12, 0.25)]
    free = [*bench.known, *free_n(bench)]
    return fit(bench.shootings, bench.fitted, bench.weights, free, np.array(starts), bench.absent)


def held_cost(bench: Bench, p: Array) -> Array:
    """(H,) cost of every held-out window of every drive for parameters p (D, n_p)."""
    parts = zip(bench.shootings, bench.held, p, strict=True)
    return np.concatenate([bench.weights.cost(s.residual(row, held)) for s, held, row in parts])


def try_effect(
    bench: Bench, effect: Effect, starts: Sequence[Mapping[str, float]], fixed: Sequence[str] = ()
) -> Candidate:
    """The effect's parameters fitted together with n from the best of the starts, and judged on the held-out windows.

    fixed: parameters of the effect that keep their value of the first start.
    """
    mine = [_free(effect, name) for name in effect.parameters.names if name not in fixed]
    free = [*mine, *bench.known, *free_n(bench)]
    known = np.array([bench.absent[f.drive or 0, bench.model.p.index(f.sets[0])] for f in free[len(mine) :]])
    p = bench.absent.copy()
    for name, value in starts[0].items():
        p[:, bench.model.p.index(name)] = value
    rows = np.array([np.concatenate([[values[f.name] for f in mine], known]) for values in starts])
    best = of_effect(bench, fit(bench.shootings, bench.fitted, bench.weights, free, rows, p, settle=False))
    base, mine_cost = held_cost(bench, bench.absent), held_cost(bench, best.p)
    whole = float(1.0 - mine_cost.sum() / base.sum())
    return Candidate(effect.name, best, mine_cost, *gain_of(base, mine_cost, bench.floor), whole)


def of_effect(bench: Bench, found: Fit) -> Fit:
    """The fit of an effect without the bounds of what is loose: they are what is declared of it, and speak against no effect."""
    loose = {free.name for free in bench.loose}
    return replace(found, at_bound=tuple(name for name in found.at_bound if name not in loose))


def gain_of(before: Array, after: Array, floor: float = 0.0) -> tuple[float, float]:
    """Share of the held-out cost beyond sensor noise that is gone, and its standard error over windows.

    before, after (H,): cost of each window; floor: what noise alone makes of it. The error is that of a ratio of two means:
    windows that differ in cost alone do not make the share uncertain.
    """
    mean = float(before.mean())
    beyond = before - min(floor, (1.0 - LEAST_BEYOND) * mean)
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
