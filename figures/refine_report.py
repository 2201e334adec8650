"""report.html of a refinement: one file with its pictures inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from softsoil.declaration.model_file import Declaration
from softsoil.figures.page_html import figure, items, paragraph, provenance, row, section, write_page
from softsoil.figures.refine import draw_axles, draw_paths, draw_ranking
from softsoil.figures.refine_views import DriveView, drive_views
from softsoil.recording.drive import CHANNEL_UNITS, STATE_CHANNELS
from softsoil.refinement.result import Refinement
from softsoil.refinement.rules import RULES
from softsoil.refinement.words import (
    effect_name,
    falls_sentence,
    group_sentences,
    number,
    ratio,
    split_sentence,
    verdict_sentence,
    with_error,
)
from softsoil.symbolic.catalogue import catalogue


def write_report(
    declared: Declaration, found: Refinement, start: float, path: Path, about: Mapping[str, Mapping[str, str]]
) -> Path:
    """Write the report of what `refine` found and return its path.

    declared, start: as given to `refine`; about: provenance, software (version, command) and vehicle (name, file).
    """
    views = drive_views(found, start)
    names = ", ".join(view.name for view in views)
    parts = [
        _head(names, declared, found),
        section("Parameters", _parameters(declared, found)),
        section("Residual, before and after", *(_axles(view) for view in views)),
        section("Candidates", _ranking(found)),
        section("Held-out predictions", *(_paths(view) for view in views), _errors(found)),
        section("What is left", _left(views)),
        section("What was done", _done(declared, found)),
        section("Notes", items(found.notes)) if found.notes else "",
        section("Provenance", provenance(about)),
    ]
    title = f"softsoil refine: {names}"
    return write_page(path, title, parts)


def _head(names: str, declared: Declaration, found: Refinement) -> str:
    lines = [verdict_sentence(found), falls_sentence(found), *group_sentences(found)]
    inside = "".join(paragraph(line) for line in lines if line)
    effects = ", ".join(declared.vehicle.effects) or "none"
    sub = f"{declared.vehicle.name} on {declared.soil.name}, force law {declared.law}, declared effects: {effects}"
    return (
        f'<h1>What the model lacks: {escape(names)}</h1><p class="sub">{escape(sub)}</p>'
        f'<div class="verdict {found.verdict}">{inside}</div>'
    )


def _parameters(declared: Declaration, found: Refinement) -> str:
    rows = []
    for effect in found.effects:
        for name, (value, std, unit) in effect.parameters.items():
            cells = [escape(effect_name(effect.name)), f"<code>{escape(name)}</code>", with_error(value, std), unit]
            rows.append(row([*cells, escape(_doc(declared, effect.name, name))], "  r  "))
    for number_ in (*found.contradicted, *found.fitted):
        state = "contradicts the vehicle file" if number_ in found.contradicted else "fitted beside n"
        words = f"{state}; declared {with_error(number_.declared, number_.stated)}"
        cells = ["vehicle", f"<code>{escape(number_.name)}</code>", with_error(number_.value, number_.std), number_.unit]
        rows.append(row([*cells, escape(words)], "  r  "))
    if len(found.bench.shootings) == len(found.n_after):
        drives = zip(found.bench.shootings, found.n_before, found.n_after, found.n_std, found.judged, strict=True)
        for shooting, before, after, std, verdict in drives:
            words = f"sinkage exponent, {shooting.drive.name}, {verdict.word}; {before:.3f} with the declared model"
            rows.append(row(["soil", "<code>n</code>", with_error(after, std), "", escape(words)], "  r  "))
    head = row(["effect", "parameter", "value ± std, whole drive", "unit", "what it is"], "  r  ", "th")
    return f"<table>{head}{''.join(rows)}</table>"


def _doc(declared: Declaration, effect: str, name: str) -> str:
    known = catalogue(declared.vehicle)[effect]
    signals = [*known.parameters, *([known.derived] if known.derived else [])]
    return next(signal.doc for signal in signals if signal.name == name)


def _axles(view: DriveView) -> str:
    caption = (
        "The model's accelerations are integrated along the recorded states; what the record departs from that, per window, "
        "is split over the axles. Right: against the signal that the declared model's residual goes with most."
    )
    return figure(lambda path: draw_axles(view, path), caption)


def _ranking(found: Refinement) -> str:
    caption = (
        f"Each effect alone, fitted together with n. An effect is named if it removes at least {100 * RULES.least_gain:.0f} % of "
        f"the held-out cost beyond sensor noise, if windows that gain nothing would not show as much ({100 * RULES.chance:g} %), "
        f"and if its parameter stands {RULES.least_parameter_sigmas:g} standard errors from absence (or those windows leave no "
        f"doubt) and not at a bound; a change at a place also if it stands {RULES.place_sigmas:g} of them from absence in a fit "
        "to the whole drive."
    )
    return figure(lambda path: draw_ranking(found, path), caption, "narrow")


def _paths(view: DriveView) -> str:
    return figure(lambda path: draw_paths(view, path), "Windows side by side over the part of the drive that judges.")


def _errors(found: Refinement) -> str:
    horizons = list(found.before)
    first = [
        '<th rowspan="2">state, unit of its square</th>',
        *(f'<th class="r" colspan="3">{h} s</th>' for h in horizons),
    ]
    second = '<th class="r">before</th><th class="r">after</th><th class="r">ratio</th>' * len(horizons)
    rows = [f"<tr>{''.join(first)}</tr><tr>{second}</tr>"]
    for state in STATE_CHANNELS:
        cells = [f"<td>{state} <span class='sub'>({CHANNEL_UNITS[state]})²</span></td>"]
        for horizon in horizons:
            before, after = found.before[horizon][state], found.after[horizon][state]
            mark = "better" if after < 0.95 * before else ("worse" if after > 1.05 * before else "")
            cells += [f'<td class="r">{number(before)}</td>', f'<td class="r {mark}">{number(after)}</td>']
            cells.append(f'<td class="r">{ratio(before, after)}</td>')
        rows.append(f"<tr>{''.join(cells)}</tr>")
    return f"<p>Mean squared error on held-out windows.</p><table>{''.join(rows)}</table>"


def _left(views: Sequence[DriveView]) -> str:
    rows = [row(["drive", "axle", "before", "after", "what the rest goes with"], "  rr ", "th")]
    for view in views:
        for axle in ("front", "rear"):
            before, after = (100 * s.share[axle] for s in (view.structure_before, view.structure_after))
            strong = [f"{effect_name(k)} {v:+.2f}" for k, v in view.structure_after.correlations[axle].items()][:3]
            rows.append(
                row([escape(view.name), axle, f"{before:.0f} %", f"{after:.0f} %", ", ".join(strong)], "  rr ")
            )
    words = (
        "Share of each axle's lateral force that stays unexplained over half-second windows (rms over rms, sensor noise taken "
        f"off), and correlations of the rest; below about {RULES.strong:g} they say little."
    )
    return f"<p>{words}</p><table>{''.join(rows)}</table>"


def _done(declared: Declaration, found: Refinement) -> str:
    lines = [
        split_sentence(found),
        f"{len(found.ranking)} effects of the catalogue were fitted one by one, each together with n, on windows of "
        f"{found.bench.shootings[0].steps * found.bench.shootings[0].drive.dt:.1f} s that start at recorded states; "
        "n is fitted before and after alike, so the gain is the effect's own.",
        "Only sensor channels were read. Standard errors count each window as one observation.",
        f"{found.seconds:.0f} s on this machine. The refined model is refined.toml: give it to any command by --model.",
    ]
    return items(lines)
