"""The tracing's rules with numbers: each with its unit, meaning and where its evidence is printed."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

EVIDENCE = {
    "reference": "python -m benchmarks.tracing_evidence reference",
    "blind": "softsoil blind-test --drives 40 --seed SEED",
    "places": "python benchmarks/soil_change_evidence.py clean SEED ...",
    "drawn": "python -m benchmarks.identify_plant --effects --logs multi,lock",
    "design": "a choice of the method: no drive decides it",
}
"""Where the evidence of a rule comes from."""


@dataclass(frozen=True)
class Rule:
    """One rule: name, value, unit, what it asks, and keys of EVIDENCE."""

    name: str
    value: Any
    unit: str
    meaning: str
    evidence: tuple[str, ...]


def _rule(value: Any, unit: str, meaning: str, evidence: str) -> Any:
    return field(default=value, metadata={"rule": (unit, meaning, tuple(evidence.split(", ")))})


@dataclass(frozen=True)
class Rules:
    """The rules; `table` says what each of them is."""

    least_gain: float = _rule(
        0.2, "share",
        "held-out cost beyond sensor noise an effect must remove: the model's own error lets any flexible term gain some",
        "reference, blind",
    )  # fmt: skip
    later_gain: float = _rule(
        0.35, "share",
        "of what the first effect has left, for a second: the smaller the rest, the more of it is the model's own error",
        "blind",
    )  # fmt: skip
    least_whole: float = _rule(
        0.15, "share",
        "whole held-out cost, noise and all, that an effect must remove: less would not show in what the model predicts",
        "blind",
    )  # fmt: skip
    least_whole_apart: float = _rule(
        0.08, "share",
        "the same for an effect of the outputs alone or of a place: nothing that a force law's own error looks like",
        "blind",
    )  # fmt: skip
    one_wave_gain: float = _rule(
        0.5, "share",
        "gain that a first effect needs where the steering repeats one wave: few ways of moving make any two effects alike",
        "reference",
    )  # fmt: skip
    least_size: float = _rule(
        0.05, "share of spread",
        "size that an effect must reach: every declared model has a fault of smaller size, and without noise it stands out",
        "reference",
    )  # fmt: skip
    chance: float = _rule(
        0.05, "probability",
        "of reaching a gain by the scatter of the held-out windows alone (Student's t)",
        "design",
    )  # fmt: skip
    least_parameter_sigmas: float = _rule(
        3.0, "standard errors",
        "of the leading parameter from absence, unless the held-out windows alone leave no doubt",
        "design",
    )  # fmt: skip
    beyond_doubt: float = _rule(
        0.0004, "probability",
        "of a gain by scatter alone that over all candidates makes one per cent",
        "design",
    )  # fmt: skip
    place_sigmas: float = _rule(
        4.5, "standard errors",
        "from absence, of a change at a place in a fit to the whole drive, that need no size of gain",
        "places",
    )  # fmt: skip
    look_gain: float = _rule(
        0.1, "share",
        "gain at which an effect is looked at again by windows with free starts, where none has been named",
        "design",
    )  # fmt: skip
    look_error: float = _rule(
        2.0, "standard errors",
        "of windows with free starts that make one: the model's own error is alike in all of them, as identify takes it",
        "drawn",
    )  # fmt: skip
    look_sigmas: float = _rule(
        4.5, "standard errors",
        "of an effect in such windows, the vehicle's numbers free by their joint error: its parameter's from absence, or, with "
        "strained numbers, the root of the squares that it removes",
        "drawn",
    )  # fmt: skip
    there_sigmas: float = _rule(
        2.0, "standard errors",
        "from absence in such windows, of an effect that has been named without them",
        "drawn",
    )  # fmt: skip
    look_rival: float = _rule(
        0.5, "share",
        "of the squares that the best effect removes there, of which another one makes both inseparable",
        "design",
    )  # fmt: skip
    strain: float = _rule(
        7.0, "times what is expected",
        "squares by which drives move the vehicle's numbers in their joint error, that say the vehicle has changed",
        "drawn",
    )  # fmt: skip
    unsettled_toe: float = _rule(
        0.02, "rad",
        "standard deviation of the rear toe by which a load may change it: springs give way, and links turn the wheels",
        "drawn",
    )  # fmt: skip
    most_effects: int = _rule(
        3, "effects",
        "accepted on one set of drives",
        "design",
    )  # fmt: skip
    most_alike: int = _rule(
        2, "effects",
        "that explain the data alike, of more than which none is named",
        "design",
    )  # fmt: skip
    contenders: int = _rule(
        5, "effects",
        "best over all windows that are judged on the whole drive",
        "design",
    )  # fmt: skip
    contender: float = _rule(
        0.04, "share",
        "cost of all windows that a contender's first fit must remove",
        "design",
    )  # fmt: skip
    second_look: int = _rule(
        8, "effects",
        "of the first ranking that are looked at again once one has been accepted",
        "design",
    )  # fmt: skip
    like_gain: float = _rule(
        0.03, "share",
        "difference of held-out costs below which two effects cannot be separated",
        "design",
    )  # fmt: skip
    nearly_all: float = _rule(
        0.75, "share",
        "held-out cost whose removal leaves no doubt; with an effect that the catalogue lacks none removed more than half",
        "blind",
    )  # fmt: skip
    horizon: float = _rule(
        2.0, "s",
        "windows of the tracing: long against the vehicle's lateral dynamics, short enough for many of them",
        "design",
    )  # fmt: skip
    fit_share: float = _rule(
        2 / 3, "share",
        "first part of a drive, which is fitted; the rest judges",
        "design",
    )  # fmt: skip
    least_sigma: float = _rule(
        0.5, "standard deviations",
        "of the sensor noise that a channel's weight is at least",
        "design",
    )  # fmt: skip
    least_doubt: float = _rule(
        0.1, "share of what is left",
        "by which one standard deviation of a declared number moves the predictions for it to be free beside n",
        "design",
    )  # fmt: skip
    contradicted: float = _rule(
        3.0, "standard deviations",
        "of drives and vehicle file together, beyond which a declared number is a candidate in the place of effects",
        "design",
    )  # fmt: skip
    least_beyond: float = _rule(
        0.2, "share",
        "cost that counts as beyond noise at least: the noise of the sensors is not known better",
        "design",
    )  # fmt: skip
    largest_share: float = _rule(
        0.27, "share",
        "of an axle's lateral force that a good model may leave unexplained over half-second windows, noise taken off",
        "reference",
    )  # fmt: skip
    strong: float = _rule(
        0.5, "",
        "correlation that is worth naming",
        "design",
    )  # fmt: skip
    place_sizes: tuple[float, ...] = _rule(
        (0.1, -0.1), "of the leading parameter",
        "that a change at a place is tried with",
        "design",
    )  # fmt: skip
    places: int = _rule(
        6, "places",
        "along the fitted part of a drive; the best is searched again on both sides, a third of the way to the next",
        "design",
    )  # fmt: skip
    folds: int = _rule(
        3, "",
        "turns in which windows are held out",
        "design",
    )  # fmt: skip
    one_wave: float = _rule(
        0.8, "share",
        "of the steering's variance in one line of its spectrum beyond which a drive repeats one wave",
        "reference",
    )  # fmt: skip
    lines: int = _rule(
        1, "lines",
        "to either side of the strongest that belong to it",
        "design",
    )  # fmt: skip
    turning: float = _rule(
        0.1, "rad/s",
        "yaw rate below which a turn says nothing of the differentials",
        "design",
    )  # fmt: skip
    fewest_rows: int = _rule(
        50, "rows",
        "in turns that say something of the differentials",
        "design",
    )  # fmt: skip
    averaged: float = _rule(
        0.25, "s",
        "over which speed differences are averaged: sensor noise goes, a turn stays",
        "design",
    )  # fmt: skip
    locked: float = _rule(
        0.15, "share",
        "of the freely rolling wheels' speed difference below which the wheels of an axle turn together",
        "reference",
    )  # fmt: skip
    open: float = _rule(
        0.25, "share",
        "of it beyond which they turn freely; on soft soil open differentials are far from rolling freely",
        "reference",
    )  # fmt: skip

    def table(self) -> tuple[Rule, ...]:
        """Every rule with its value, unit, meaning and evidence."""
        return tuple(Rule(f.name, getattr(self, f.name), *f.metadata["rule"]) for f in fields(self))


RULES = Rules()
