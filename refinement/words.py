"""A refinement's result in sentences: the same on the terminal and in the report."""

from __future__ import annotations

import math
from collections.abc import Sequence

from softsoil.estimator.verdict import IDENTIFIED
from softsoil.refinement.result import FittedNumber, Refinement, TracedEffect
from softsoil.refinement.trace import Candidate
from softsoil.refinement.vehicle_numbers import KINDS_OF_GROUND

JUDGED_STATES = ("v", "omega_z", "psi", "y")
JUDGED_HORIZON = "2.5"
OF_THE_SPEED = 1.5
"""Times as much as the lateral channels from which on the speed's held-out error, which falls with a drag, is spoken of."""


def verdict_sentence(found: Refinement) -> str:
    """The verdict with what it means."""
    if found.verdict == "effect":
        names = " and ".join(effect_name(e.name) for e in found.effects)
        wrong = f" They contradict the vehicle's {_numbers(found)}." if found.contradicted else ""
        return f"Effect: beyond the declared model the data support {names}.{wrong}"
    if found.verdict == "contradicts_given":
        if all(number.name in KINDS_OF_GROUND for number in found.contradicted):
            return (
                "Contradicts the vehicle file: the data support no effect, but ground of the other kind than declared "
                f"({_numbers(found)}); take the refined file on it."
            )
        return (
            f"Contradicts the vehicle file: the data support no effect, but another {_numbers(found)} than declared; measure "
            "it again, or identify the vehicle anew."
        )
    if found.verdict == "none":
        if any(one.word == "inconsistent" for one in found.judged):
            return (
                "None: no effect is missing that these data could show, but a verdict on n says that declared model and drive do "
                "not fit: mend what it names."
            )
        if any(s.left for s in found.structure):
            return (
                "None: no effect is named and the vehicle's numbers are not strained, but more is left in the axle forces than a "
                "good model leaves, by kicks and noise or by what is too small for these data to tell: longer drives show more."
            )
        return "None: nothing is missing that these data could show; the declared model stands."
    if found.selection.unnamable:
        names = " or ".join(map(effect_name, found.selection.unnamable))
        return (
            f"Unexplained: what is left looks like {names}, which rests on channels that these data do not measure, so that "
            "nothing is named; the declared model stands."
        )
    if found.selection.undecided:
        return (
            f"Unexplained: {either(found.selection.undecided)} explains what is left on data that it was not fitted to; these "
            "data cannot tell which, so that nothing is named, and the declared model stands."
        )
    left = "more is left in the axle forces than a good model leaves"
    if found.strain is not None or any(one.word == "inconsistent" for one in found.judged):
        left = "the drives contradict the vehicle's file or their own channels, as the verdicts on n say"
    elif not any(s.left for s in found.structure):
        left = "something is missing, as the notes and the verdicts on n say"
    return (
        f"Unexplained: {left}, but no entry of the catalogue explains it on data that it was not fitted to; the declared "
        "model stands."
    )


def either(names: Sequence[str]) -> str:
    """Effects by their names, one of which it is."""
    *first, last = map(effect_name, names)
    return f"{', '.join(first)} or {last}" if first else last


def _numbers(found: Refinement) -> str:
    return " and ".join(number.name for number in found.contradicted)


def number_words(number: FittedNumber) -> str:
    """yaw_inertia: declared 2560 ± 130, by the drives 1880 ± 30 kg m²."""
    declared = with_error(*in_degrees(number.declared, number.stated, number.unit)[:2])
    return f"{number.name}: declared {declared}, by the drives {with_unit(number.value, number.std, number.unit)}"


def n_sentences(found: Refinement) -> list[str]:
    """Per drive the verdict on n, then n, and n with the declared model where that was refined; none on hard ground."""
    if found.ground:
        return []
    names = [shooting.drive.name for shooting in found.bench.shootings]
    entries = zip(names, found.soils, found.judged, found.n_before, found.n_after, found.n_std, strict=True)
    return [
        f"{name} on {soil.name}: n {effect_name(verdict.word)}: {verdict.reason}"
        f"{'' if verdict.usable else '; do not use this n'}: "
        f"{with_error(after, std)}"
        + (f" with the refined model, {before:.3f} with the declared" if found.effects or found.contradicted else "")
        for name, soil, verdict, before, after, std in entries
    ]


def ground_sentences(found: Refinement) -> list[str]:
    """Per class of hard ground, the verdicts on friction and tread and then their values."""
    return [
        f"{ground.name}: {n.name} {effect_name(n.word)}: {n.reason}{'' if n.word == IDENTIFIED else '; do not use it'}: "
        f"{with_unit(n.value, n.std, n.unit)} with the refined model, {n.before:.3g} with the declared"
        for ground in found.ground
        for n in ground.numbers
    ]


def soil_sentences(found: Refinement) -> list[str]:
    """On which soil the refined model stands where the drives had several."""
    if len({soil.name for soil in found.soils}) < 2:
        return []
    return [f"The ground is that of {found.recordings[0].name}; with another one, use this file as --vehicle beside --soil."]


def effect_name(name: str) -> str:
    """steering_offset -> steering offset."""
    return name.replace("_", " ")


