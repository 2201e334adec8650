"""report.html of a soil's numbers: one file with its pictures inside."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path

from softsoil.estimator.verdict import CHANNEL_WORDS
from softsoil.figures.error_bars import draw_errors
from softsoil.figures.error_table import rms_table
from softsoil.figures.labels import plain
from softsoil.figures.numbers import draw_numbers
from softsoil.figures.page_html import figure, items, paragraph, provenance, row, section, table, words, write_page
from softsoil.identification.soil_numbers import SoilIdentification
from softsoil.identification.words import SOIL_VERDICTS, STATES
from softsoil.refinement.words import with_error, with_unit
from softsoil.symbolic.soil import SOIL_SIGNALS


def write_report(result: SoilIdentification, path: Path, about: Mapping[str, Mapping[str, str]]) -> Path:
    """Write the report and return its path; about: software and vehicle."""
    name = plain(result.soil.name)
    kind = "" if result.verdict == "identified" else "unexplained"
    before, after = result.before, result.after
    parts = [
        f'<h1>The numbers of {escape(name)} from drives</h1><p class="sub">{escape(", ".join(result.n))}</p>'
        f'<div class="verdict {kind}">{paragraph(f"{SOIL_VERDICTS[result.verdict]}. {result.reason}")}</div>',
        section("Numbers", _numbers(result), figure(lambda p: draw_numbers(result.numbers, p), NUMBERS_CAPTION, "narrow")),
        section("Sinkage exponents", _n(result)),
        section(
            "Predictions", paragraph("Rms errors over the last third of each drive, before and after."), rms_table(before, after),
            figure(lambda p: draw_errors("The last thirds", before, after, p), ERRORS_CAPTION),
        ),
        section("What was done", items(DONE)),
        section("Provenance", provenance(about)),
    ]  # fmt: skip
    return write_page(path, f"softsoil soil: {name}", parts)


NUMBERS_CAPTION = (
    "Grey bars: what the soil's file states, with its error. A number whose standard deviation the drives hardly reduce is not "
    "identifiable: it stays as stated."
)
ERRORS_CAPTION = (
    "Before: n alone fitted to the first two thirds of each drive, with the class as given. After: the soil's numbers, too."
)
DONE = (
    "The soil's numbers were fitted within the errors that its file states, the vehicle's within their joint error, each drive "
    "with its own n, on windows of one second whose initial states are free. What is known beforehand counts as one observation.",
    "The frictional modulus and n press alike: where a file states an error of k_phi, n holds it.",
    "Only sensor channels were read. The soil is soil.toml: give it to any command by --soil.",
)


def _numbers(result: SoilIdentification) -> str:
    rows = [row(["number", "value ± std", "state", "given", "departs by", "what it is"], " r rr ", "th")]
    for name, one in result.numbers.items():
        cells = [f"<code>{escape(name)}</code>", words(with_unit(one.value, one.std, one.unit)), STATES[one.state]]
        cells += [words(with_unit(one.given, one.given_std, one.unit)), f"{one.departs:.1f} std"]
        rows.append(row([*cells, escape(SOIL_SIGNALS[name].doc)], " r rr "))
    return table(rows)


def _n(result: SoilIdentification) -> str:
    shares = {one.log: one.share for one in result.unexplained}
    rows = [row(["log", "n ± std", "with the class as given", "motion left unexplained"], " rrr", "th")]
    for log, value in result.n.items():
        left = ", ".join(f"{CHANNEL_WORDS[name]} {100 * share:.1f} %" for name, share in shares[log].items() if share > 0.0)
        rows.append(row([escape(log), with_error(*value), with_error(*result.n_before[log]), left or "none"], " rrr"))
    return table(rows)
