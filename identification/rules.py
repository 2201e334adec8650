"""What an identification decides by: thresholds with unit and meaning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Rules:
    """Thresholds.

    seen: largest share of its prior standard deviation that a number's standard error keeps for it to be identified;
    contradicted: standard deviations, of logs and measuring together, beyond which a given number is contradicted; bent: share
    of a given number by which the force law's own errors move it, in the standard error that it is judged by (`python -m
    benchmarks.identify_contradictions` prints where right tracks come out); contradicted_motion: as contradicted, of l_f by
    position against course, which depends on little else (the same command with --place 24); contradicted_rolling: of the
    radius by rolling; material: the least departure of a given number that matters, as a share of its value; n_std: largest
    standard error of n, as a share of it; n_error: error of n by the identified numbers, as a share, beyond which they may
    leave no more of the logs' motion than a right model, since numbers bent by a wrong soil class do both (`python -m
    benchmarks.identify_contradictions --classes`); inertia_std: the same of the yaw inertia; correlation: largest correlation
    of n and yaw inertia; load_share: of n's error that one number may cause before a manoeuvre is asked for (%); rounds:
    contradicted numbers that are freed one after another; model_error: standard deviations of numbers over their sampling
    errors, since what the force law misses moves them too: on the second reference vehicle, whose geometry is known, they were
    1 to 8 times those off; model_error_joint: the same for the joint error of all numbers, by the yaw inertia of vehicles of
    the plant (`python -m benchmarks.identify_plant --only-numbers`); odd: standard deviations from what is expected of any
    vehicle beyond which a number is none of a vehicle, and most_odd: so many of them together show another law, as where the
    soil's stresses lie otherwise; believable: share of a given number that it may be off by where ground resists the wheels,
    or a tape was misread; strange: standard deviations from there on which it is asked whether the soil shears anew in ruts; and
    other_ground: of the cost of the fit, what one on such ground leaves at most, with fewer strange numbers, to take its place;
    model_error_n: as model_error, of n, as a share; unseen_error_n:
    share of n by which it is off beside that where a log does not measure the lateral velocity, and where not all logs have the
    speed of every wheel (the same command with --absent v, and with --absent omega_fl,omega_fr,omega_rl,omega_rr).
    """

    seen: float = 0.75
    contradicted: float = 4.0
    bent: Mapping[str, float] = field(default_factory=lambda: {"track": 0.04, "track_rear": 0.04})
    contradicted_motion: float = 2.5
    contradicted_rolling: float = 3.0
    material: float = 0.003
    n_std: float = 0.08
    n_error: float = 0.05
    inertia_std: float = 0.15
    correlation: float = 0.95
    load_share: float = 2.0
    rounds: int = 3
    model_error: float = 4.0
    model_error_joint: float = 2.0
    model_error_n: float = 0.025
    unseen_error_n: float = 0.05
    odd: float = 5.0
    most_odd: int = 2
    believable: float = 0.05
    strange: float = 3.5
    other_ground: float = 0.99


RULES = Rules()
"""`python -m benchmarks.identify_suv` prints what they do on a vehicle of the reference simulator."""
