"""The sinkage exponent of a log by the default policy, the same for the command line, the study and Python."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from softsoil.checking.geometry_check import beyond_doubt
from softsoil.checking.usable import usable
from softsoil.declaration.ground import sinks
from softsoil.declaration.handed import check_model
from softsoil.declaration.late_steering import late_steering
from softsoil.estimator.driveline_choice import Choice, log_driveline, with_choice
from softsoil.estimator.horizons import START_UP
from softsoil.estimator.moving_horizon import estimate_horizon
from softsoil.estimator.terrain import TerrainEstimate, estimate_terrain
from softsoil.estimator.tuning import Tuning
from softsoil.estimator.ukf import Counts
from softsoil.estimator.verdict import Verdict, judge
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.states import known_states
from softsoil.symbolic.model import Model
from softsoil.windows.absent_wheels import absent_wheels

METHODS = ("ukf", "horizon")


def estimate(
    log: Recording | pd.DataFrame | str | Path,
    model: Model,
    n0: float | None = None,
    *,
    method: str = "ukf",
    start: float = START_UP,
    tuning: Tuning | None = None,
    progress: Callable[[float], None] | None = None,
    correct: bool = True,
) -> TerrainEstimate:
    """The sinkage exponent along a log, from sensor channels only, with the verdict on whether it may be used.

    log: a drive, its file, or a table with the default columns: its channels are checked against each other as by the command,
    a doubtful one is a UserWarning, absent ones are derived; model: with its declared effects, of which any ties n of both
    axles, as the declared effects say what differs between them; without effects front and rear have their own, as in the
    paper; n0: initial guess (default: the soil's); where the windows fit clearly worse at its end than from another one, that
    one takes its place; method: "ukf", the unscented Kalman filter (paper, section IV), or "horizon", windows with free initial
    states; start: seconds left out at the beginning; tuning: of the filter; progress: called with the share that is done;
    correct: whether the windows correct the filter's n at the end of an identified drive, as the horizon does while driving;
    else n is the filter's own, as in the paper. With a law of hard ground there is no n: NaN, and the verdict "no_soil".
    Raises ValueError for an initial guess outside the bounds of n, an unknown method, a log without the channels, or
    channels that contradict each other or the vehicle's geometry beyond doubt, TypeError for what is no model.

    Example:
        >>> import softsoil
        >>> model = softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
        >>> drive = softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 12.0)
        >>> found = softsoil.estimate(drive, model, n0=0.7)
        >>> found.verdict.word
        'identified'
        >>> bool(abs(found.n_front[-1] - 0.5) < 0.1)
        True
    """
    if method not in METHODS:
        raise ValueError(f"method: expected one of {', '.join(METHODS)}; found {method!r}")
    check_model("estimate", model)
    drive = usable(log, model.geometry, late_steering(model.geometry))
    another = beyond_doubt(drive, model.geometry) if model.geometry is not None else ""
    if another:
        raise ValueError(f"{another}: another vehicle, or a sensor that is wrong or stands elsewhere")
    first = float(model.p["n_f"].nominal) if n0 is None else n0
    tied = bool(model.effects)
    if not sinks(model):
        return _no_soil(drive, model)
    choice = log_driveline(drive, model, first, start)
    declared, model = model, model if choice is None else with_choice(model, choice)
    found = run_method(drive, model, first, method, start=start, tuning=tuning, progress=progress)

    def ends(of: TerrainEstimate) -> tuple[float, ...]:
        return (of.n_front[-1],) if tied else (of.n_front[-1], of.n_rear[-1])

    def again(guess: float) -> tuple[float, ...]:
        return ends(run_method(drive, model, guess, method, start=start, tuning=tuning))

    filtered = method == "ukf"
    verdict = judge(
        drive, model, first, ends(found), tied=tied, start=start, again=again if filtered else None,
        corrected=correct and filtered,
    )  # fmt: skip
    if verdict.evidence is not None and verdict.evidence.guess != first:  # n0 leads into a mode that fits clearly worse
        return estimate(drive, declared, verdict.evidence.guess, method=method, start=start, tuning=tuning, correct=correct)
    verdict = _with_trial(verdict, found.on_trial)
    found = _with_soil_error(replace(found, verdict=judged_without_wheels(drive, verdict, choice)))
    return _corrected(found) if correct and method == "ukf" else found


def _with_trial(verdict: Verdict, on_trial: tuple[float, float] | None) -> Verdict:
    """The verdict with a jump of n that the log ends too soon to bear out, where the n after it is not to be used."""
    if on_trial is None or verdict.word != "inconsistent":
        return verdict
    t, before = on_trial
    late = f"n jumps at {t:.1f} s from {before:.2f}, and the log ends too soon to bear that out: what ends before it says more"
    return replace(verdict, reason=f"{verdict.reason}; {late}")


def _corrected(judged: TerrainEstimate) -> TerrainEstimate:
    """A filter's estimate with n and its standard deviation at the end as the windows have them, where it is identified.

    judged: with its verdict. Both read the same drive; the windows follow it without process noise, and their n is nearer to
    the truth (`benchmarks.estimate_nominal`, `benchmarks.identify_plant`). What the filter itself had is `by_filter` then.
    """
    evidence = None if judged.verdict is None or not judged.verdict.usable else judged.verdict.evidence
    if evidence is None:
        return judged
    front, rear, front_std, rear_std = (
        column.copy() for column in (judged.n_front, judged.n_rear, judged.n_front_std, judged.n_rear_std)
    )
    by_filter = ((float(front[-1]), float(front_std[-1])), (float(rear[-1]), float(rear_std[-1])))
    front[-1], rear[-1], front_std[-1], rear_std[-1] = (*evidence.n[[0, -1]], *evidence.std[[0, -1]])
    return replace(
        judged, n_front=front, n_rear=rear, n_front_std=front_std, n_rear_std=rear_std, by_filter=by_filter,
        parameters={"n_f": float(front[-1]), "n_r": float(rear[-1])},
    )  # fmt: skip


def _with_soil_error(found: TerrainEstimate) -> TerrainEstimate:
    """The estimate with errors of the soil's class and of the force law in the standard deviation of n."""
    share = 0.0 if found.verdict is None or found.verdict.evidence is None else found.verdict.evidence.soil.more
    front, rear = (np.hypot(std, share * n) for std, n in ((found.n_front_std, found.n_front), (found.n_rear_std, found.n_rear)))
    return replace(found, n_front_std=front, n_rear_std=rear)


