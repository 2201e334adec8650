"""An identification in sentences: the same on the terminal, in the report and in the vehicle file."""

from __future__ import annotations

import math

from softsoil.estimator.verdict import CHANNEL_WORDS
from softsoil.identification.result import Found, Identification, in_order
from softsoil.refinement.vehicle_numbers import by_name
from softsoil.refinement.words import in_degrees, times_smaller, with_error, with_unit

NO_BETTER = "no better known than before"
"""Of an identified number whose error is that of before the logs."""
FAR = 3.0
"""Standard deviations of what is expected of any vehicle, from which an identified number takes up something else."""
STATES = {"given": "given", "identified": "identified", "not_identifiable": "not identifiable"}
VERDICTS = {
    "identified": "Identified: the logs give the vehicle's numbers",
    "needs_data": "Needs data: do not use this file yet",
    "contradicts_given": "Contradicts given numbers: do not use this file yet",
}
SOIL_VERDICTS = {
    "identified": "Identified: the drives give numbers of the soil",
    "needs_data": VERDICTS["needs_data"],
    "contradicts_given": "Contradicts the class: do not use this file yet",
}
"""Verdicts of `softsoil soil`."""


def verdict_sentence(found: Identification) -> str:
    """The verdict with its reason."""
    return f"{VERDICTS[found.verdict]}. {found.reason}"


def value_words(number: Found) -> str:
    """Value with its standard deviation and unit."""
    return with_unit(number.value, number.std, number.unit)


def state_words(number: Found) -> str:
    """The state; of an identified number what was given, or whether its error is that of before the logs."""
    if number.state == "identified" and number.given is not None:
        return f"identified (given {in_degrees(number.given, number.std, number.unit)[0]:.5g})"
    return f"fitted ({NO_BETTER})" if number.no_better else STATES[number.state]


def error_sentence(found: Identification) -> str:
    """The error that the file makes of every n, and what its numbers leave of the logs."""
    share = 100 * found.vehicle.n_error
    said = f"n by this file has an error of {share:.1f} % in all drives alike (n_error), which every estimate adds to its own."
    shares = found.vehicle.unexplained.items()
    left = " and ".join(f"{100 * share:.1f} % of the {CHANNEL_WORDS[name]}'s" for name, share in shares if share > 0.0)
    return f"{said} Beyond sensor noise the numbers leave at most {left} motion of these logs unexplained." if left else said


def taking_up_sentence(found: Identification) -> str:
    """Which identified numbers' errors are the fit's alone, since a fit moves them also by what the model lacks, those FAR from
    what is expected of any vehicle among them; "" for none."""
    numbers, fitted = by_name(), [name for name in in_order(found.numbers) if found.numbers[name].state == "identified"]
    far = [name for name in fitted if found.numbers[name].given is None and found.numbers[name].departs > FAR]
    names = [name for name in fitted if numbers[name].takes_up or name in far]
    if not names:
        return ""
    words = ", ".join(f"{name} by {found.numbers[name].departs:.1f}" for name in far)
    beyond = f" More than {FAR:g} standard deviations from what is expected of any vehicle: {words}." if far else ""
    return (
        f"These numbers may also have taken up what the model lacks, which their ± does not hold: {', '.join(names)}. "
        f"They serve n and predictions, not a workshop.{beyond}"
    )


def judged_sentences(found: Identification) -> list[str]:
    """n and predictions of the log left out, before and after."""
    judged = found.judged
    (n_0, s_0), (n_1, s_1) = judged.n_before, judged.n_after
    lines = [
        f"{judged.log}, left out of the fit: n {with_error(n_0, s_0)} with the vehicle as its file declares it, "
        f"{with_error(n_1, s_1)} with the identified ones, fitted to its first two thirds with each."
    ]
    ratio, expected = judged.ratio(), judged.ratio(expected=True)
    if ratio is not None and expected is not None:
        lines.append(
            f"Over 2.5 s of its last third the rms error is {times_smaller(math.sqrt(ratio))} than with the file as it is, "
            f"and {times_smaller(math.sqrt(expected))} than with the numbers expected of any such vehicle (geometric mean "
            "over lateral velocity, yaw rate, heading and y; sensor noise in all)."
        )
    return lines
