"""What the identified numbers leave of the motion of each log: more than any right model leaves, and something of what was given
is wrong that is no number of the vehicle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softsoil.estimator.evidence import motion_of, unexplained
from softsoil.estimator.hard_ground import compare_hard_ground, on_hard_ground
from softsoil.estimator.modes import run_guess
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.soil_error import soil_error
from softsoil.estimator.verdict import CHANNEL_WORDS
from softsoil.estimator.verdict_rules import OWN_MOST, VerdictRules
from softsoil.recording.drive import Recording
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import JUDGED, Vehicle

LIMITS = VerdictRules()


@dataclass(frozen=True)
class Unexplained:
    """What a model leaves of one log.

    log; share: of each channel of `JUDGED`, root mean square share of its motion beyond sensor noise, 0 where that is not seen by
    two standard errors; low: the same two standard errors below; n: sinkage exponent that leaves it; class_std: standard
    deviation of n, as a share, by the errors that the soil's file states. The first two are empty where the log hardly turns, or
    no window of it can be judged.
    """

    log: str
    share: Mapping[str, float]
    low: Mapping[str, float]
    n: float
    class_std: float = 0.0

    def over(self, limits: Mapping[str, float]) -> tuple[float, str]:
        """Largest of `low` over its limit, and of which channel; limits: share of each channel's motion."""
        return max(((self.low.get(name, 0.0) / limit, name) for name, limit in limits.items()), default=(0.0, ""))

    def beyond(self, limits: Mapping[str, float]) -> str:
        """The channel of which more is left than its limit, empty for none; limits: as of `over`."""
        times, name = self.over(limits)
        return name if times > 1.0 else ""


def own_logs(
    recordings: Sequence[Recording], soils: Sequence[Soil], vehicle: Vehicle, n: Mapping[str, float], start: float
) -> tuple[Unexplained, ...]:
    """What identified numbers leave of every log.

    soils: of each; vehicle: identified; n: of each log by the fit, a first guess here; start: seconds left out at the beginning.
    """
    pairs = zip(recordings, soils, strict=True)
    return tuple(_unexplained_of(recording, bicycle(vehicle, soil), n[recording.name], start) for recording, soil in pairs)


def _unexplained_of(recording: Recording, model: Model, n: float, start: float) -> Unexplained:
    rules = HorizonRules()
    try:
        windows = drive_windows(recording, model, start, rules)
    except ValueError:
        return Unexplained(recording.name, {}, {}, n)
    horizon = run_guess(windows, n, True, rules).horizon
    found = float(horizon.n[0])
    if motion_of(windows) < LIMITS.least_motion:
        return Unexplained(recording.name, {}, {}, found)
    windows.follow(horizon.parameters(horizon.n), np.array(horizon.summary.states))
    class_std = soil_error(windows, horizon).std
    left, error = unexplained(windows, horizon)
    low = {name: float(np.sqrt(max(left[name] - LIMITS.unexplained_sigmas * error[name], 0.0))) for name in left}
    share = {name: float(np.sqrt(left[name])) if low[name] > 0.0 else 0.0 for name in left}
    return Unexplained(recording.name, share, low, found, class_std)


def own_unexplained(logs: Sequence[Unexplained]) -> dict[str, float]:
    """The largest share of each channel over the logs, for the vehicle's file; empty where no log says any."""
    return {name: max(shares) for name in JUDGED if (shares := [one.share[name] for one in logs if name in one.share])}


def more_than_right(logs: Sequence[Unexplained]) -> float:
    """By which factor the numbers leave more of the logs than a right model does, 1 to `OWN_MOST`."""
    own = own_unexplained(logs)
    return min(max([1.0, *(own.get(name, 0.0) / limit for name, limit in LIMITS.unexplained)]), OWN_MOST)


def doubt(
    recordings: Sequence[Recording],
    soils: Sequence[Soil],
    before: Vehicle,
    logs: Sequence[Unexplained],
    contradicted: Sequence[str],
    start: float,
    vague: float = 0.0,
    limits: Mapping[str, float] | None = None,
) -> str:
    """Why the log of which most is left speaks against what was given, empty where no more is left than is allowed.

    recordings, soils, start: as of `own_logs`; before: the vehicle as expected before the fit, whose numbers no fit of soft
    soil to a road has bent; logs: result of `own_logs`; contradicted: given numbers that the fit contradicts; vague: error of n
    by the identified numbers, as a share, where it is so large that no more may be left than a right model leaves, else 0;
    limits: share of each channel's motion that may be left, default that, or `OWN_MOST` times as much where n is not vague.
    """
    right = dict(LIMITS.unexplained)
    allowed = limits or {name: limit * (1.0 if vague else OWN_MOST) for name, limit in right.items()}
    i = max(range(len(logs)), key=lambda i: logs[i].over(allowed)[0])
    worst = logs[i]
    name = worst.beyond(allowed)
    if not name:
        return ""
    more = f", {100 * allowed[name]:.1f} % are allowed" if allowed[name] > right[name] else ""
    said = (
        f"With every number free the model leaves {100 * worst.low[name]:.0f} % or more of the {CHANNEL_WORDS[name]}'s motion of "
        f"{worst.log} unexplained beyond sensor noise (a right one at most {100 * right[name]:.1f} %{more})"
        + (f", and n by them has an error of {100 * vague:.0f} %" if vague else "")
    )
    friction = _friction(recordings[i], bicycle(before, soils[i]), worst.n, start)
    if friction > 0.0:
        ground = f"hard ground with a coefficient of friction of {friction:.2f} leaves less"
        return f"{said}; {ground}: this is no soft soil, or none as the force law has it."
    until = f" Until that is mended, nothing is to be made of what contradicts {', '.join(contradicted)}." if contradicted else ""
    return (
        f"{said}: its soil is of another class than declared or does not act as the force law has it, something acts that is not "
        f"declared, or a channel is wrong (a delay, a sign, a scale).{until}"
    )


def _friction(recording: Recording, model: Model, n: float, start: float) -> float:
    """Coefficient of friction of the hard ground that leaves less of a log than soft soil does, 0 where none does."""
    rules = HorizonRules()
    windows, road = (drive_windows(recording, one, start, rules) for one in (model, on_hard_ground(model)))
    hard = compare_hard_ground(windows, road, float(run_guess(windows, n, True, rules).horizon.n[0]))
    better = hard.friction >= LIMITS.road and hard.better > LIMITS.road_sigmas * hard.better_std
    return float(hard.friction) if better else 0.0
