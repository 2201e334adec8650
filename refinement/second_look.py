"""Effects that the noise of recorded starts hides or biases: windows with free initial states and correlated numbers.

A load and n explain much of the same: what separates them is small, less than what sensor noise makes of windows that start at
recorded states. Windows with free initial states use the measurements better, but there the vehicle's numbers, each free by
itself, imitate a load. With the joint error of an identified vehicle they cannot, and the effect stands out. Minimised over n of
each drive, the numbers theta and the effect's parameters e: sum over windows of min over x0 of sum rho(z), plus
(theta - theta_0)' C^-1 (theta - theta_0) plus the prior of e.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.absent_wheels import with_log_wheels
from softsoil.estimator.free_windows import FreeWindows, WindowModel
from softsoil.estimator.parameters import Free
from softsoil.estimator.window_fit import WindowFit, fit_windows, window_costs
from softsoil.files.joint_error import JointError
from softsoil.recording.drive import Recording
from softsoil.refinement.doubts import doubts
from softsoil.refinement.fit import Fit
from softsoil.refinement.free_starts import JointPrior, free_windows, joint_prior, steps_of, until
from softsoil.refinement.rules import RULES
from softsoil.refinement.selection import Selection, least_sigmas, size, strength
from softsoil.refinement.trace import Bench, Candidate, whole_model
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Look:
    """An effect named by a second look: selection with it accepted; final, whole: benches by fits to the first part of each drive
    and to all of it; last: the fit to all."""

    selection: Selection
    final: Bench
    whole: Bench
    last: Fit

    @property
    def note(self) -> str:
        """What the result says of it."""
        return (
            f"{self.selection.accepted[0].name}: named by windows with free initial states and the joint error of the vehicle's "
            "numbers; noise hides it from windows that start at recorded states"
        )


def look_again(
    recordings: Sequence[Recording], declaration: Declaration, bench: Bench, selection: Selection, effects: Mapping[str, Effect]
) -> Look | Selection:
    """The effect that free starts name where the tracing has named none, or the selection, with the group of effects that free
    starts cannot separate.

    recordings: of the drives; bench: with the declared model; effects: that are tried, by name. Only on soil, for a vehicle whose
    file states a joint error. What rests on channels that the drives lack is not named here either.
    """
    error = _stated(declaration, bench)
    if selection.accepted or error is None:
        return selection
    few = [c for c in selection.ranking if c.name in effects and worth_it(c, effects[c.name])]
    if not few:
        return selection
    try:
        problem = _Problem.of(recordings, declaration, error, bench, [c.name for c in few])
        problem.windows(RULES.fit_share)
    except ValueError:  # a drive that holds no two windows of this kind, for its length or its quick steering
        return selection
    none, before = problem.fitted()
    # From the numbers as declared, and from where they are in the effect's place: each alone may end in a lesser minimum.
    fits = {
        c.name: min((problem.fitted((effects[c.name],), c.overall, at) for at in (None, none)), key=lambda pair: pair[1])
        for c in few
    }
    removed = {name: before - squares for name, (_, squares) in fits.items()}
    best = max(few, key=lambda c: removed[c.name])
    effect, (fit, _) = effects[best.name], fits[best.name]
    if not named(fit, effect):
        return selection
    rivals = [c.name for c in few if c is not best and removed[c.name] >= RULES.look_rival * removed[best.name]]
    if rivals or best.name in selection.rivals:
        return replace(selection, groups=(*selection.groups, (best.name, *rivals)))
    part, _ = problem.fitted((effect,), best.overall, fit, RULES.fit_share)
    whole, last = problem.bench_of((effect,), fit)
    final, _ = problem.bench_of((effect,), part)
    accepted = replace(best, overall=last)
    return Look(replace(selection, accepted=(accepted,), bench=final, groups=((best.name,),)), final, whole, last)


def sized_again(
    recordings: Sequence[Recording],
    declaration: Declaration,
    bench: Bench,
    traced: Fit,
    effects: Sequence[Effect],
) -> tuple[Bench, Fit] | None:
    """Bench and fit of named effects to the whole drives with free starts and the joint error, which the noise of recorded starts
    does not bias; None without a joint error, with an effect of a sensor or at a place, or where drives hold no such windows.

    recordings: of the drives; bench: with the declared model; traced: the tracing's fit of the effects to the whole drives.
    """
    error = _stated(declaration, bench)
    if error is None or any(e.place or set(e.corrections) <= {"outputs"} for e in effects):
        return None
    try:
        problem = _Problem.of(recordings, declaration, error, bench, [e.name for e in effects])
        fit, _ = problem.fitted(effects, traced)
    except ValueError:  # as in look_again
        return None
    return problem.bench_of(effects, fit)


def worth_it(candidate: Candidate, effect: Effect) -> bool:
    """Whether the tracing's windows give reason to look at an effect again: of the vehicle or the ground, a gain that is no
    scatter, a size that is none of a declared model's faults."""
    if candidate.overall is None or effect.place or set(effect.corrections) <= {"outputs"}:
        return False
    sure = candidate.gain >= max(RULES.look_gain, least_sigmas(len(candidate.windows)) * candidate.std)
    enough = strength(candidate.overall, effect) >= RULES.least_parameter_sigmas
    return sure and enough and size(candidate.overall, effect) >= RULES.least_size


