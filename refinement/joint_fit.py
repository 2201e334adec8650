"""Drives fitted by windows with free initial states, n of each, the vehicle's numbers within their joint error, and effects.

Minimised over n of each drive, the numbers theta and the effects' parameters e: sum over windows of min over x0 of sum rho(z)
plus sum rho(k R (theta - theta_0)), R'R = C^-1, plus the prior of e. As in the identification that made C, k = 2 standard
errors of windows count as one: what the model lacks is alike in all of them. rho (Huber's) lets a number go that the drives
contradict: the strain says so. Numbers that C lacks have k times the errors stated of them. With a load the rear toe is free:
springs give way under it, and links turn the wheels. The second term over k^2 and what is expected of it is the strain
(`softsoil.windows.strain`): a high one says that the vehicle has changed, though n and the numbers predict well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.tuning import Tuning
from softsoil.files.joint_error import JointError, joint_error_of
from softsoil.recording.drive import Recording
from softsoil.refinement.doubts import doubts
from softsoil.refinement.fit import Fit
from softsoil.refinement.rules import RULES
from softsoil.refinement.trace import Bench, whole_model
from softsoil.refinement.unknown_ground import N_NAMES
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.model import Model
from softsoil.windows.absent_wheels import with_log_wheels
from softsoil.windows.free_starts import JointPrior, free_windows, joint_prior, steps_of, until
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.own_numbers import adds_mass, load_of, with_load
from softsoil.windows.parameters import Free
from softsoil.windows.strain import last_step, marginal, strain
from softsoil.windows.window_fit import WindowFit, fit_windows, window_costs

Array = NDArray[np.float64]

MIDDLE_N = 0.7
"""n from where drives are fitted, too: noise at recorded starts may have put a first n beyond a ridge."""
TOE = "toe_rear"
"""The number of the vehicle that a load on its springs changes most."""


@dataclass(frozen=True)
class Fits:
    """Fits with free starts: final, whole: benches by fits to the first part and to all of each drive; last: the fit to all."""

    final: Bench
    whole: Bench
    last: Fit


@dataclass(frozen=True)
class JointFit:
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
    ) -> JointFit:
        model = with_log_wheels(with_load(whole_model(declaration, names)), recordings)
        table = doubts(declaration.vehicle)
        declared = {name: float(doubt.signal.nominal) for name, doubt in table.items()}
        numbers = tuple(replace(d.free, known=None) if d.signal.name in error.names else d.free for d in table.values())
        p = np.tile(model.p.nominal, (len(bench.absent), 1))
        shared = [name for name in model.p.names if name in bench.model.p]
        p[:, [model.p.index(name) for name in shared]] = bench.absent[:, [bench.model.p.index(name) for name in shared]]
        for name, value in declared.items():
            p[:, model.p.index(name)] = value
        steps = {s.drive.dt for s in bench.shootings}
        compiled = {dt: WindowModel(model, dt, steps_of(dt)) for dt in steps}
        return cls(tuple(recordings), bench, model, compiled, error, declared, numbers, p)

    def windows(self, share: float) -> list[FreeWindows]:
        """The windows in the first `share` of each drive, no sensor better than the filter believes one to be: what the
        equations miss is not white, and would strain numbers that are right; ValueError where a drive holds no two."""
        drives = [s.drive for s in self.bench.shootings]
        parts = [until(d, d.first + round(share * (len(d.t) - d.first))) for d in drives]
        pairs = zip(parts, self.recordings, strict=True)
        floor = np.array(Tuning().sensor_floor)
        return [free_windows(self.compiled[d.dt], d, r, floor) for d, r in pairs]

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

    def plain(self) -> tuple[WindowFit, float]:
        """The fit without effects, and its squares: the better one of those from the bench's n and from MIDDLE_N."""
        p = self.p.copy()
        p[:, [self.model.p.index(name) for name in N_NAMES]] = MIDDLE_N
        return min((self.fitted(), replace(self, p=p).fitted()), key=lambda found: found[1])

    def best(self, effects: Sequence[Effect], traced: Fit, plain: WindowFit) -> tuple[WindowFit, float]:
        """The fit with effects from the traced n and declared numbers, or from where both are in the effects' place (`plain`):
        each alone may end in a lesser minimum."""
        return min((self.fitted(effects, traced, at) for at in (None, plain)), key=lambda found: found[1])

    def prior_with(self, effects: Sequence[Effect]) -> JointPrior:
        """The joint prior of the vehicle's numbers; with a load the rear toe may be another one."""
        error = self.error
        if any(adds_mass(effect) for effect in effects) and TOE in error.names:
            covariance, index = error.covariance, error.names.index(TOE)
            covariance[index, index] += RULES.unsettled_toe**2
            error = joint_error_of(error.names, covariance)
        return joint_prior(error, self.model, self.declared)

    def load(self, fit: WindowFit) -> tuple[float, float] | None:
        """Share of its mass by which the drives have the vehicle heavier than declared, near the rear axle, with the standard
        error; one step from a fit without a load. None where one is declared, and free anyway."""
        vehicle = self.model.geometry
        effect = load_of(vehicle)
        mass, *places = effect.parameters.names
        if effect.name in vehicle.effects:
            return None
        p = fit.p.copy()
        for place in places:
            p[:, self.model.p.index(place)] = effect.typical[place]
        windows = self.windows(1.0)
        for one, row, x0 in zip(windows, fit.p, fit.x0, strict=True):
            one.follow(row, x0)
        free = (*fit.free, Free(mass, (mass,), 0.1 * vehicle.mass, -np.inf, np.inf))
        start = np.array([*fit.value, effect.parameters[mass].nominal])
        prior = self.prior_with(())
        heavy = replace(prior, root=RULES.look_error * prior.root)
        there = fit_windows(windows, free, start, p, [heavy], 0)
        slope = np.array([0.0 if f.known is None else 1.0 / f.known[1] for f in free])
        centre = np.array([0.0 if f.known is None else f.known[0] for f in free])
        known = np.diag(slope**2), slope**2 * (start - centre)
        step, std = last_step(there.information + known[0], there.scores.sum(axis=0) + known[1])
        return step / vehicle.mass, RULES.look_error * std / vehicle.mass

    def strain(self, fit: WindowFit, effects: Sequence[Effect] = ()) -> float:
        """Strain of the numbers in a fit with effects: about 1 for the vehicle of the file."""
        prior, names = self.prior_with(effects), [f.name for f in fit.free]
        kept = np.array([names.index(name) for name in prior.names])
        windows = fit.hessians[:-1].sum(axis=0) / RULES.look_error**2  # the last cluster is the prior itself
        return strain(prior.residual(fit.p[0])[0], marginal(windows, kept), prior.root)

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
        shared = [name for name in self.model.p.names if name in bench.model.p]
        absent[:, [bench.model.p.index(name) for name in shared]] = fit.p[:, [self.model.p.index(name) for name in shared]]
        last = Fit(fit.free, fit.value, wider * fit.std, absent, fit.cost, fit.at_bound)
        return replace(bench, absent=absent, accepted=_own(fit.free, effects), loose=self.numbers), last


def stated_error(declaration: Declaration, bench: Bench) -> JointError | None:
    """The joint error that the vehicle's file states of numbers that drives may doubt; None on rigid ground."""
    joint = declaration.vehicle.joint_error
    return joint.only({*doubts(declaration.vehicle)}) if joint and bench.sinks else None


def _own(free: Sequence[Free], effects: Sequence[Effect]) -> tuple[Free, ...]:
    """Of what is free, the parameters of effects."""
    return tuple(f for f in free if any(f.name in effect.parameters for effect in effects))
