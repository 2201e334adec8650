"""Result of an identification: numbers with standard errors and states, effects, n of each log, errors before and after."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from softsoil.identification.unexplained import Unexplained
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import by_name
from softsoil.symbolic.vehicle import Vehicle

JUDGED_STATES = ("v", "omega_z", "psi", "y")


@dataclass(frozen=True)
class Found:
    """One number: value, standard deviation, unit, state ("given", "identified" or "not_identifiable"), change of n (%) by an
    error of one standard deviation, what was given (None for nothing), expected value and standard deviation before the logs."""

    value: float
    std: float
    unit: str
    state: str
    n_percent_per_std: float
    given: float | None
    before: tuple[float, float]

    @property
    def no_better(self) -> bool:
        """Whether it is identified with an error that is no smaller than what was expected before the logs."""
        return self.state == "identified" and self.given is None and self.std >= self.before[1] * (1.0 - 1e-6)

    @property
    def departs(self) -> float:
        """Standard deviations of what was expected before the logs by which the value departs from that."""
        return abs(self.value - self.before[0]) / max(self.before[1], 1e-300)


@dataclass(frozen=True)
class Judged:
    """Predictions of the log left out: its name; n and standard error with the vehicle as its owner's file declares it and with
    the identified numbers; before, expected, after: horizon -> state -> mean squared error with the declared vehicle, with the
    numbers expected of any such vehicle, and with the identified ones; rms_before, rms_after: of whole windows over what noise
    and a right model leave (1)."""

    log: str
    n_before: tuple[float, float]
    n_after: tuple[float, float]
    before: Mapping[str, Mapping[str, float]]
    expected: Mapping[str, Mapping[str, float]]
    after: Mapping[str, Mapping[str, float]]
    rms_before: float
    rms_after: float

    def ratio(self, horizon: str = "2.5", expected: bool = False) -> float | None:
        """How many times smaller the mean squared error got, geometric mean over v, omega_z, psi and y; None without windows.

        horizon (s), as in the tables; expected: against the expected numbers in the place of the declared vehicle.
        """
        return mse_ratio(self.expected if expected else self.before, self.after, horizon)


def mse_ratio(
    first: Mapping[str, Mapping[str, float]], second: Mapping[str, Mapping[str, float]], horizon: str
) -> float | None:
    """How many times smaller the second mean squared error is, geometric mean over JUDGED_STATES; None without windows.

    first, second: horizon -> state -> mean squared error; horizon (s), as in them.
    """
    before, after = first.get(horizon, {}), second.get(horizon, {})
    ratios = [before[s] / after[s] for s in JUDGED_STATES if before.get(s, 0.0) > 0.0 and after.get(s, 0.0) > 0.0]
    if len(ratios) < len(JUDGED_STATES) or not all(map(math.isfinite, ratios)):
        return None
    return math.exp(sum(map(math.log, ratios)) / len(ratios))


@dataclass(frozen=True)
class Contradiction:
    """A given number that the logs contradict: name, given, value and standard error by the logs, standard deviations between
    them, and by what evidence."""

    name: str
    given: float
    value: float
    std: float
    sigmas: float
    evidence: str


@dataclass(frozen=True)
class Identification:
    """The result of `identify`.

    verdict: "identified", "needs_data" or "contradicts_given"; reason: one sentence; numbers; n: log -> (value, standard error);
    judged; asks: manoeuvres, the most useful first; contradictions; unexplained: of each log; vehicle: complete, with
    uncertainty; known; notes; seconds.
    """

    verdict: str
    reason: str
    numbers: dict[str, Found]
    n: dict[str, tuple[float, float]]
    judged: Judged
    asks: tuple[str, ...]
    contradictions: tuple[Contradiction, ...]
    unexplained: tuple[Unexplained, ...]
    vehicle: Vehicle
    known: Known
    seconds: float
    notes: tuple[str, ...] = field(default_factory=tuple)

    def as_json(self) -> dict[str, Any]:
        """The content of identify.json."""
        numbers = {
            name: {
                "value": f.value,
                "std": f.std,
                "unit": f.unit,
                "state": f.state,
                "n_percent_per_std": f.n_percent_per_std,
                **({} if f.given is None else {"given": f.given}),
            }
            for name, f in self.numbers.items()
        }
        return {
            "verdict": self.verdict,
            "reason": self.reason,
            "numbers": numbers,
            "effects": self.vehicle.effects,
            "n": {log: {"value": value, "std": std} for log, (value, std) in self.n.items()},
            "n_error": self.vehicle.n_error,
            "unexplained": {one.log: dict(one.share) for one in self.unexplained},
            "judged_on": self.judged.log,
            "before": {"mse": self.judged.before, "n": self.judged.n_before[0], "rms": self.judged.rms_before},
            "expected": {"mse": self.judged.expected},
            "after": {"mse": self.judged.after, "n": self.judged.n_after[0], "rms": self.judged.rms_after},
            "asks": list(self.asks),
            "contradictions": [vars(c) for c in self.contradictions],
            "notes": list(self.notes),
            "seconds": self.seconds,
        }


def in_order(numbers: Mapping[str, Found]) -> list[str]:
    """Names in the order of a vehicle file."""
    return [name for name in by_name() if name in numbers]
