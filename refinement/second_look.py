"""Effects that the noise of recorded starts hides, biases or invents: windows with free initial states and correlated numbers.

A load and n explain much of the same: what separates them is small, less than what sensor noise makes of windows that start at
recorded states. Windows with free initial states use the measurements better, but there the vehicle's numbers, each free by
itself, imitate a load. With the joint error of an identified vehicle they cannot, and the effect stands out. Minimised over n of
each drive, the numbers theta and the effect's parameters e: sum over windows of min over x0 of sum rho(z), plus
k^2 (theta - theta_0)' C^-1 (theta - theta_0) plus the prior of e. As in the identification that made C, k = 2 standard errors of
windows count as one: what the model lacks is alike in all of them. With a load the rear toe is free: springs give way under it,
and links turn the wheels. The second term over k^2 and its K numbers, at most about 1 where the vehicle is the one that was
identified, is the strain: a high one says that the vehicle has changed, though n and the numbers predict well.
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
from softsoil.files.joint_error import JointError, joint_error_of
from softsoil.recording.drive import Recording
from softsoil.refinement.doubts import doubts
from softsoil.refinement.fit import Fit
from softsoil.refinement.free_starts import JointPrior, free_windows, joint_prior, steps_of, until
from softsoil.refinement.rules import RULES
from softsoil.refinement.selection import Selection, least_sigmas, size, strength
from softsoil.refinement.trace import Bench, Candidate, everything, settled, whole_model
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.model import Model

Array = NDArray[np.float64]

TOE = "toe_rear"
"""The number of the vehicle that a load on its springs changes most."""


@dataclass(frozen=True)
class Fits:
    """Fits with free starts: final, whole: benches by fits to the first part and to all of each drive; last: the fit to all."""

    final: Bench
    whole: Bench
    last: Fit


@dataclass(frozen=True)
class Look:
    """What free starts make of a tracing: selection; fits: of its accepted effects, None where they are the tracing's; notes;
    strain: of the vehicle's numbers with the accepted effects, None where it was not looked at."""

    selection: Selection
    fits: Fits | None = None
    notes: tuple[str, ...] = ()
    strain: float | None = None

    @property
    def strained(self) -> bool:
        """Whether the drives ask for other numbers than the vehicle's file states, beyond their joint error."""
        return self.strain is not None and self.strain > RULES.strain


def look_twice(
    recordings: Sequence[Recording],
    declaration: Declaration,
    bench: Bench,
    selection: Selection,
    effects: Mapping[str, Effect],
    more: bool = True,
) -> Look:
    """A tracing looked at again by windows with free starts: what it has named is sized anew, or left out where they do not show
    it; where nothing is named, they may name an effect, or add the group of effects that they cannot separate. Either way they
    tell whether the vehicle's numbers are strained.

    recordings: of the drives; bench: with the declared model; effects: that are tried, by name; more: whether an effect that
    the tracing has not named may be. Only on soil, for a vehicle whose file states a joint error; else the selection as it is.
    """
    error = _stated(declaration, bench)
    if error is None:
        return Look(selection)
    look = _sized_again(recordings, declaration, error, bench, selection, effects) if selection.accepted else Look(selection)
    if look.selection.accepted or not more:
        return look
    again = _look_again(recordings, declaration, error, bench, look.selection, effects)
    return replace(again, notes=(*look.notes, *again.notes))


def strained_words(strain: float) -> str:
    """What a strain of the vehicle's numbers says, for notes and verdicts."""
    return (
        f"the drives ask for other numbers of the vehicle than its file states, beyond their joint error (strain {strain:.1f}, "
        f"{RULES.strain:g} at most where nothing has changed): something of the vehicle has changed, as by a load"
    )


