"""A vehicle file judged on clean drives whose n is known: n by both estimators with Table-5 noise, and predictions over 2.5 s."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from softsoil.checking.usable import usable
from softsoil.declaration.late_steering import late_steering
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.estimate import run_method
from softsoil.estimator.evidence import gather
from softsoil.estimator.horizons import START_UP, Replay
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.verdict import BOUNDS, IDENTIFIED, decide, initial_guesses
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.identification.result import JUDGED_STATES
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import declared_vehicle, vehicle_of
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import Vehicle

GUESSES = (0.4, 0.9)
"""First guesses of n."""
HORIZON = 2.5
"""s of the predictions."""
TRUSTED = 0.10
"""Error of n, as a share, beyond which it must not be called identified."""


@dataclass(frozen=True)
class Estimated:
    """One estimate: log, method, first guess, error of n as a share, verdict; its standard deviation as a share, and what the
    vehicle file's n_error has of that."""

    log: str
    method: str
    guess: float
    error: float
    verdict: str
    std: float
    common: float


@dataclass(frozen=True)
class Judgement:
    """estimates: as `softsoil.estimate` says; ratios: of mean squared errors at HORIZON, per log: of the known file as it
    stands, and of the numbers expected of any such vehicle, over the judged file's, geometric mean over states; strains: of the
    file's numbers, per log, where it states their joint error; alone: errors of n by the filter itself, as shares."""

    estimates: tuple[Estimated, ...]
    ratios: tuple[tuple[float, float], ...]
    strains: tuple[float, ...]
    alone: tuple[float, ...]

    def errors(self, method: str) -> np.ndarray:
        """Errors of n (%) by a method, without sign."""
        return 100.0 * np.abs([e.error for e in self.estimates if e.method == method])

    @property
    def trusted_wrongly(self) -> int:
        """Estimates called identified that are more than TRUSTED off."""
        return sum(e.verdict == "identified" and abs(e.error) > TRUSTED for e in self.estimates)

    def nees(self, method: str) -> tuple[float, float]:
        """Mean squared error of n in its standard deviations over what a method calls identified: as stated, and without the
        vehicle's n_error. NaN without any."""
        chosen = [e for e in self.estimates if e.method == method and e.verdict == "identified"]
        if not chosen:
            return np.nan, np.nan
        stated = np.mean([(e.error / e.std) ** 2 for e in chosen])
        return float(stated), float(np.mean([e.error**2 / (e.std**2 - e.common**2) for e in chosen]))


def without(drive: Recording, absent: Sequence[str]) -> Recording:
    """The drive as a log that lacks the channels `absent`."""
    return replace(drive, channels={name: values for name, values in drive.channels.items() if name not in absent})


