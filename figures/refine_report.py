"""report.html of a refinement: one file with its pictures inside."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path

from softsoil.declaration.model_file import Declaration
from softsoil.figures.refine import draw_axles, draw_paths, draw_ranking
from softsoil.figures.refine_views import DriveView, drive_views
from softsoil.recording.drive import CHANNEL_UNITS, STATE_CHANNELS
from softsoil.refinement.refine import Refinement
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

STYLE = """
:root { color-scheme: light; }
body { margin: 0; background: #f7f9fb; color: #1f2933; font: 16px/1.55 system-ui, "Segoe UI", Roboto, sans-serif; }
main { max-width: 62rem; margin: 0 auto; padding: 2.5rem 2rem 4rem; background: #fff; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .3rem; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .6rem; padding-bottom: .25rem; border-bottom: 1px solid #e4e7eb; }
p { margin: .4rem 0; max-width: 46rem; }
p.sub, figcaption, td.unit { color: #616e7c; font-size: .9rem; }
.verdict { border-left: 5px solid #00798c; background: #eef7f8; padding: .8rem 1.1rem; margin: 1.4rem 0; }
.verdict.none { border-color: #9aa5b1; background: #f3f5f7; }
.verdict.unexplained { border-color: #edae49; background: #fdf6e9; }
.verdict p:first-child { font-weight: 600; font-size: 1.1rem; }
table { border-collapse: collapse; font-size: .92rem; margin: .8rem 0; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 600; border-bottom: 2px solid #cbd2d9; padding: .3rem .9rem .3rem 0; }
td { border-bottom: 1px solid #e4e7eb; padding: .25rem .9rem .25rem 0; }
td.r, th.r { text-align: right; }
td.better { color: #00798c; font-weight: 600; } td.worse { color: #d1495b; font-weight: 600; }
figure { margin: 1rem 0 1.4rem; } img { width: 100%; height: auto; } figure.narrow img { max-width: 44rem; }
ul { padding-left: 1.2rem; max-width: 46rem; } code { font-size: .92em; }
"""


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
        _section("Parameters", _parameters(declared, found)),
        _section("Residual, before and after", *(_axles(view) for view in views)),
        _section("Candidates", _ranking(found)),
        _section("Held-out predictions", *(_paths(view) for view in views), _errors(found)),
        _section("What is left", _left(views)),
        _section("What was done", _done(declared, found)),
        _section("Notes", _items(found.notes)) if found.notes else "",
        _section("Provenance", _provenance(about)),
    ]
    title = f"softsoil refine: {names}"
    path.write_text(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head>\n'
        f"<body><main>\n{''.join(parts)}</main></body></html>\n",
        encoding="utf-8",
    )
    return path


def _head(names: str, declared: Declaration, found: Refinement) -> str:
    lines = [verdict_sentence(found), falls_sentence(found), *group_sentences(found)]
    inside = "".join(_p(line) for line in lines if line)
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
            rows.append(_row([*cells, escape(_doc(declared, effect.name, name))], "  r  "))
    if len(found.bench.shootings) == len(found.n_after):
        for shooting, before, after in zip(found.bench.shootings, found.n_before, found.n_after, strict=True):
            words = f"sinkage exponent, {shooting.drive.name}; {before:.3f} with the declared model"
            rows.append(_row(["soil", "<code>n</code>", f"{after:.3f}", "", escape(words)], "  r  "))
    head = _row(["effect", "parameter", "value ± std, whole drive", "unit", "what it is"], "  r  ", "th")
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
    return _figure(lambda path: draw_axles(view, path), caption)


def _ranking(found: Refinement) -> str:
    caption = (
        f"Each effect alone, fitted together with n. An effect is named if it removes at least {100 * RULES.least_gain:.0f} % of "
        f"the held-out cost beyond sensor noise, if windows that gain nothing would not show as much ({100 * RULES.chance:g} %), "
        f"and if its parameter stands {RULES.least_parameter_sigmas:g} standard errors from absence (or those windows leave no "
        f"doubt) and not at a bound; a change at a place also if it stands {RULES.place_sigmas:g} of them from absence in a fit "
        "to the whole drive."
    )
    return _figure(lambda path: draw_ranking(found, path), caption, "narrow")


def _paths(view: DriveView) -> str:
    return _figure(lambda path: draw_paths(view, path), "Windows side by side over the part of the drive that judges.")


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
    rows = [_row(["drive", "axle", "before", "after", "what the rest goes with"], "  rr ", "th")]
    for view in views:
        for axle in ("front", "rear"):
            before, after = (100 * s.share[axle] for s in (view.structure_before, view.structure_after))
            strong = [f"{effect_name(k)} {v:+.2f}" for k, v in view.structure_after.correlations[axle].items()][:3]
            rows.append(
                _row([escape(view.name), axle, f"{before:.0f} %", f"{after:.0f} %", ", ".join(strong)], "  rr ")
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
    return _items(lines)


def _provenance(about: Mapping[str, Mapping[str, str]]) -> str:
    software, vehicle = about["software"], about["vehicle"]
    lines = (
        f"softsoil {software['version']}: {software['command']}",
        f"vehicle {vehicle['name']}, {vehicle['file']}",
    )
    return _items(lines)


def _section(title: str, *content: str) -> str:
    return f"<h2>{escape(title)}</h2>{''.join(content)}\n"


def _p(text: str) -> str:
    return f"<p>{escape(text)}</p>"


def _items(lines: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def _row(cells: Sequence[str], sides: str, tag: str = "td") -> str:
    """A table row; `sides` has an r for each cell that stands to the right."""
    made = (
        f"<{tag}{' class=r' if side == 'r' else ''}>{cell}</{tag}>" for cell, side in zip(cells, sides, strict=True)
    )
    return f"<tr>{''.join(made)}</tr>"


def _figure(draw: Callable[[Path], Path], caption: str, kind: str = "wide") -> str:
    with tempfile.TemporaryDirectory() as folder:
        data = base64.b64encode(draw(Path(folder) / "figure.png").read_bytes()).decode("ascii")
    return (
        f'<figure class="{kind}"><img alt="{escape(caption)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )
