"""Effects that the noise of recorded starts hides, biases or invents: windows with free initial states and correlated numbers.

A load and n explain much of the same: what separates them is small, less than what sensor noise makes of windows that start at
recorded states. Windows with free initial states use the measurements better, but there the vehicle's numbers, each free by
itself, imitate a load. With the joint error of an identified vehicle (`softsoil.refinement.joint_fit`) they cannot, and the
effect stands out; and where the drives strain the numbers, the vehicle has changed, whether or not an effect can be named.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.changed_vehicle import CHANGED, mass_words
from softsoil.estimator.horizons import START_UP
from softsoil.estimator.strain import VehicleChange
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.recording.drive import Recording
from softsoil.refinement.drive_change import change_of_drive
from softsoil.refinement.fit import Fit
from softsoil.refinement.joint_fit import Fits, JointFit, stated_error
from softsoil.refinement.rules import RULES
from softsoil.refinement.selection import Selection, least_sigmas, size, strength
from softsoil.refinement.trace import Bench, Candidate, everything, settled
from softsoil.symbolic.effect import Effect
from softsoil.windows.own_numbers import adds_mass
from softsoil.windows.window_fit import WindowFit

Load = tuple[float, float] | None
"""Share of its mass by which drives have a vehicle heavier than declared, and its standard error; None: nothing is said."""
Alone = Callable[[], VehicleChange | None] | None
"""What the only drive says of the vehicle; None: several drives."""
FitOf = Callable[[Sequence[str]], JointFit]
"""Makes the fit of the drives with effects by name."""


@dataclass(frozen=True)
class Look:
    """What free starts make of a tracing: selection; fits: of its accepted effects, None where they are the tracing's; notes;
    declared: the same without any, bench and fit; strain, without: of the vehicle's numbers with the accepted effects, and
    without any, without None where none is accepted; most, most_without: limits of both; load, load_without: share of its mass
    by which the drives have the vehicle heavier than declared, and its standard error, with the accepted effects, None where a
    load is among them, and without any. None where it was not looked at."""

    selection: Selection
    fits: Fits | None = None
    declared: tuple[Bench, Fit] | None = None
    notes: tuple[str, ...] = ()
    strain: float | None = None
    without: float | None = None
    most: float = RULES.strain
    most_without: float = RULES.strain
    load: Load = None
    load_without: Load = None

    @property
    def explained(self) -> bool:
        """Whether the accepted effects take a strain off the numbers, or another mass off the vehicle, that is there without
        them."""
        there = self.without is not None and (self.without > self.most_without or _heavier(self.load_without))
        return there and not self.strained

    @property
    def strained(self) -> bool:
        """Whether the drives ask for other numbers than the vehicle's file states, beyond their joint error."""
        return self.strain is not None and (self.strain > self.most or _heavier(self.load))

    def without_effects(self) -> Look:
        """The same where what was accepted is not named after all."""
        return replace(self, strain=self.without, without=None, most=self.most_without, load=self.load_without, load_without=None)


def look_twice(
    recordings: Sequence[Recording],
    declaration: Declaration,
    bench: Bench,
    selection: Selection,
    effects: Mapping[str, Effect],
    more: bool = True,
    start: float = START_UP,
) -> Look:
    """A tracing looked at again by windows with free starts: what it has named is sized anew, or left out where they do not show
    it; where nothing is named, they may name an effect, or add the group of effects that they cannot separate. Either way they
    tell whether the vehicle's numbers are strained.

    recordings: of the drives; bench: with the declared model; effects: that are tried, by name; more: whether an effect that
    the tracing has not named may be; start: seconds left out at the beginning of each drive. Only on soil, for a vehicle whose
    file states a joint error; else the selection as it is.
    """
    error = stated_error(declaration, bench)
    if error is None:
        return Look(selection)

    def fit_of(names: Sequence[str]) -> JointFit:
        return JointFit.of(recordings, declaration, error, bench, names)

    alone = partial(change_of_drive, recordings[0], declaration, start) if len(recordings) == 1 else None
    look = _sized_again(fit_of, bench, selection, effects, alone) if selection.accepted else Look(selection)
    if look.selection.accepted:
        return look
    gone = {candidate.name for candidate in selection.accepted}  # what free starts do not show is not named by them
    again = _look_again(fit_of, look.selection, {k: v for k, v in effects.items() if more and k not in gone}, alone)
    return replace(again, notes=(*look.notes, *again.notes))


