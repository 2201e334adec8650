"""Many drives of the closed loop by their first knowledge of n: what knowing n is worth, and how much of it is recovered.

Drives with the same seed see the same sensor noise, so that controllers are compared pair by pair.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.control.courses import WARM_UP
from softsoil.mpc_demo.closed_loop import LoopLog
from softsoil.mpc_demo.closed_loop_parts import Faults
from softsoil.mpc_demo.scenarios import GUESS_OFF, Scenario, scenarios

Array = NDArray[np.float64]

T_95 = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26)
"""Student's t, two-sided 95 %, for 1 to 9 degrees of freedom."""
LEAST_WORTH = 0.01
"""m: differences below this matter to nobody, however sure they are."""


@dataclass(frozen=True)
class Case:
    """One course at one speed (m/s), with what goes wrong; size: of the vehicle, warm_up: of the weave (m), see `scenarios`."""

    course: str
    speed: float
    faults: Faults = field(default_factory=Faults)
    size: float = 1.0
    warm_up: float = WARM_UP

    @property
    def name(self) -> str:
        """Course, speed, and whether sensors fail."""
        return f"{self.course} {self.speed:.3g} m/s" + (" faults" if self.faults != Faults() else "")

    def enlarged(self, size: float) -> Case:
        """The case for a vehicle of another size: speed and times with the size's root."""
        root = float(np.sqrt(size))
        return replace(self, speed=root * self.speed, faults=self.faults.stretched(root), size=size)

    def after(self, warm_up: float) -> Case:
        """The case after a weave of another length (m, for size 1), its faults as much later as the weave is longer."""
        seconds = self.size * (warm_up - self.warm_up) / self.speed
        return replace(self, faults=self.faults.later(seconds), warm_up=warm_up)

    def scenario(self, side: str) -> Scenario:
        """The course with the first guess of n too `low` or too `high`; on a change of soil it knows the first one."""
        course = replace(scenarios(self.size, self.warm_up)[self.course], speed=self.speed)
        if self.course == "two_soils":
            return course
        n = course.n_true(0.0)
        return replace(course, n_guess=n - GUESS_OFF if side == "low" else n + GUESS_OFF)

    @property
    def sides(self) -> tuple[str, ...]:
        """Sides of the truth on which the first guess stands: both where the soil is near its limit, else the low one."""
        near = self.course.startswith(("lane_change", "obstacles")) and self.faults == Faults()
        return ("low", "high") if near else ("low",)


STUDY = (
    *(Case("lane_change_clay", v) for v in (5.5, 7.5)),
    *(Case("lane_change_sandy_loam", v) for v in (6.0, 8.0)),
    Case("obstacles_clay", 6.5),
    *(Case("obstacles_sandy_loam", v) for v in (5.0, 7.5)),
    Case("slalom_clay", 5.0),
    Case("slalom_sandy_loam", 6.5),
    Case("two_soils", 5.0),
    Case("lane_change_clay", 6.0, Faults(dropout=(7.0, 10.0), burst=(4.0, 5.0))),
    Case("obstacles_sandy_loam", 6.0, Faults(dropout=(8.0, 11.0), burst=(11.5, 12.5))),
)
"""Both soils at speeds from 5 to 8 m/s; the dropouts lie over the beginning of the manoeuvre."""


@dataclass(frozen=True)
class Run:
    """What one drive leaves: figures of a LoopLog; told: low, high (the guess), true, est_low or est_high (who began where)."""

    case: str
    told: str
    seed: int
    tracking_rms: float
    max_error: float
    clearance: float | None
    failures: int
    late: int
    blocked: int
    gated: int
    finished: bool
    n_manoeuvre: float
    n_end: float
    solve_ms: list[float]

    @classmethod
    def of(cls, case: str, told: str, log: LoopLog) -> Run:
        """From the log of the drive."""
        n = log.column("n")
        solve = np.round(log.column("solve_ms"), 3)
        return cls(
            case, told, log.seed, log.tracking_rms, log.max_error,
            log.clearance if np.isfinite(log.clearance) else None, log.failures, log.late,
            int(np.count_nonzero(log.column("status") == "BLOCKED")), log.gated, log.finished,
            float(n[log.judged][0]) if log.judged.any() else float(n[-1]), float(n[-1]), solve.tolist(),
        )  # fmt: skip

    def as_json(self) -> dict:
        """Plain content, from which Run(**content) is the run again."""
        return asdict(self)


