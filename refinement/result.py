"""Result of a refinement: verdict, effects, contradicted numbers, errors before and after."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.verdict import Verdict
from softsoil.recording.drive import Recording
from softsoil.refinement.ground import FittedGround
from softsoil.refinement.selection import Selection
from softsoil.refinement.structure import Structure
from softsoil.refinement.trace import Bench, Candidate
from softsoil.symbolic.soil import Soil


@dataclass(frozen=True)
class TracedEffect:
    """An effect that the data support: parameters name -> (value, standard error, unit)."""

    name: str
    doc: str
    parameters: dict[str, tuple[float, float, str]]


@dataclass(frozen=True)
class FittedNumber:
    """A number of the vehicle, or a parameter of one of its declared effects, that was fitted beside the ground.

    declared; stated: its standard deviation before the drives; value, std: by the drives and by what is declared together.
    """

    name: str
    unit: str
    declared: float
    stated: float
    value: float
    std: float

    def as_json(self) -> dict[str, Any]:
        """Its entry in refine.json."""
        return {"declared": self.declared, "stated_std": self.stated, "value": self.value, "std": self.std, "unit": self.unit}


@dataclass(frozen=True)
class Refinement:
    """What refine found.

    verdict: "effect", "contradicts_given" (a number of the vehicle, no effect), "none" or "unexplained"; effects: as
    accepted, parameters of the whole drives; contradicted: numbers of the vehicle that the drives contradict; fitted: numbers
    that were free within what is known of them; inseparable: groups that these data cannot separate; would_separate: the
    manoeuvre that would; ranking: all candidates of the first round by their gains; holdout: (from, to) of the first drive (s);
    before, after: horizon -> state -> mean squared error on held-out windows, declared model and refined model, both fitted on
    the fit windows alone; n_before, n_after: by windows with free initial states, with the declared and the refined model, n_std
    of n_after, judged: verdict on n_after, per drive, all empty on hard ground, which ground has: of each class its friction and
    tread; structure: what is left at the end; strain: of the numbers whose joint error the vehicle's file states, about 1 where
    it has not changed; load: share of its mass by which the drives have the vehicle heavier than the refined model, and its
    standard error, None where that carries a load; both None where not looked at;
    declaration: the refined one, by the whole drives, on the soil of the first; bench: the declared model's; selection, its bench
    fitted on the fit windows; recordings: what was used of the drives; soils: class of each; carried: effects that the measured
    inputs are seen to contain; notes; seconds.
    """

    verdict: str
    effects: tuple[TracedEffect, ...]
    contradicted: tuple[FittedNumber, ...]
    fitted: tuple[FittedNumber, ...]
    inseparable: tuple[tuple[str, ...], ...]
    would_separate: str
    ranking: tuple[Candidate, ...]
    holdout: tuple[float, float]
    before: dict[str, dict[str, float]]
    after: dict[str, dict[str, float]]
    n_before: tuple[float, ...]
    n_after: tuple[float, ...]
    n_std: tuple[float, ...]
    judged: tuple[Verdict, ...]
    ground: tuple[FittedGround, ...]
    structure: tuple[Structure, ...]
    strain: float | None
    load: tuple[float, float] | None
    declaration: Declaration
    bench: Bench
    selection: Selection
    recordings: tuple[Recording, ...]
    soils: tuple[Soil, ...]
    seconds: float
    carried: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def unknown(self) -> str:
        """What is fitted of the ground beside everything else."""
        return "friction and tread" if self.ground else "n"

    def as_json(self) -> dict[str, Any]:
        """The content of refine.json."""
        effects = [
            {
                "name": e.name,
                "parameters": {k: {"value": v, "std": s, "unit": unit} for k, (v, s, unit) in e.parameters.items()},
            }
            for e in self.effects
        ]
        return {
            "verdict": self.verdict,
            "effects": effects,
            "contradicted": {number.name: number.as_json() for number in self.contradicted},
            "fitted": {number.name: number.as_json() for number in self.fitted},
            "inseparable": [list(group) for group in self.inseparable],
            "would_separate": self.would_separate,
            "ranking": [{"name": c.name, "holdout_gain": c.gain, "std": c.std} for c in self.ranking],
            "holdout": {"from": self.holdout[0], "to": self.holdout[1]},
            "before": {"mse": self.before},
            "after": {"mse": self.after},
            **self._ground(),
            "unexplained": [{"share": s.share, "correlations": s.correlations} for s in self.structure],
            "strain": self.strain,
            "load": self.load and {"share": self.load[0], "std": self.load[1]},
            "notes": list(self.notes),
            "seconds": self.seconds,
        }

    def _ground(self) -> dict[str, Any]:
        if self.ground:
            return {"ground": [ground.as_json() for ground in self.ground]}
        n = {
            "before": list(self.n_before),
            "after": list(self.n_after),
            "std": list(self.n_std),
            "verdict": [verdict.word for verdict in self.judged],
            "reason": [verdict.reason for verdict in self.judged],
            "soil": [soil.name for soil in self.soils],
        }
        return {"n": n}
