"""The sinkage exponent of each drive and the verdict on it, by windows with free initial states.

Windows that start at recorded states carry their noise into n, more than anything else that a right model is off by. Where the
vehicle's file states a joint error, n is that of the joint fit of all drives (`softsoil.refinement.joint_fit`); else a moving
horizon over the drive has it, as in `softsoil estimate --method horizon`.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.late_clocks import LateClock, clocks_of
from softsoil.estimator.modes import run_guess, standing
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.verdict import Verdict, initial_guesses, judge
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.recording.drive import Recording
from softsoil.refinement.fit import Fit
from softsoil.refinement.trace import Bench
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import Soil

LIMITS = VerdictRules()


@dataclass(frozen=True)
class DriveN:
    """n of one drive, its standard deviation and the verdict on it."""

    n: float
    std: float
    verdict: Verdict


@dataclass(frozen=True)
class FittedDrives:
    """Drives with a fit of one vehicle: declaration: of vehicle and law; soils: class of each drive; start: seconds left out at
    the beginning; bench, fit: of that vehicle, whose n stands where `joint`, a fit with free starts, or where a drive holds no
    window."""

    recordings: Sequence[Recording]
    declaration: Declaration
    soils: Sequence[Soil]
    start: float
    bench: Bench
    fit: Fit
    joint: bool

    def judged(self) -> tuple[DriveN, ...]:
        """n of each drive with its verdict; empty on hard ground."""
        found = []
        for (n, std), (recording, model, guess) in zip(self._by_fit(), self._models(), strict=True):
            verdict = judge(recording, model, guess, (n,) if self.joint else None, tied=True, start=self.start)
            if verdict.evidence is not None and self.joint:
                std = float(np.hypot(std, verdict.evidence.soil.more * n))
                verdict = _as_sure(verdict, std / n)
            elif verdict.evidence is not None:
                n, std = float(verdict.evidence.n[0]), float(verdict.evidence.std[0])
            found.append(DriveN(n, std, verdict))
        return tuple(found)

    def late_clocks(self) -> tuple[tuple[LateClock, ...], ...]:
        """Of each drive that is not consistent, the clocks that, set right, make it so; empty on hard ground."""
        return tuple(
            clocks_of(recording, model, one.verdict, True, self.start)
            for (recording, model, _), one in zip(self._models(), self.judged(), strict=True)
        )

    def plain(self) -> tuple[float, ...]:
        """The same n without a verdict, for comparison."""
        values = [n for n, _ in self._by_fit()]
        if self.joint:
            return tuple(values)
        rules = HorizonRules()
        for i, (recording, model, guess) in enumerate(self._models()):
            with contextlib.suppress(ValueError):  # a drive that holds no two windows
                windows = drive_windows(recording, model, self.start, rules)
                runs, _ = standing([run_guess(windows, one, True, rules) for one in initial_guesses(guess)])
                values[i] = float(runs[0].horizon.n[0])
        return tuple(values)

    def _by_fit(self) -> list[tuple[float, float]]:
        """n and standard deviation of each drive by the fit, with the share by numbers that it did not free."""
        values = [self.fit.named()[free.name] for free in self.bench.ground] if self.bench.sinks else []
        return [(n, float(np.hypot(std, self.declaration.vehicle.n_error * n))) for n, std in values]

    def _models(self) -> list[tuple[Recording, Model, float]]:
        """Each drive with its model and a first guess of n; none on hard ground."""
        vehicle, law = self.declaration.vehicle, self.declaration.law
        pairs = zip(self.recordings, self.soils, strict=True) if self.bench.sinks else ()
        return [(recording, Declaration(vehicle, soil, law).build(), float(soil.n)) for recording, soil in pairs]


def _as_sure(verdict: Verdict, share: float) -> Verdict:
    """The verdict, not identified where n's standard deviation by the joint fit, as a share of n, is more than two estimates may
    differ by."""
    if not verdict.usable or share <= LIMITS.same:
        return verdict
    reason = (
        f"the drives determine n to ± {100 * share:.0f} % only (limit {100 * LIMITS.same:.0f} %), since numbers of the vehicle "
        "or effects that are free beside it are as uncertain"
    )
    return replace(verdict, word="not_excited", reason=reason)


def not_to_be_used(found: Sequence[DriveN], reason: str) -> tuple[DriveN, ...]:
    """The same n, none of them identified, for a reason that lies in the vehicle."""
    return tuple(
        replace(one, verdict=replace(one.verdict, word="inconsistent", reason=reason)) if one.verdict.usable else one
        for one in found
    )
