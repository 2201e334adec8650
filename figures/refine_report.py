"""report.html of a refinement: one file with its pictures inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.horizons import HORIZONS
from softsoil.figures.error_table import rms_table
from softsoil.figures.labels import law_words, per_cent, plain, quantity
from softsoil.figures.page_html import figure, items, paragraph, provenance, row, section, table, write_page
from softsoil.figures.refine import draw_axles, draw_paths, draw_ranking
from softsoil.figures.refine_views import DriveView, drive_views
from softsoil.refinement.result import Refinement
from softsoil.refinement.rules import RULES
from softsoil.refinement.vehicle_numbers import by_name
from softsoil.refinement.words import (
    falls_sentence,
    group_sentences,
    in_degrees,
    split_sentence,
    verdict_sentence,
    with_error,
)
from softsoil.symbolic.catalogue import catalogue


def write_report(
    declared: Declaration, result: Refinement, start: float, path: Path, about: Mapping[str, Mapping[str, str]]
) -> Path:
    """Write the report of a refinement and return its path.

    declared, start: as given to `refine`; about: provenance, software (version, command) and vehicle (name, file).
    """
    views = drive_views(result, start)
    names = ", ".join(view.name for view in views)
    refined = bool(result.effects or result.contradicted)
    errors = rms_table(result.before, result.after if refined else None)
    parts = [
        _head(names, declared, result),
        section("Parameters", _parameters(declared, result)),
        section("Residual, before and after" if refined else "Residual", *(_axles(view) for view in views)),
        section("Candidates", _ranking(declared, result)),
        section("Held-out predictions", *(_paths(view) for view in views), paragraph("Rms error on held-out windows."), errors),
        section("What is left", _left(views, refined)),
        section("What was done", _done(declared, result)),
        section("Notes", items(result.notes)) if result.notes else "",
        section("Provenance", provenance(about)),
    ]
    title = f"softsoil refine: {names}"
    return write_page(path, title, parts)


def _head(names: str, declared: Declaration, result: Refinement) -> str:
    lines = [verdict_sentence(result), falls_sentence(result), *group_sentences(result)]
    inside = "".join(paragraph(line) for line in lines if line)
    effects = ", ".join(map(plain, declared.vehicle.effects)) or "none"
    soils = " and ".join(dict.fromkeys(soil.name for soil in result.soils)) or declared.soil.name
    sub = f"{declared.vehicle.name} on {soils}, force law {law_words(declared.law)}, declared effects: {effects}"
    return (
        f'<h1>What the model lacks: {escape(names)}</h1><p class="sub">{escape(sub)}</p>'
        f'<div class="verdict {"unexplained" if result.contradicted else result.verdict}">{inside}</div>'
    )


def _parameters(declared: Declaration, result: Refinement) -> str:
    rows = []
    for effect in result.effects:
        for name, size in effect.parameters.items():
            value, std, unit = in_degrees(*size)
            cells = [escape(plain(effect.name)), f"<code>{escape(name)}</code>", with_error(value, std), unit]
            rows.append(row([*cells, escape(_doc(declared, effect.name, name))], "  r  "))
    for number_ in (*result.contradicted, *result.fitted):
        state = "contradicts the vehicle file" if number_ in result.contradicted else f"fitted beside {result.unknown}"
        words = f"{state}; declared {with_error(*in_degrees(number_.declared, number_.stated, number_.unit)[:2])}"
        value, std, unit = in_degrees(number_.value, number_.std, number_.unit)
        cells = ["vehicle", f"<code>{escape(number_.name)}</code>", with_error(value, std), unit]
        rows.append(row([*cells, escape(words)], "  r  "))
    for ground in result.ground:
        for one in ground.numbers:
            what = {"friction": "coefficient of friction", "tread": "length that the tread shears by before it slides"}[one.name]
            words = f"{what}, {ground.name}, {plain(one.word)}: {one.reason}; {one.before:.3g} with the declared model"
            cells = ["ground", f"<code>{one.name}</code>", with_error(one.value, one.std), one.unit]
            rows.append(row([*cells, escape(words)], "  r  "))
    if result.n_after:
        drives = zip(result.bench.shootings, result.n_before, result.n_after, result.n_std, result.judged, strict=True)
        for shooting, before, after, std, verdict in drives:
            words = f"sinkage exponent, {shooting.drive.name}, {plain(verdict.word)}"
            words += f"; {before:.3f} with the declared model" if result.effects or result.contradicted else ""
            rows.append(row(["soil", "<code>n</code>", with_error(after, std), "", escape(words)], "  r  "))
    head = row(["effect", "parameter", "value ± std, whole drive", "unit", "what it is"], "  r  ", "th")
    return table([head, *rows])


def _doc(declared: Declaration, effect: str, name: str) -> str:
    known = catalogue(declared.vehicle)[effect]
    signals = [*known.parameters, *([known.derived] if known.derived else [])]
    return next(signal.doc for signal in signals if signal.name == name)


def _axles(view: DriveView) -> str:
    caption = (
        "The model's accelerations are integrated along the recorded states; what the record departs from that, per window, "
        "is split over the axles. Right: against the signal that the declared model's residual correlates with most."
    )
    alt = f"{view.name}: unexplained lateral force of the front and the rear axle over time, and against one signal"
    return figure(lambda path: draw_axles(view, path), caption, alt=alt)


def _ranking(declared: Declaration, result: Refinement) -> str:
    least, whole, apart = (100 * share for share in (RULES.least_gain, RULES.least_whole, RULES.least_whole_apart))
    caption = (
        f"Each effect alone, fitted together with {result.unknown}. An effect is named if it removes at least {least:.0f} % "
        f"of the held-out cost beyond sensor noise ({100 * RULES.one_wave_gain:.0f} % where the steering repeats one wave, a "
        f"second effect {100 * RULES.later_gain:.0f} % of what the first has left) and {whole:.0f} % of the whole of it "
        f"({apart:.0f} % of an effect of sensors or of a place), if windows that gain nothing would not show as much "
        f"({100 * RULES.chance:g} %), and if its parameter stands {RULES.least_parameter_sigmas:g} standard errors from absence "
        "(or those windows leave no doubt) and not at a bound; a change at a place also if it stands "
        f"{RULES.place_sigmas:g} of them from absence in a fit to the whole drive."
    )
    known, numbers = catalogue(declared.vehicle), by_name()
    rows = [row(["candidate", "held-out gain ± std", "what it is", "what separates it from its like"], " r  ", "th")]
    for c in result.ranking:
        gain = f"{per_cent(c.gain)[:-2]} ± {per_cent(c.std)}" if c.gain > -1.0 else "below -100 %"
        if c.name in known:
            words = (known[c.name].doc, known[c.name].separates)
        else:  # a number of the vehicle that may be declared wrong
            doc = numbers[c.name].doc if c.name in numbers else plain(c.name)
            words = (f"number of the vehicle: {doc}", f"measure it: {numbers[c.name].how}" if c.name in numbers else "measure it")
        rows.append(row([escape(plain(c.name)), gain, *map(escape, words)], " r  "))
    picture = figure(lambda path: draw_ranking(result, path), caption, "narrow", "Held-out gain of each candidate as bars")
    return picture + table(rows)


def _paths(view: DriveView) -> str:
    if not len(view.recorded):
        return paragraph(f"{view.name}: the part that judges holds no window of {min(HORIZONS):g} s: no paths.")
    alt = f"{view.name}: held-out paths of the models on the map, and their distance to the side of the record"
    return figure(lambda path: draw_paths(view, path), "Windows side by side over the part of the drive that judges.", alt=alt)


def _left(views: Sequence[DriveView], refined: bool) -> str:
    heads = ["before", "after"] if refined else ["unexplained"]
    sides = f"  {'r' * len(heads)} "
    rows = [row(["drive", "axle", *heads, "signals that the rest correlates with"], sides, "th")]
    for view in views:
        for axle in ("front", "rear"):
            left = (view.structure_before, view.structure_after)[-len(heads) :]
            shares = [f"{100 * s.share[axle]:.0f} %" if s.judged else "not judged" for s in left]
            strong = [f"{quantity(k).words} {v:+.2f}" for k, v in view.structure_after.correlations[axle].items()][:3]
            rows.append(
                row([escape(view.name), axle, *shares, ", ".join(strong)], sides)
            )
    words = (
        "Share of each axle's lateral force that stays unexplained over half-second windows (rms over rms, sensor noise taken "
        f"off), and correlations of the rest; below about {RULES.strong:g} they say little."
    )
    return paragraph(words) + table(rows)


def _done(declared: Declaration, result: Refinement) -> str:
    lines = [
        split_sentence(result),
        f"{len(result.ranking)} candidates, effects and numbers of the vehicle, were fitted one by one, each together with "
        f"{result.unknown}, on windows of {result.bench.shootings[0].steps * result.bench.shootings[0].drive.dt:.1f} s that "
        f"start at recorded states; {'that is' if result.ground else 'n is'} fitted before and after alike. The best were judged "
        f"again on each of {RULES.folds} parts of all windows in turn, fitted to the others.",
        "Only sensor channels were read. Standard errors count each window as one observation.",
        f"{result.seconds:.0f} s on this machine. The refined model is refined.toml: give it to any command by --model.",
    ]
    return items(lines)