def named(fit: WindowFit, effect: Effect) -> bool:
    """Whether a fit with free starts is sure of an effect: its leading parameter far from absence, none on a bound."""
    lead = effect.parameters[0]
    value, std = fit.named()[lead.name]
    sure = abs(value - lead.nominal) >= RULES.look_sigmas * std
    return sure and not {*fit.at_bound} & {*effect.parameters.names}


@dataclass(frozen=True)
class _Problem:
    """The drives with free starts: compiled model, one prior for the numbers, what else is free."""

    recordings: tuple[Recording, ...]
    bench: Bench
    model: Model
    compiled: Mapping[float, WindowModel]
    prior: JointPrior
    numbers: tuple[Free, ...]
    p: Array

    @classmethod
    def of(
        cls, recordings: Sequence[Recording], declaration: Declaration, error: JointError, bench: Bench, names: Sequence[str]
    ) -> _Problem:
        model = with_log_wheels(whole_model(declaration, names), recordings)
        table = doubts(declaration.vehicle)
        declared = {name: float(doubt.signal.nominal) for name, doubt in table.items()}
        prior = joint_prior(error, model, declared)
        numbers = tuple(replace(d.free, known=None) if d.signal.name in prior.names else d.free for d in table.values())
        p = bench.absent[:, [bench.model.p.index(name) for name in model.p.names]]
        for name, value in declared.items():
            p[:, model.p.index(name)] = value
        steps = {s.drive.dt for s in bench.shootings}
        return cls(tuple(recordings), bench, model, {dt: WindowModel(model, dt, steps_of(dt)) for dt in steps}, prior, numbers, p)

    def windows(self, share: float) -> list[FreeWindows]:
        """The windows in the first `share` of each drive; ValueError where one holds no two."""
        drives = [s.drive for s in self.bench.shootings]
        parts = [until(d, d.first + round(share * (len(d.t) - d.first))) for d in drives]
        return [free_windows(self.compiled[d.dt], d, r) for d, r in zip(parts, self.recordings, strict=True)]

    def fitted(
        self, effects: Sequence[Effect] = (), traced: Fit | None = None, start: WindowFit | None = None, share: float = 1.0
    ) -> tuple[WindowFit, float]:
        """The fit with effects, or with none, to the first `share` of each drive, and its squares with those of the prior.

        traced: fit of the effects by the tracing, where their parameters start; start: fit where all that it has starts.
        """
        windows = self.windows(share)
        own = () if traced is None else _own(traced.free, effects)
        free = (*own, *self.numbers, *self.bench.ground)
        at = {f.name: float(self.p[f.drives[0], self.model.p.index(f.sets[0])]) for f in free}
        for fit in (traced, start):
            at |= {} if fit is None else {name: value for name, (value, _) in fit.named().items() if name in at}
        found = fit_windows(windows, free, np.array([at[f.name] for f in free]), self.p, [self.prior])
        residuals = [w.residual(row, x0) for w, row, x0 in zip(windows, found.p, found.x0, strict=True)]
        residuals.append(self.prior.residual(found.p[0]))
        return found, float(sum(window_costs(z).sum() * z.shape[1] for z in residuals))

    def bench_of(self, effects: Sequence[Effect], fit: WindowFit) -> tuple[Bench, Fit]:
        """The tracing's bench at a fit, its numbers free and the effects accepted, and the fit as one of the tracing."""
        bench = self.bench
        absent = bench.absent.copy()
        absent[:, [bench.model.p.index(name) for name in self.model.p.names]] = fit.p
        last = Fit(fit.free, fit.value, fit.std, absent, fit.cost, fit.at_bound)
        return replace(bench, absent=absent, accepted=_own(fit.free, effects), loose=self.numbers), last


def _stated(declaration: Declaration, bench: Bench) -> JointError | None:
    """The joint error that the vehicle's file states of numbers that drives may doubt; None on rigid ground."""
    joint = declaration.vehicle.joint_error
    return joint.only({*doubts(declaration.vehicle)}) if joint and bench.sinks else None


def _own(free: Sequence[Free], effects: Sequence[Effect]) -> tuple[Free, ...]:
    """Of what is free, the parameters of effects."""
    return tuple(f for f in free if any(f.name in effect.parameters for effect in effects))