def _look_again(
    recordings: Sequence[Recording],
    declaration: Declaration,
    error: JointError,
    bench: Bench,
    selection: Selection,
    effects: Mapping[str, Effect],
) -> Look:
    """The effect that free starts name; what rests on channels that the drives lack is not named here either."""
    few = [c for c in selection.ranking if c.name in effects and worth_it(c, effects[c.name], strained=True)]
    try:
        problem = _Problem.of(recordings, declaration, error, bench, [c.name for c in few])
        none, before = problem.fitted()
    except ValueError:  # a drive that holds no two windows of this kind, for its length or its quick steering
        return Look(selection)
    strain = problem.strain(none)
    look = Look(selection, strain=strain)
    few = [c for c in few if worth_it(c, effects[c.name], look.strained)]
    if not few:
        return look
    # From the numbers as declared, and from where they are in the effect's place: each alone may end in a lesser minimum.
    fits = {
        c.name: min((problem.fitted((effects[c.name],), traced_of(c), at) for at in (None, none)), key=lambda found: found[1])
        for c in few
    }
    removed = {name: before - squares for name, (_, squares) in fits.items()}
    best = max(few, key=lambda c: removed[c.name])
    effect, (fit, _) = effects[best.name], fits[best.name]
    if not named(fit, effect, removed[best.name] if look.strained else None):
        return look
    rivals = [c.name for c in few if c is not best and removed[c.name] >= RULES.look_rival * removed[best.name]]
    if rivals or best.name in selection.rivals:
        return replace(look, selection=replace(selection, groups=(*selection.groups, (best.name, *rivals))))
    try:
        found = problem.fits((effect,), fit, traced_of(best))
    except ValueError:  # the first part holds no two windows
        return look
    selection = replace(selection, accepted=(replace(best, overall=found.last),), bench=found.final, groups=((best.name,),))
    note = (
        f"{best.name}: named by windows with free initial states and the joint error of the vehicle's numbers; noise hides it "
        "from windows that start at recorded states"
    )
    return Look(selection, found, (note,), problem.strain(fit, (effect,)))


def _sized_again(
    recordings: Sequence[Recording],
    declaration: Declaration,
    error: JointError,
    bench: Bench,
    selection: Selection,
    effects: Mapping[str, Effect],
) -> Look:
    """The named effects fitted to the whole drives with free starts and the joint error, which the noise of recorded starts does
    not bias, without those that are not there then; the tracing's where one is of a sensor or at a place."""
    names = [candidate.name for candidate in selection.accepted]
    if any(name not in effects or not _of_the_vehicle(effects[name]) for name in names):
        return Look(selection)
    final, _ = settled(bench, selection.bench)
    _, traced = settled(everything(bench), everything(final))
    kept, notes = [effects[name] for name in names], []
    try:
        problem = _Problem.of(recordings, declaration, error, bench, names)
        fit, _ = problem.fitted(kept, traced)
        while kept and (doubtful := [effect for effect in kept if not still_there(fit, traced, effect)]):
            left_out = min(doubtful, key=lambda effect: _certainty(fit, effect)[1])
            notes.append(_not_there(fit, left_out))
            kept.remove(left_out)
            fit, _ = problem.fitted(kept, traced, fit)
        found = problem.fits(kept, fit, traced) if notes else Fits(final, *problem.bench_of(kept, fit))
    except ValueError:  # as in _look_again
        return Look(selection)
    accepted = tuple(c for c in selection.accepted if effects[c.name] in kept)
    groups = tuple(group for group in selection.groups if effects.get(group[0]) in kept)
    if notes:
        selection = replace(selection, accepted=accepted, bench=found.final if kept else bench, groups=groups)
    return Look(selection, found if kept else None, tuple(notes), problem.strain(fit, kept))


def still_there(fit: WindowFit, traced: Fit, effect: Effect) -> bool:
    """Whether a fit with free starts shows an effect that the tracing has named, on the same side of absence."""
    name, sigmas = _certainty(fit, effect)
    absent = effect.parameters[name].nominal
    same_side = (fit.named()[name][0] - absent) * (traced.named()[name][0] - absent) > 0
    return same_side and sigmas >= RULES.there_sigmas


def _certainty(fit: WindowFit, effect: Effect) -> tuple[str, float]:
    """The parameter of the leading one's kind (its unit) that stands farthest from absence, and by how many standard errors."""
    values, lead = fit.named(), effect.parameters[0]
    kind = [s for s in effect.parameters if s.name in values and s.unit == lead.unit]
    sigmas = {s.name: abs(values[s.name][0] - s.nominal) / max(values[s.name][1], 1e-12) for s in kind}
    return max(sigmas.items(), key=lambda item: item[1])