def strained_words(look: Look) -> str:
    """What strained numbers of the vehicle say, for notes and verdicts."""
    said = (
        "the drives ask for other numbers of the vehicle than its file states, beyond their joint error "
        f"(strain {look.strain:.1f}, 1 expected, {look.most:g} at most)"
    )
    if look.load is not None and _heavier(look.load):
        said = f"the drives are those {mass_words(*look.load)}"
    return f"{said}: {CHANGED}; n is not to be used before the change is declared or the vehicle identified again"


def _heavier(load: Load) -> bool:
    """Whether drives show another mass than the declared one, as `softsoil estimate` decides it."""
    return load is not None and VerdictRules().another_mass(*load)


def _without_effects(problem: JointFit, none: WindowFit, alone: Alone) -> tuple[float, float, Load]:
    """Strain without effects, its limit, and load: of one drive as `softsoil estimate` has them, whose limits are for single
    drives, of several by their joint fit `none`."""
    change = None if alone is None else alone()
    if change is None:
        return problem.strain(none), RULES.strain, problem.load(none)
    return change.strain, VerdictRules().strain, (change.load, change.load_std)


def _look_again(fit_of: FitOf, selection: Selection, effects: Mapping[str, Effect], alone: Alone = None) -> Look:
    """The effect that free starts name; what rests on channels that the drives lack is not named here either; alone: what the
    only drive says of the vehicle."""
    few = [c for c in selection.ranking if c.name in effects and worth_it(c, effects[c.name], strained=True)]
    try:
        problem = fit_of([c.name for c in few])
        none, before = problem.plain()
        strain, most, load = _without_effects(problem, none, alone)
    except ValueError:  # a drive that holds no two windows of this kind, for its length or its quick steering
        return Look(selection)
    look = Look(selection, declared=problem.bench_of((), none), strain=strain, most=most, load=load)
    few = [c for c in few if worth_it(c, effects[c.name], look.strained)]
    if not few:
        return look
    fits = {c.name: problem.best((effects[c.name],), traced_of(c), none) for c in few}
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
    left = None if adds_mass(effect) else problem.load(fit)
    again = Look(
        selection, found, look.declared, (note,), strain=problem.strain(fit, (effect,)), load=left,
        without=strain, most_without=most, load_without=load,
    )  # fmt: skip
    if look.strained and again.strained:
        return replace(look, notes=(_no_cure(best.name, again),))
    return again


def _no_cure(name: str, look: Look) -> str:
    """Why an effect is not named that leaves the vehicle's numbers strained."""
    return (
        f"{name}: not named, of all effects it takes most off what the drives contradict, but leaves the vehicle's "
        f"numbers strained (strain {look.strain:.1f}, 1 expected, {look.most:g} at most): something else is other than declared"
    )


def _sized_again(
    fit_of: FitOf, bench: Bench, selection: Selection, effects: Mapping[str, Effect], alone: Alone = None
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
        problem = fit_of(names)
        none, _ = problem.plain()
        fit, _ = problem.best(kept, traced, none)
        while kept and (doubtful := [effect for effect in kept if not still_there(fit, traced, effect)]):
            left_out = min(doubtful, key=lambda effect: _certainty(fit, effect)[1])
            notes.append(_not_there(fit, left_out))
            kept.remove(left_out)
            fit, _ = problem.fitted(kept, traced, fit)
        found = problem.fits(kept, fit, traced) if notes else Fits(final, *problem.bench_of(kept, fit))
        without, most, load = _without_effects(problem, none, alone)
    except ValueError:  # as in _look_again
        return Look(selection)
    accepted = tuple(c for c in selection.accepted if effects[c.name] in kept)
    groups = tuple(group for group in selection.groups if effects.get(group[0]) in kept)
    if notes:
        selection = replace(selection, accepted=accepted, bench=found.final if kept else bench, groups=groups)
    left = None if any(adds_mass(effect) for effect in kept) else problem.load(fit)
    return Look(
        selection, found if kept else None, problem.bench_of((), none), tuple(notes), strain=problem.strain(fit, kept), load=left,
        without=without, most_without=most, load_without=load,
    )  # fmt: skip


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
    if strained and adds_mass(effect):
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


def _of_the_vehicle(effect: Effect) -> bool:
    """Whether an effect is one of vehicle or ground, none of a sensor and none at a place."""
    return not effect.place and not set(effect.corrections) <= {"outputs"}