def judge_drive(
    vehicle: Vehicle,
    known: Known,
    clean: Recording,
    soil: Soil,
    n: float,
    seed: int,
    horizon_guesses: Sequence[float] = GUESSES[1:],
    absent: Sequence[str] = (),
    noise: str = "table5",
) -> Judgement:
    """The vehicle on one drive; verdicts as of `softsoil.estimate`, each from its own guess and those tried beside it.

    vehicle: judged file; known: what its owner knows; clean: without noise; soil: class; n: true one; seed: of the noise;
    horizon_guesses: first guesses of the horizon, the last of which predictions take n from; the filter has GUESSES; absent:
    channels that the log lacks where n is estimated; noise: of its sensors.
    """
    noisy = usable(without(add_noise(clean, noise, seed), absent), vehicle, late_steering(vehicle))
    model = Declaration(vehicle, soil).build()
    rules, limits = HorizonRules(), VerdictRules().of(model)
    windows = drive_windows(noisy, model, START_UP, rules)
    evidence = {guess: gather(windows, initial_guesses(guess), True, rules) for guess in {*GUESSES, *horizon_guesses}}

    def by_filter(guess: float) -> tuple[float, float]:
        found = run_method(noisy, model, guess, "ukf")
        return float(found.n_front[-1]), float(found.n_front_std[-1])

    def by_windows(guess: float) -> tuple[float, float]:
        return float(evidence[guess].n[0]), float(evidence[guess].std[0])

    def estimated(method: str, guess: float, end: tuple[float, float], others: tuple[float, ...] = ()) -> Estimated:
        word = decide(evidence[guess], np.array(end[:1]), [np.array([other]) for other in others], limits).word
        end = by_windows(guess) if word == IDENTIFIED else end  # as `softsoil.estimate` corrects it
        return Estimated(clean.name, method, guess, end[0] / n - 1.0, word, end[1] / n, vehicle.n_error * end[0] / n)

    best = by_windows(horizon_guesses[-1])[0]
    estimates = [estimated("horizon", guess, by_windows(guess)) for guess in horizon_guesses]
    alone = []
    for guess in GUESSES:
        others = (by_filter(float(np.clip(evidence[guess].n[0], *BOUNDS)))[0],)
        end = by_filter(evidence[guess].guess)
        alone.append(end[0] / n - 1.0)
        estimates.append(estimated("ukf", guess, end, others))
    mse = []
    most = float(np.abs(clean["steer"]).max() * 1.02)
    for numbers in (declared_vehicle(known).with_(max_steer=most), vehicle_of(known, {"max_steer": most}), vehicle):
        built = Declaration(numbers, soil.with_(n=best)).build()
        mse.append(Replay(clean, built).windows(built.p.nominal, HORIZON).mse)
    before, expected = (float(np.exp(np.mean([np.log(one[s] / mse[2][s]) for s in JUDGED_STATES]))) for one in mse[:2])
    change = evidence[horizon_guesses[-1]].change
    return Judgement(tuple(estimates), ((before, expected),), () if change is None else (change.strain,), tuple(alone))


def words(part: Judgement) -> str:
    """The judgement of one drive in one line."""
    estimates = ", ".join(
        f"{e.method} from {e.guess:g} {100 * e.error:+.1f} ± {100 * e.std:.1f} % {e.verdict}" for e in part.estimates
    )
    before, expected = part.ratios[0]
    alone = ", ".join(f"{100 * error:+.1f}" for error in part.alone)
    strain = "".join(f", strain {one:.1f}" for one in part.strains)
    return f"{estimates}; the filter itself {alone} %{strain}; mse {before:.0f} ({expected:.1f}) times smaller"


def joined(parts: Sequence[Judgement]) -> Judgement:
    """Judgements of several drives as one."""
    return Judgement(*(sum((getattr(p, name) for p in parts), ()) for name in ("estimates", "ratios", "strains", "alone")))


def lines(judgement: Judgement) -> list[str]:
    """The judgement in words, one line each."""
    out = []
    for method in ("horizon", "ukf"):
        errors = judgement.errors(method)
        within = 100.0 * float(np.mean(errors <= 10.0))
        out.append(
            f"n by {method}, Table-5 noise, {len(errors)} estimates: median {np.median(errors):.1f} %, worst {errors.max():.1f} %"
            f", {within:.0f} % within 10 %; NEES of those identified {judgement.nees(method)[0]:.2f}, "
            f"{judgement.nees(method)[1]:.2f} without the file's n_error"
        )
    errors = 100.0 * np.abs(judgement.alone)
    out.append(f"n by the filter itself: median {np.median(errors):.1f} %, worst {errors.max():.1f} %")
    verdicts = [e.verdict for e in judgement.estimates]
    counts = ", ".join(f"{word} {verdicts.count(word)}" for word in sorted(set(verdicts), key=verdicts.count, reverse=True))
    out.append(f"verdicts: {counts}; more than 10 % off and called identified: {judgement.trusted_wrongly} of {len(verdicts)}")
    plain, expected = np.exp(np.mean(np.log(judgement.ratios), axis=0))
    out.append(
        f"mse at {HORIZON} s, geometric mean: {plain:.1f} times smaller than with the known file as it stands, {expected:.1f} "
        "times than with everything else as expected of any vehicle"
    )
    return out