def _not_there(fit: WindowFit, effect: Effect) -> str:
    name, sigmas = _certainty(fit, effect)
    value, std = fit.named()[name]
    unit = effect.parameters[name].unit
    return (
        f"{effect.name}: not named, windows with free initial states and the joint error of the vehicle's numbers do not show it "
        f"({name} {value:.4g} ± {std:.2g}{unit and f' {unit}'}, {sigmas:.1f} standard errors from absence)"
    )


def worth_it(candidate: Candidate, effect: Effect, strained: bool = False) -> bool:
    """Whether the tracing's windows give reason to look at an effect again: of the vehicle or the ground, a gain that is no
    scatter, a size that is none of a declared model's faults. With strained numbers, where something is missing, scatter is no
    objection, and a load needs no gain: n can hide all of it."""
    if not _of_the_vehicle(effect):
        return False
    if strained and _adds_mass(effect):
        return True
    if candidate.overall is None:
        return False
    scatter = 0.0 if strained else least_sigmas(len(candidate.windows)) * candidate.std
    sure = candidate.gain >= max(RULES.look_gain, scatter)
    enough = strength(candidate.overall, effect) >= RULES.least_parameter_sigmas
    return sure and enough and size(candidate.overall, effect) >= RULES.least_size


def traced_of(candidate: Candidate) -> Fit:
    """The tracing's fit of an effect: to the whole drives where there is one."""
    return candidate.overall or candidate.fit


def named(fit: WindowFit, effect: Effect, removed: float | None = None) -> bool:
    """Whether a fit with free starts is sure of an effect, none of its parameters on a bound: the leading one far from absence,
    or, with strained numbers, where something is missing for sure, by the squares that it has `removed`."""
    lead = effect.parameters[0]
    value, std = fit.named()[lead.name]
    sigmas = abs(value - lead.nominal) / max(std, 1e-12) if removed is None else max(removed, 0.0) ** 0.5
    return sigmas >= RULES.look_sigmas and not {*fit.at_bound} & {*effect.parameters.names}


