"""The numbers of a soil from drives of a known vehicle: what its class states with an error, fitted with n of each drive.

Minimised, as where `refine` fits drives (`softsoil.refinement.joint_fit`): the windows of all drives with free initial states,
the stated errors of the soil, and the joint error of the vehicle's numbers, which move with the rest. Two standard errors of
windows count as one, as in an identification. Friction and shear modulus change forces in other ways than n does, and good
drives tell them from it; k_phi hardly does: what it is uncertain by is n's uncertainty.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from softsoil.checking.usable import usable
from softsoil.declaration.late_steering import late_steering
from softsoil.estimator.tuning import Tuning, common_error
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.files.joint_error import JointError, joint_error_of
from softsoil.identification.asks import Excitation, excitation
from softsoil.identification.judge import path_errors
from softsoil.identification.result import mse_ratio
from softsoil.identification.rules import RULES, Rules
from softsoil.identification.unexplained import Unexplained, doubt, own_logs
from softsoil.recording.copies import refuse_copies
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import distinct
from softsoil.refinement.doubts import departure
from softsoil.refinement.unknown_ground import free_n
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil
from softsoil.symbolic.vehicle import Vehicle
from softsoil.windows.absent_wheels import with_log_wheels
from softsoil.windows.free_starts import JointPrior, free_windows, joint_prior, steps_of, until
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.own_numbers import with_own_numbers
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import Drive, shooting_drive
from softsoil.windows.window_fit import WindowFit, fit_windows

Array = NDArray[np.float64]

FIT_SHARE = 2 / 3
"""The first part of each drive that is fitted for the judgement; then all of it is."""
FIRST_N, MIDDLE_N = (0.45, 0.7, 0.95), 0.7
"""Where n starts beside the class's own, and where all numbers start beside the best of these."""
FARTHEST = 3.0
"""Standard deviations from the class beyond which a number contradicts it."""


@dataclass(frozen=True)
class SoilNumber:
    """One number of the soil: value, std, unit, what its class states of both (given, given_std), whether the drives say
    anything of it ("identified", or "not_identifiable"), and by how many standard deviations, of the drives and of its class
    together, they depart from it: at least those of its class by which the value does."""

    value: float
    std: float
    unit: str
    given: float
    given_std: float
    state: str
    departs: float

    @property
    def before(self) -> tuple[float, float]:
        """Value and standard deviation before any drive: those given."""
        return self.given, self.given_std

    @property
    def no_better(self) -> bool:
        """Whether the drives move it and leave its error as it was given."""
        return self.state == "identified" and self.std >= self.given_std


@dataclass(frozen=True)
class SoilIdentification:
    """The result of `identify_soil`.

    verdict: "identified", "needs_data" or "contradicts_given"; reason: one sentence; numbers; n_before, n: log -> (value,
    standard deviation) with the class as declared and with the identified numbers; before, after: horizon (s) -> state -> mean
    squared error over the last third of the drives, with n, and with all numbers, of their first two thirds; unexplained: what is
    left of each log; soil: with its numbers and their uncertainty, n that of the first log; seconds.
    """

    verdict: str
    reason: str
    numbers: dict[str, SoilNumber]
    n_before: dict[str, tuple[float, float]]
    n: dict[str, tuple[float, float]]
    before: dict[str, dict[str, float]]
    after: dict[str, dict[str, float]]
    unexplained: tuple[Unexplained, ...]
    soil: Soil
    seconds: float

    @property
    def ratio(self) -> float | None:
        """How many times smaller the mean squared error over 2.5 s got; None where the drives hold no such windows."""
        return mse_ratio(self.before, self.after, "2.5")

    def as_json(self) -> dict:
        """The content of soil.json."""
        return {
            "verdict": self.verdict, "reason": self.reason,
            "numbers": {name: vars(one) for name, one in self.numbers.items()},
            "n": {log: {"value": value, "std": std} for log, (value, std) in self.n.items()},
            "before": {"mse": self.before, "n": {log: value for log, (value, _) in self.n_before.items()}},
            "after": {"mse": self.after},
            "unexplained": {one.log: dict(one.share) for one in self.unexplained},
            "seconds": self.seconds,
        }  # fmt: skip


