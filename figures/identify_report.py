"""report.html of an identification: one file with its pictures inside."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path

from softsoil.figures.error_bars import draw_errors
from softsoil.figures.error_table import rms_table
from softsoil.figures.identify import draw_costs
from softsoil.figures.labels import per_cent
from softsoil.figures.numbers import draw_numbers
from softsoil.figures.page_html import figure, items, paragraph, provenance, row, section, table, words, write_page
from softsoil.identification.result import Identification, in_order
from softsoil.identification.words import (
    error_sentence,
    judged_sentences,
    state_words,
    taking_up_sentence,
    verdict_sentence,
)
from softsoil.refinement.vehicle_numbers import by_name
from softsoil.refinement.words import in_degrees, with_error

KINDS = {"identified": "", "needs_data": "unexplained", "contradicts_given": "unexplained"}
"""Verdict -> style of its box."""


def write_report(result: Identification, path: Path, about: Mapping[str, Mapping[str, str]]) -> Path:
    """Write the report and return its path; about: software and vehicle."""
    logs, ordered = ", ".join(result.n), {name: result.numbers[name] for name in in_order(result.numbers)}
    lines = (verdict_sentence(result), *(f"Next: {ask}." for ask in result.asks))
    inside = "".join(paragraph(line) for line in lines)
    errors = paragraph("Rms errors.") + rms_table(result.judged.before, result.judged.after)
    parts = [
        f'<h1>The numbers of {escape(result.vehicle.name)} from its logs</h1><p class="sub">{escape(logs)}</p>'
        f'<div class="verdict {KINDS[result.verdict]}">{inside}</div>',
        section("Numbers", _numbers(result), figure(lambda p: draw_numbers(ordered, p), NUMBERS_CAPTION)),
        section("What they cost n", figure(lambda p: draw_costs(result, p), COSTS_CAPTION, "narrow")),
        section("Sinkage exponents", _soils(result), paragraph(error_sentence(result))),
        section("The log left out", *map(paragraph, judged_sentences(result)), errors, _pictures(result)),
        section("What was done", items(DONE)),
        section("Notes", items(result.notes)) if result.notes else "",
        section("Provenance", provenance(about)),
    ]
    return write_page(path, f"softsoil identify: {result.vehicle.name}", parts)


NUMBERS_CAPTION = (
    "Grey bars: what was expected before the logs, as given with the error of measuring it or as of any vehicle. A number whose "
    "error the logs hardly reduce is not identifiable: it stays as expected. Fitted is one that moves with the others though its "
    "error, by stretches left out, is no smaller than before."
)
COSTS_CAPTION = (
    "Change of n when one number is wrong by its standard deviation and all others are right; the largest over the logs."
)
DONE = (
    "All numbers were fitted jointly, each log with its own n, on windows of one second whose initial states are free, with the "
    "balances that measured wheel speeds must keep beside them. What is known beforehand counts as one observation.",
    "Standard errors: stretches of the logs left out in turn (jackknife) with every number free, widened by what a force law "
    "misses.",
    "The distance of centre of gravity and front axle was compared with position against course, which needs no force law.",
    "Only sensor channels were read. The vehicle is vehicle.toml: give it to any command by --vehicle.",
)


def _numbers(result: Identification) -> str:
    heads = ["number", "value ± std", "unit", "state", "n per std", "expected before", "what it is, and why that was expected"]
    rows = [row(heads, " r  rr ", "th")]
    for name in in_order(result.numbers):
        one, known = result.numbers[name], by_name()[name]
        why = known.how if one.given is not None else known.why
        value, std, unit = in_degrees(one.value, one.std, one.unit)
        cells = [f"<code>{escape(name)}</code>", with_error(value, std), unit, escape(state_words(one))]
        cells += [per_cent(0.01 * one.n_percent_per_std, 1, "+"), with_error(*in_degrees(*one.before, one.unit)[:2])]
        rows.append(row([*cells, words(f"{known.doc}; {why}".rstrip("; "))], " r  rr "))
    taking_up = taking_up_sentence(result)
    return table(rows) + (paragraph(taking_up) if taking_up else "")


def _soils(result: Identification) -> str:
    rows = [row(["log", "n ± std", ""], " r ", "th")]
    for log, (value, std) in result.n.items():
        rows.append(row([escape(log), with_error(value, std), "judges" if log == result.judged.log else "fitted"], " r "))
    return table(rows)


def _pictures(result: Identification) -> str:
    one = result.judged
    caption = "Windows side by side over the last third of the log, from recorded states."
    return figure(lambda p: draw_errors(one.log, one.before, one.after, p), caption)