@dataclass(frozen=True)
class _Problem:
    """The drives with free starts: compiled model, joint error of the numbers and their declared values, what else is free."""

    recordings: tuple[Recording, ...]
    bench: Bench
    model: Model
    compiled: Mapping[float, WindowModel]
    error: JointError
    declared: dict[str, float]
    numbers: tuple[Free, ...]
    p: Array

    @classmethod
    def of(
        cls, recordings: Sequence[Recording], declaration: Declaration, error: JointError, bench: Bench, names: Sequence[str]
    ) -> _Problem:
        model = with_log_wheels(whole_model(declaration, names), recordings)
        table = doubts(declaration.vehicle)
        declared = {name: float(doubt.signal.nominal) for name, doubt in table.items()}
        numbers = tuple(replace(d.free, known=None) if d.signal.name in error.names else d.free for d in table.values())
        p = bench.absent[:, [bench.model.p.index(name) for name in model.p.names]]
        for name, value in declared.items():
            p[:, model.p.index(name)] = value
        steps = {s.drive.dt for s in bench.shootings}
        compiled = {dt: WindowModel(model, dt, steps_of(dt)) for dt in steps}
        return cls(tuple(recordings), bench, model, compiled, error, declared, numbers, p)

    def windows(self, share: float) -> list[FreeWindows]:
        """The windows in the first `share` of each drive; ValueError where one holds no two."""
        drives = [s.drive for s in self.bench.shootings]
        parts = [until(d, d.first + round(share * (len(d.t) - d.first))) for d in drives]
        return [free_windows(self.compiled[d.dt], d, r) for d, r in zip(parts, self.recordings, strict=True)]

    def fitted(
        self, effects: Sequence[Effect] = (), traced: Fit | None = None, start: WindowFit | None = None, share: float = 1.0
    ) -> tuple[WindowFit, float]:
        """The fit with effects, or with none, to the first `share` of each drive, and its squares with those of the prior; both
        allow for the model's own error.

        traced: fit of the effects by the tracing, where their parameters start; start: fit where all that it has starts.
        """
        windows = self.windows(share)
        own = () if traced is None else _own(traced.free, effects)
        free = (*own, *self.numbers, *self.bench.ground)
        at = {f.name: float(self.p[f.drives[0], self.model.p.index(f.sets[0])]) for f in free}
        for fit in (traced, start):
            at |= {} if fit is None else {name: value for name, (value, _) in fit.named().items() if name in at}
        prior = self.prior_with(effects)
        heavy = replace(prior, root=RULES.look_error * prior.root)
        found = fit_windows(windows, free, np.array([at[f.name] for f in free]), self.p, [heavy])
        residuals = [w.residual(row, x0) for w, row, x0 in zip(windows, found.p, found.x0, strict=True)]
        residuals.append(heavy.residual(found.p[0]))
        squares = float(sum(window_costs(z).sum() * z.shape[1] for z in residuals)) / RULES.look_error**2
        return replace(found, std=RULES.look_error * found.std), squares

    def prior_with(self, effects: Sequence[Effect]) -> JointPrior:
        """The joint prior of the vehicle's numbers; with a load the rear toe may be another one."""
        error = self.error
        if any(_adds_mass(effect) for effect in effects) and TOE in error.names:
            covariance, index = error.covariance, error.names.index(TOE)
            covariance[index, index] += RULES.unsettled_toe**2
            error = joint_error_of(error.names, covariance)
        return joint_prior(error, self.model, self.declared)

    def strain(self, fit: WindowFit, effects: Sequence[Effect] = ()) -> float:
        """Square of the numbers' distance from their file in a fit with effects, over their count: at most about 1 for the
        vehicle of the file."""
        return float(np.mean(self.prior_with(effects).residual(fit.p[0]) ** 2))

    def fits(self, effects: Sequence[Effect], fit: WindowFit, traced: Fit | None) -> Fits:
        """The benches at a fit to the whole drives and at one to their first part, which begins there."""
        part, _ = self.fitted(effects, traced, fit, RULES.fit_share)
        final, _ = self.bench_of(effects, part)
        return Fits(final, *self.bench_of(effects, fit))

    def bench_of(self, effects: Sequence[Effect], fit: WindowFit) -> tuple[Bench, Fit]:
        """The tracing's bench at a fit, its numbers free and the effects accepted, and the fit as one of the tracing.

        What strains the numbers moves the effect and n, too: standard errors grow by the root of a strain above 1 (the ratio
        of R. T. Birge, Phys. Rev. 40, 207, 1932).
        """
        bench, wider = self.bench, max(self.strain(fit, effects), 1.0) ** 0.5
        absent = bench.absent.copy()
        absent[:, [bench.model.p.index(name) for name in self.model.p.names]] = fit.p
        last = Fit(fit.free, fit.value, wider * fit.std, absent, fit.cost, fit.at_bound)
        return replace(bench, absent=absent, accepted=_own(fit.free, effects), loose=self.numbers), last


def _of_the_vehicle(effect: Effect) -> bool:
    """Whether an effect is one of vehicle or ground, none of a sensor and none at a place."""
    return not effect.place and not set(effect.corrections) <= {"outputs"}


def _adds_mass(effect: Effect) -> bool:
    """Whether an effect makes the vehicle heavier."""
    return "vehicle" in effect.corrections and "mass" in effect.corrections["vehicle"].adds


def _stated(declaration: Declaration, bench: Bench) -> JointError | None:
    """The joint error that the vehicle's file states of numbers that drives may doubt; None on rigid ground."""
    joint = declaration.vehicle.joint_error
    return joint.only({*doubts(declaration.vehicle)}) if joint and bench.sinks else None


def _own(free: Sequence[Free], effects: Sequence[Effect]) -> tuple[Free, ...]:
    """Of what is free, the parameters of effects."""
    return tuple(f for f in free if any(f.name in effect.parameters for effect in effects))
