"""The numbers of the C library's moving horizon: those of the Python classes."""

from __future__ import annotations

from dataclasses import fields

from softsoil.codegen.c_library.horizon import HorizonNumbers
from softsoil.codegen.predictor import LONGEST_STEP
from softsoil.estimator.evidence import TRIMMED
from softsoil.estimator.horizons import START_UP
from softsoil.estimator.late_change import LEAST_PART, SPLITS
from softsoil.estimator.moving_horizon import SCALE, HorizonRules
from softsoil.estimator.soil_error import LAW_ERROR
from softsoil.estimator.summary import LEAST_CURVATURE
from softsoil.estimator.tuning import common_error
from softsoil.estimator.verdict import WORDS
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.recording.clock import FINE_STEP, SLOWEST_STEP
from softsoil.recording.forward import HELD_INPUTS
from softsoil.symbolic.model import Model
from softsoil.symbolic.vehicle import JUDGED
from softsoil.windows.free_windows import BRIDGED, FREE_STEP, SETTLING, STATE_STEP
from softsoil.windows.shooting import SMOOTHING
from softsoil.windows.window_fit import HUBER, RIDGE

FROM_ZERO = ("not_excited", *(word for word in WORDS if word != "not_excited"))
"""Verdicts in the order of C's numbers: a horizon that never began, all zeros, is not identified."""
SENTENCES = {
    "identified": "the windows determine n, and the model leaves no more than a right one does",
    "not_excited": "the windows do not determine n, or a small error of the forces, or a load, may make it wrong: steer more, to "
    "and fro, at several speeds, longer",
    "depends_on_first_guess": "n depends on its initial guess: drive on",
    "at_bound": "n is at a bound of its range: check soil and vehicle",
    "axles_disagree": "front and rear axle disagree on n",
    "inconsistent": "the windows contradict the model, the vehicle's numbers or one soil: check vehicle, soil and sensors",
    "no_soil": "there is no soft soil",
}


def horizon_numbers(model: Model, rules: HorizonRules | None = None, limits: VerdictRules | None = None) -> HorizonNumbers:
    """The numbers of rules and limits for a model, as the generator takes them."""
    rules, limits = rules or HorizonRules(), (limits or VerdictRules()).of(model)
    limit_of = dict(limits.unexplained)
    own = {field.name: getattr(rules, field.name) for field in fields(rules)}
    own["common_error"] = common_error(rules.common_error, model)
    own |= {"flat_error": rules.common_error, "law_error": LAW_ERROR}
    bounds = {field.name: getattr(limits, field.name) for field in fields(limits)}
    return HorizonNumbers(
        rules={
            **{name: float(value) for name, value in own.items() if name not in ("model_error", "recent")},
            "settling": SETTLING, "bridged": BRIDGED, "held_inputs": HELD_INPUTS, "smoothing": SMOOTHING, "start_up": START_UP,
            "slowest_step": SLOWEST_STEP, "fine_step": FINE_STEP,
        },
        model_error=rules.model_error, recent=rules.recent,
        limits={name: float(value) for name, value in bounds.items() if name not in ("unexplained", "contradicted")},
        unexplained=[limit_of[name] for name in JUDGED], splits=SPLITS, least_part=LEAST_PART,
        constants={
            "longest_step": LONGEST_STEP, "huber": HUBER, "ridge": RIDGE, "least_curvature": LEAST_CURVATURE,
            "free_step": FREE_STEP, "trimmed": TRIMMED,
        },
        state_step=[float(step) for step in STATE_STEP], verdicts=[(word, SENTENCES[word]) for word in FROM_ZERO], scale=SCALE,
    )  # fmt: skip