@dataclass(frozen=True)
class Worth:
    """What knowing n is worth in one figure, and how much of it the estimate recovers.

    worth: mean of guess - true over pairs (positive: knowing helps), its standard error; share: (guess - estimate)/(guess -
    true), share_low, share_high: 90 % of bootstrap samples of seeds; None where knowing does not matter.
    """

    worth: float
    error: float
    share: float | None
    share_low: float | None = None
    share_high: float | None = None

    @property
    def matters(self) -> bool:
        """Whether knowing n helps beyond scatter and by more than LEAST_WORTH."""
        return self.share is not None


def worth_of(guess: Array, true: Array, found: Array, least: float = LEAST_WORTH) -> Worth:
    """Of one figure that is better when smaller, (S,) over the same seeds for the three controllers.

    least: a smaller mean difference counts as none. Raises ValueError for fewer than 2 seeds or unequal numbers.
    """
    if not len(guess) == len(true) == len(found) or len(guess) < 2:
        raise ValueError(f"worth: expected the same seeds, 2 at least; found {len(guess)}, {len(true)}, {len(found)}")
    apart, count = guess - true, len(guess)
    mean, error = float(apart.mean()), float(apart.std(ddof=1) / np.sqrt(count))
    if mean < max(T_95[min(count - 2, len(T_95) - 1)] * error, least):
        return Worth(mean, error, None)
    picks = np.random.default_rng(0).integers(0, count, (2000, count))
    below = apart[picks].mean(axis=1)
    shares = (guess - found)[picks].mean(axis=1) / np.where(below > 0, below, np.nan)
    low, high = np.nanpercentile(shares, (5, 95))
    return Worth(mean, error, float((guess - found).mean() / mean), float(low), float(high))


def pooled_share(guess: Array, true: Array, estimate: Array, groups: Sequence[object] | None = None) -> tuple[float, float]:
    """(share recovered, its standard error) over drives of different courses, (P,) of a figure that is better when smaller.

    Ratio estimator sum(guess - estimate)/sum(guess - true), its error from the residuals of the groups. groups (P,): what is
    alike for comparisons that share a drive, default each for itself. ValueError for fewer than 2 groups, or where knowing n is
    worth nothing.
    """
    gain, worth = guess - estimate, guess - true
    own = list(range(len(gain))) if groups is None else list(groups)
    count = len({*own})
    if count < 2 or not worth.sum() > 0.0:
        raise ValueError(f"share: expected 2 drives or more and a positive worth, found {count} and {worth.sum():.3g} m")
    share = float(gain.sum() / worth.sum())
    together = dict.fromkeys(own, 0.0)
    for key, left in zip(own, gain - share * worth, strict=True):
        together[key] += float(left)
    scatter = sum(left**2 for left in together.values()) * count / (count - 1)
    return share, float(np.sqrt(scatter) / worth.sum())


def paired(runs: Sequence[Run], case: str, told: str, figure: str) -> Array:
    """(S,) the figure of one controller, by seed: tracking_rms, or need, how far short of the best clearance (-clearance)."""
    mine = sorted((run for run in runs if run.case == case and run.told == told), key=lambda run: run.seed)
    if figure == "need":
        return np.array([-np.inf if run.clearance is None else -run.clearance for run in mine])
    return np.array([getattr(run, figure) for run in mine])