def _no_soil(drive: Recording, model: Model) -> TerrainEstimate:
    """An estimate without n, at the end of the drive: the model's ground is hard."""
    unknown = np.full(1, np.nan)
    reason = f"nothing sinks with {model.name}: n has no meaning on hard ground; softsoil refine fits friction and tread"
    return TerrainEstimate(
        t=drive.t[-1:], n_front=unknown, n_rear=unknown, n_front_std=unknown, n_rear_std=unknown,
        states=known_states(drive)[-1:], nis=np.zeros(0), dof=np.zeros(0, dtype=int), counts=Counts(), step_us=unknown,
        verdict=Verdict("no_soil", reason),
    )  # fmt: skip


def judged_without_wheels(drive: Recording, verdict: Verdict, choice: Choice | None) -> Verdict:
    """The verdict with what stands for absent wheel speeds; none is "identified" between drivelines of different n."""
    absent = absent_wheels([drive])
    if not absent:
        return verdict
    if choice is not None and verdict.usable and choice.spread > VerdictRules().same:
        return replace(
            verdict, word="inconsistent", reason=f"without wheel speeds n depends on which wheels are driven: {choice}; declare "
            "[driveline] in the vehicle file"
        )  # fmt: skip
    driven = "" if choice is None else f"; {choice}"
    which = "wheel speeds" if len(absent) == len(WHEEL_CHANNELS) else f"speeds of {', '.join(absent)}"
    return replace(verdict, reason=f"{verdict.reason}; {which} from the balance of forces{driven}")


def run_method(
    drive: Recording,
    model: Model,
    n0: float,
    method: str,
    *,
    start: float = START_UP,
    tuning: Tuning | None = None,
    progress: Callable[[float], None] | None = None,
) -> TerrainEstimate:
    """One estimator over one drive from one initial guess n0, not judged: for studies that know the truth.

    method, start, tuning, progress: as of `estimate`.
    """
    tied = bool(model.effects)
    if method == "ukf":
        return estimate_terrain(drive, model, n0, tied=tied, tuning=tuning, start=start, progress=progress)
    found = estimate_horizon(drive, model, n0, tied=tied, start=start, progress=progress)
    front, rear = found.n[:, 0], found.n[:, -1]
    return TerrainEstimate(
        t=found.t, n_front=front, n_rear=rear, n_front_std=found.std[:, 0], n_rear_std=found.std[:, -1],
        states=found.states, nis=np.zeros(0), dof=np.zeros(0, dtype=int),
        counts=Counts(), step_us=found.step_us, parameters={"n_f": float(front[-1]), "n_r": float(rear[-1])},
        changes=found.changes, begun=found.begun, n0=n0,
    )  # fmt: skip