def parameter_words(effect: TracedEffect) -> list[str]:
    """Each parameter with its standard error and unit."""
    return [f"{name} = {with_unit(*size)}" for name, size in effect.parameters.items()]


def in_degrees(value: float, std: float, unit: str) -> tuple[float, float, str]:
    """A value (in `unit`) and its standard error std as a person reads them: radians become degrees, m^2 m²."""
    shown = unit.replace("^2", "²").replace("^3", "³")
    if unit.startswith("rad"):
        return math.degrees(value), math.degrees(std), shown.replace("rad", "deg", 1)
    return value, std, shown


def with_unit(value: float, std: float, unit: str) -> str:
    """value ± std (in `unit`) with its unit, angles in degrees."""
    shown, error, words = in_degrees(value, std, unit)
    return f"{with_error(shown, error)} {words}".rstrip()


def with_error(value: float, std: float) -> str:
    """value ± std, with as many digits as the error leaves: two of the error's."""
    if not (math.isfinite(std) and std > 0):
        return f"{value:.4g}"
    digits = max(0, 1 - math.floor(math.log10(std)))
    return f"{value:.{digits}f} ± {std:.{digits}f}"


def falls(found: Refinement) -> float | None:
    """By how much the held-out MSE at 2.5 s falls, geometric mean over v, omega_z, psi and y; None without windows."""
    before, after = found.before.get(JUDGED_HORIZON, {}), found.after.get(JUDGED_HORIZON, {})
    ratios = [
        before[s] / after[s] for s in JUDGED_STATES if s in before and after.get(s, 0.0) > 0.0 and before[s] > 0.0
    ]
    if len(ratios) < len(JUDGED_STATES) or not all(map(math.isfinite, ratios)):
        return None
    return math.exp(sum(map(math.log, ratios)) / len(ratios))


def falls_sentence(found: Refinement) -> str:
    """The change of the held-out error in one sentence; empty where there is none to say."""
    ratio = falls(found)
    if ratio is None or not (found.effects or found.contradicted):
        return ""
    before, after = found.before[JUDGED_HORIZON], found.after[JUDGED_HORIZON]
    own = math.sqrt(before["u"] / after["u"]) if before.get("u", 0.0) > 0.0 and after.get("u", 0.0) > 0.0 else 0.0
    speed = f"; of the speed {own:.3g} times" if own > OF_THE_SPEED * max(math.sqrt(ratio), 1.0) else ""
    return (
        f"Held-out rms error at {JUDGED_HORIZON} s: {times_smaller(math.sqrt(ratio))} with the refined model "
        f"(geometric mean of lateral velocity, yaw rate, heading and y{speed})."
    )


def bound_words(candidate: Candidate) -> str:
    """Which of a candidate's parameters ended on a bound; n of any drive as n."""
    names = ["n" if name.startswith("n_") and name[2:].isdigit() else name for name in candidate.fit.at_bound]
    return f"{', '.join(dict.fromkeys(names))} at a bound" if names else ""


def split_sentence(found: Refinement) -> str:
    """Which part was fitted and which part judged, and what the parameters are from."""
    start, stop = found.holdout
    first = found.bench.shootings[0]
    rows = first.drive.first
    begin = float(first.drive.t[rows])
    more = (
        "" if len(found.bench.shootings) == 1 else f" (first drive; all {len(found.bench.shootings)} are split alike)"
    )
    last = " The parameters are from a fit to all of it, after that." if found.effects or found.contradicted else ""
    return (
        f"Fitted on {begin:.1f} to {start:.1f} s, judged on {start:.1f} to {stop:.1f} s, which that fit has not seen{more}."
        f"{last}"
    )


def group_sentences(found: Refinement) -> list[str]:
    """What the data cannot separate, and what would."""
    lines = [f"These data cannot separate: {', '.join(map(effect_name, group))}." for group in found.inseparable]
    return [*lines, f"To separate: {found.would_separate}."] if found.would_separate else lines


def left_sentences(found: Refinement) -> list[str]:
    """Per drive, the share of the axle forces that is left, and its strongest correlation."""
    lines = []
    for shooting, left in zip(found.bench.shootings, found.structure, strict=True):
        parts = []
        for axle, share in left.share.items():
            name, value = next(iter(left.correlations[axle].items()), ("", 0.0))
            with_ = f", correlated with {effect_name(name)} ({value:+.2f})" if abs(value) >= 0.5 else ""
            parts.append(f"{axle} axle {100 * share:.0f} %{with_}" if math.isfinite(share) else f"{axle} axle not judged")
        lines.append(f"{shooting.drive.name}: lateral force left unexplained: {'; '.join(parts)}")
    return lines


def number(value: float) -> str:
    """`value` with three digits, or a dash where it is not known."""
    return f"{value:.3g}" if math.isfinite(value) else "-"


def times_smaller(ratio: float) -> str:
    """How an error changed that is `ratio` times smaller."""
    return f"{ratio:.3g} times smaller" if ratio >= 1.0 else f"{1.0 / ratio:.3g} times larger" if ratio > 0.0 else "unbounded"


def ratio(before: float, after: float) -> str:
    """`before` over `after`, or a dash."""
    return f"{before / after:.2f}" if math.isfinite(before) and math.isfinite(after) and after > 0 else "-"
