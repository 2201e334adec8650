"""Case study on measured data: a small wheel in sand, from the plate tests to a law that ploughs.

Fitted: n and the modulus on penetration tests alone; sinkage and heap on all slip angles (or repeats) but one.
Judged: the side force of the slip angle (repeat) that was left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.calibration.single_wheel import law_for
from softsoil.cases.cmu_data import (
    RADIUS,
    SINKAGE_FILE,
    WHEEL_FILE,
    WIDTH,
    SinkageTest,
    SteadyWheel,
    read_sinkage_tests,
    read_steady_wheel,
)
from softsoil.cases.ploughing_fit import (
    PARAMETERS,
    Hypothesis,
    Judged,
    Ploughs,
    at_bound,
    held_mean,
    judge_candidate,
    rms,
)
from softsoil.cases.sinkage_tests import Bearing, fit_bearing
from softsoil.symbolic.vehicle import GRAVITY

Array = NDArray[np.float64]

DENSITY = 1330.0
"""kg/m^3, the laboratory's."""
BASES = ("bekker", "turn_slip")
REFINED = "side_wall_digging"
_WEIGHT = {"unit_weight": DENSITY * GRAVITY}
CANDIDATES = (
    Hypothesis("as_declared", "the law with laboratory and literature values", {}),
    Hypothesis("friction", "another friction angle", {}, (), ("phi",)),
    Hypothesis("shear_modulus", "another shear modulus", {}, (), ("k",)),
    Hypothesis("wider_contact", "heaped soil widens the contact", {}, (), ("width",)),
    Hypothesis("digging", "sinkage grows with sliding", {}, ("shear", "push")),
    Hypothesis("side_wall", "passive pressure on the side wall", _WEIGHT, (), ("heap",)),
    Hypothesis("side_wall_bare", "side wall without a heap, and digging", _WEIGHT, ("shear", "push")),
    Hypothesis(REFINED, "side wall with its heap, and digging", _WEIGHT, ("shear", "push"), ("heap",)),
)
"""What is tried; phi, the density and the wall's friction are never fitted together with the wall."""


@dataclass(frozen=True)
class OtherWheel:
    """The law with everything fitted on the first wheel, on a second one: name, radius (m), bearing (its own penetration
    tests), baseline and refined side force (N,) per base law, wheel.
    """

    name: str
    wheel: SteadyWheel
    bearing: Bearing
    baseline: Mapping[str, Array]
    refined: Mapping[str, Array]


@dataclass(frozen=True)
class CmuCase:
    """wheel; bearing; judged: base law -> candidate name -> result; repeat: rms of a repeat against the others (N);
    others: second wheels, if any.
    """

    wheel: SteadyWheel
    bearing: Bearing
    judged: Mapping[str, Mapping[str, Judged]]
    repeat: float
    others: tuple[OtherWheel, ...] = ()

    def error(self, base: str, name: str, by: str = "angle", angle: int | None = None) -> float:
        """rms error of the held-out side force (N) of a candidate, by "angle" or "trial"; of one angle where given."""
        left = self.judged[base][name].held[by] - self.wheel.run.f_y
        return rms(left if angle is None else left[self.wheel.angle == angle])

    @property
    def angles(self) -> list[int]:
        """Slip angles (degrees)."""
        return [int(a) for a in np.unique(self.wheel.angle)]

    def as_json(self) -> dict[str, Any]:
        """Content of cmu.json: nothing row by row."""
        bearing = {key: value for key, value in vars(self.bearing).items() if key != "tests"}
        return {
            "bearing": {**bearing, "plates": self.bearing.tests[0], "wheels": self.bearing.tests[1]},
            "repeat_rms": self.repeat,
            "laws": {
                base: {name: self._candidate(base, name) for name in found} for base, found in self.judged.items()
            },
            "others": [
                {
                    "name": other.name,
                    "baseline_rms": {b: rms(f - other.wheel.run.f_y) for b, f in other.baseline.items()},
                    "refined_rms": {b: rms(f - other.wheel.run.f_y) for b, f in other.refined.items()},
                }
                for other in self.others
            ],
        }

    def _candidate(self, base: str, name: str) -> dict[str, Any]:
        found = self.judged[base][name]
        free = (*found.candidate.to_sinkage, *found.candidate.to_force)
        return {
            "doc": found.candidate.doc,
            "parameters": {
                key: {
                    "value": found.values[key],
                    "std": found.std[key],
                    "unit": PARAMETERS[key][3],
                    "at_bound": at_bound(key, found.values[key]),
                }
                for key in free
            },
            "held_out_angle_rms": self.error(base, name),
            "held_out_trial_rms": self.error(base, name, "trial"),
            "per_angle_rms": {str(angle): self.error(base, name, "angle", angle) for angle in self.angles},
            "sinkage_rms": math.nan if self.wheel.run.sinkage is None else rms(found.held_sinkage - self.wheel.run.sinkage),
        }


def run_cmu(
    data: Path,
    judge: Path | None = None,
    grouser: float = 0.0,
    bases: Sequence[str] = BASES,
    candidates: Sequence[Hypothesis] = CANDIDATES,
    progress: Callable[[float], None] = lambda share: None,
) -> CmuCase:
    """The case study on a folder with SINKAGE_FILE and WHEEL_FILE.

    judge: table of a second wheel, predicted with nothing fitted on it but its penetration tests; grouser: height of its
    grousers (m); bases: laws below the wheel; candidates: what is tried; progress: called with the share done.
    Raises ValueError for files that are not there or lack columns.
    """
    tests = read_sinkage_tests(data / SINKAGE_FILE)
    wheel = read_steady_wheel(data / WHEEL_FILE, {})
    bearing = fit_bearing(tests, RADIUS, WIDTH, float(np.median(wheel.run.load)), "wheel_smooth")
    judged: dict[str, dict[str, Judged]] = {}
    count, done = len(bases) * len(candidates), 0
    for base in bases:
        model, judged[base] = _model(wheel, bearing, base), {}
        for candidate in candidates:
            judged[base][candidate.name] = judge_candidate(model, candidate)
            done += 1
            progress(done / count)
    others = (_other(judge, grouser, tests, judged),) if judge else ()
    return CmuCase(wheel, bearing, judged, rms(held_mean(wheel) - wheel.run.f_y), others)


def _model(wheel: SteadyWheel, bearing: Bearing, base: str) -> Ploughs:
    soil = {"k_phi": bearing.k_wheel, "k_c": 0.0, "n": bearing.n, "c": 0.0, "R": 0.0}
    return Ploughs(wheel, soil, law_for(base, [wheel.run]))


def _other(
    path: Path, grouser: float, tests: list[SinkageTest], judged: Mapping[str, Mapping[str, Judged]]
) -> OtherWheel:
    wheel = read_steady_wheel(path, {}, grouser)
    body = "wheel_grouser" if grouser > 0 else "wheel_smooth"
    bearing = fit_bearing(tests, RADIUS + grouser, WIDTH, float(np.median(wheel.run.load)), body)
    models = {base: _model(wheel, bearing, base) for base in judged}
    baseline = {base: model({})[0] for base, model in models.items()}
    refined = {base: model(judged[base][REFINED].values)[0] for base, model in models.items()}
    return OtherWheel(path.stem, wheel, bearing, baseline, refined)