def identify_soil(
    logs: Sequence[Recording | str | Path],
    soil: Soil,
    vehicle: Vehicle,
    *,
    start: float = 2.0,
    rules: Rules = RULES,
    progress: Callable[[float], None] = lambda share: None,
) -> SoilIdentification:
    """What drives of a known vehicle say of the soil that they were on, from sensor channels only.

    logs: one drive or more on one class of soil, or their files, checked and completed as by `softsoil.estimate`; each has its
    own n; soil: the class, with the standard deviations of those of its numbers that may be wrong; vehicle: with the joint error
    of its numbers, where its file states one: they are free within it; start: seconds left out at the beginning of each; rules:
    thresholds; progress: called with the share that is done.
    Raises ValueError for a soil that states no errors, or drives that cannot be used.

    Example:
        >>> import softsoil
        >>> soil = softsoil.load_soil("clay").with_(uncertainty=(("phi", 0.02), ("k", 0.003)))
        >>> log = softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 18.0)
        >>> found = softsoil.identify_soil([log], soil, softsoil.load_vehicle("reference"))
        >>> found.verdict, bool(abs(found.soil.phi - 0.2269) < 3 * found.numbers["phi"].std)
        ('identified', True)
    """
    began = time.perf_counter()
    if soil.joint_error is not None:  # it stands for the errors of its numbers alone
        stated = {**dict(soil.uncertainty), **dict(zip(soil.joint_error.names, soil.joint_error.std, strict=True))}
        soil = soil.with_(uncertainty=tuple(stated.items()))
    if not soil.uncertainty:
        raise ValueError(f"soil {soil.name}: expected a table [uncertainty] with the errors of its numbers, found none")
    recordings = distinct([usable(log, vehicle, late_steering(vehicle)) for log in logs])
    refuse_copies(recordings)
    bench = _Bench.of(recordings, soil, vehicle, start, rules)
    progress(0.2)
    first = bench.first_n()
    declared = bench.fitted((), FIT_SHARE, first)
    part = min((bench.fitted(bench.free, FIT_SHARE, at) for at in (first, bench.middle_n())), key=lambda fit: fit.cost)
    before, after = bench.errors(declared), bench.errors(part)
    progress(0.6)
    plain, whole = bench.fitted((), 1.0, _values(declared)), bench.fitted(bench.free, 1.0, _values(part))
    progress(0.8)
    numbers = bench.numbers(whole)
    n = bench.n(whole)
    found = soil.with_(
        verdict="", n=next(iter(n.values()))[0], uncertainty=tuple((name, one.std) for name, one in numbers.items()),
        joint_error=bench.together(whole, numbers), **{name: one.value for name, one in numbers.items()},
    )  # fmt: skip
    left = own_logs(recordings, [found] * len(recordings), vehicle, {log: value for log, (value, _) in n.items()}, start)
    allowed = dict(VerdictRules().of(bench.model).unexplained)
    doubted = doubt(recordings, [found] * len(recordings), vehicle, left, (), start, limits=allowed)
    verdict, reason = ("contradicts_given", doubted) if doubted else _verdict(numbers, n, whole, excitation(recordings, start))
    found = found.with_(verdict=verdict)
    return SoilIdentification(
        verdict, reason, numbers, bench.n(plain), n, before, after, left, found, time.perf_counter() - began
    )


@dataclass(frozen=True)
class _Bench:
    """The drives with the model of the vehicle on the declared soil: compiled per sample interval, the joint errors of both as a
    prior, the soil's numbers and the vehicle's as free ones."""

    recordings: tuple[Recording, ...]
    soil: Soil
    model: Model
    drives: tuple[Drive, ...]
    compiled: dict[float, WindowModel]
    prior: tuple[JointPrior, ...]
    own: tuple[Free, ...]
    free: tuple[Free, ...]
    rules: Rules

    @classmethod
    def of(cls, recordings: Sequence[Recording], soil: Soil, vehicle: Vehicle, start: float, rules: Rules) -> _Bench:
        model = bicycle(vehicle, soil)
        error = vehicle.joint_error
        model = with_log_wheels(model if error is None else with_own_numbers(model, error.names), recordings)
        drives = tuple(shooting_drive(one, model, start) for one in recordings)
        compiled = {dt: WindowModel(model, dt, steps_of(dt)) for dt in {drive.dt for drive in drives}}
        heavier, joint = rules.model_error_joint, soil.joint_error
        together = () if joint is None else joint.names
        own = () if error is None else tuple(
            Free(name, (name,), 0.5 * std, -np.inf, np.inf) for name, std in zip(error.names, error.std, strict=True)
            if name in model.p
        )  # fmt: skip
        free = tuple(
            Free(
                name, (name,), 0.5 * std, (signal := SOIL_SIGNALS[name]).lower, signal.upper,
                known=None if name in together else (float(getattr(soil, name)), std / heavier),
            )
            for name, std in soil.uncertainty
        )  # fmt: skip
        known = [one for one in (error, joint) if one is not None]
        return cls(tuple(recordings), soil, model, drives, compiled, _priors(known, model, heavier), own, free, rules)

    def windows(self, share: float) -> list[FreeWindows]:
        """The windows in the first `share` of each drive; ValueError where a drive holds no two."""
        floor = np.array(Tuning().sensor_floor)
        parts = [until(d, d.first + round(share * (len(d.t) - d.first))) for d in self.drives]
        return [free_windows(self.compiled[d.dt], d, r, floor) for d, r in zip(parts, self.recordings, strict=True)]

    def middle_n(self) -> dict[str, float]:
        """n of every drive in the middle of its range: with a wrong class the best n may lie beyond a ridge."""
        return {free.name: MIDDLE_N for free in free_n(len(self.drives))}

    def first_n(self) -> dict[str, float]:
        """n of every drive with all else as declared, from the best of a few."""
        windows, free = self.windows(FIT_SHARE), free_n(len(self.drives))
        p = np.tile(self.model.p.nominal, (len(windows), 1))
        fits = []
        for n in (float(self.soil.n), *FIRST_N):
            for one in windows:
                one.reset()
            fits.append(fit_windows(windows, free, np.full(len(free), n), p))
        return _values(min(fits, key=lambda fit: fit.cost))

    def fitted(self, soil: Sequence[Free], share: float, at: Mapping[str, float]) -> WindowFit:
        """n of each drive, the vehicle's numbers and the numbers `soil` by the first `share` of each drive; at: where they start,
        as declared where it does not say."""
        windows = self.windows(share)
        free = (*soil, *self.own, *free_n(len(windows)))
        start = np.array([at[f.name] if f.name in at else float(self.model.p[f.name].nominal) for f in free])
        return fit_windows(windows, free, start, np.tile(self.model.p.nominal, (len(windows), 1)), self.prior)

    def errors(self, fit: WindowFit) -> dict[str, dict[str, float]]:
        """Horizon -> state -> mean squared error over the last part of all drives, with what its first part says."""
        tables = [
            path_errors(self.compiled[drive.dt], drive, row, drive.first + round(FIT_SHARE * (len(drive.t) - drive.first)))
            for drive, row in zip(self.drives, fit.p, strict=True)
        ]
        return {
            horizon: {state: _mean([table[horizon][state] for table in tables]) for state in tables[0][horizon]}
            for horizon in tables[0]
        }

    def numbers(self, fit: WindowFit) -> dict[str, SoilNumber]:
        found = {}
        for name, given_std in self.soil.uncertainty:
            value, std = fit.named()[name]
            std = min(self.rules.model_error_joint * std, given_std)
            state = "identified" if std <= self.rules.seen * given_std else "not_identifiable"
            given, unit = float(getattr(self.soil, name)), SOIL_SIGNALS[name].unit
            departs = departure(Free(name, (name,), std, value, value, known=(given, given_std)), value, std)
            departs = max(departs, abs(value - given) / given_std)
            found[name] = SoilNumber(value, std, unit, given, given_std, state, departs)
        return found

    def together(self, fit: WindowFit, numbers: Mapping[str, SoilNumber]) -> JointError:
        """The joint error of the numbers, with the standard deviation of each as in `numbers`."""
        rows = [[free.name for free in fit.free].index(name) for name in numbers]
        std = np.array([one.std for one in numbers.values()])
        return joint_error_of((*numbers,), fit.correlation[np.ix_(rows, rows)] * np.outer(std, std))

    def n(self, fit: WindowFit) -> dict[str, tuple[float, float]]:
        """Log -> n and its standard deviation, what the vehicle's numbers and the force law make of it among that."""
        values = [fit.named()[free.name] for free in free_n(len(self.recordings))]
        own = common_error(self.rules.model_error_n, self.model)
        heavier = self.rules.model_error_joint
        pairs = zip(self.recordings, values, strict=True)
        return {one.name: (value, float(np.hypot(heavier * std, own * value))) for one, (value, std) in pairs}


def _priors(errors: Sequence[JointError], model: Model, heavier: float) -> tuple[JointPrior, ...]:
    """The joint errors of the vehicle's numbers and of the soil's, one observation beside the windows of the first drive."""
    if not errors:
        return ()
    parts = [joint_prior(e, model, {name: float(model.p[name].nominal) for name in e.names if name in model.p}) for e in errors]
    names, mean = tuple(name for part in parts for name in part.names), np.concatenate([part.mean for part in parts])
    return (JointPrior(model, names, mean, heavier * block_diag(*(part.root for part in parts))),)


def _mean(values: Sequence[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else np.nan


def _values(fit: WindowFit) -> dict[str, float]:
    return {name: value for name, (value, _) in fit.named().items()}


def _verdict(
    numbers: dict[str, SoilNumber], n: dict[str, tuple[float, float]], fit: WindowFit, had: Excitation
) -> tuple[str, str]:
    seen = [name for name, one in numbers.items() if one.state == "identified"]
    far = [name for name, one in numbers.items() if one.departs > FARTHEST]
    rest = [name for name in numbers if name not in seen]
    worst = max(std / value for value, std in n.values())
    if had.steers and not had.many_waves:
        return "needs_data", "Every log repeats one steering wave, whose amplitude and phase n and the soil change alike."
    if fit.at_bound:
        return "contradicts_given", f"At a bound of its range ends {', '.join(fit.at_bound)}: is it that class, that vehicle?"
    if far:
        rows = ((name, numbers[name]) for name in far)
        words = "; ".join(f"{name} is {one.value:.4g}, given as {one.given:.4g} ({one.departs:.1f})" for name, one in rows)
        return "contradicts_given", f"More than {FARTHEST:g} standard deviations from the class: {words}. Is it that class?"
    if not seen:
        return "needs_data", "The drives say no more of the soil than its class states: steer to full lock, at several speeds."
    left = f"; the drives do not show {', '.join(rest)}, which stay{'s' if len(rest) == 1 else ''} near the class" if rest else ""
    return "identified", f"{', '.join(seen)} by the drives, n to ± {100 * worst:.0f} % or better{left}."
