"""One self-contained page for every report: style, sections, tables, pictures inside."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path

STYLE = """
:root { color-scheme: light dark; }
body { margin: 0; background: #f7f9fb; color: #1f2933; font: 16px/1.55 system-ui, "Segoe UI", Roboto, sans-serif; }
main { max-width: 70rem; margin: 0 auto; padding: 2.5rem 2rem 4rem; background: #fff; }
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
td.r, th.r { text-align: right; } td.r { white-space: nowrap; } td:last-child:not(.r) { min-width: 13rem; }
td.better { color: #00798c; font-weight: 600; } td.worse { color: #d1495b; font-weight: 600; }
figure { margin: 1rem 0 1.4rem; } img { width: 100%; height: auto; } figure.narrow img { max-width: 44rem; }
ul { padding-left: 1.2rem; max-width: 46rem; } code { font-size: .92em; }
.scroll { overflow-x: auto; }
.good { color: #00798c; } .doubt { color: #9a6412; } .wrong { color: #d1495b; font-weight: bold; } .soft { color: #7b8794; }
@media screen and (prefers-color-scheme: dark) {
  body { background: #12181f; color: #e4e7eb; } main { background: #1b232c; }
  h2, td { border-color: #3e4c59; } th { border-color: #52606d; } p.sub, figcaption, td.unit, .soft { color: #9aa5b1; }
  .verdict { background: #17313a; } .verdict.none { background: #242d37; } .verdict.unexplained { background: #38301f; }
  td.better, .good { color: #4fc3d4; } td.worse, .wrong { color: #ff8b98; } .doubt { color: #edae49; }
  img { filter: invert(1) hue-rotate(180deg) brightness(1.2); mix-blend-mode: screen; } a { color: #4fc3d4; }
}
@media (max-width: 40rem) {
  main { padding: 1.2rem 1rem 2rem; } h1 { font-size: 1.35rem; overflow-wrap: anywhere; } table { font-size: .85rem; }
}
@media print { body, main { background: #fff; color: #000; } }
"""


def write_page(path: Path, title: str, parts: Sequence[str]) -> Path:
    """Write the page of `parts`, HTML each, and return its path."""
    path.write_text(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head>\n'
        f"<body><main>\n{''.join(parts)}</main></body></html>\n",
        encoding="utf-8",
    )
    return path


def provenance(about: Mapping[str, Mapping[str, str]]) -> str:
    """Software and vehicle that a result rests on."""
    software, vehicle = about["software"], about["vehicle"]
    lines = (
        f"softsoil {software['version']}: {software['command']}",
        f"vehicle {vehicle['name']}, {vehicle['file']}",
    )
    return items(lines)


def section(title: str, *content: str) -> str:
    """A heading and what stands under it, HTML."""
    return f"<h2>{escape(title)}</h2>{''.join(content)}\n"


def paragraph(text: str) -> str:
    """Plain text as a paragraph."""
    return f"<p>{words(text)}</p>"


def items(lines: Sequence[str]) -> str:
    """Plain lines as a list."""
    return f"<ul>{''.join(f'<li>{words(line)}</li>' for line in lines)}</ul>"


def row(cells: Sequence[str], sides: str, tag: str = "td") -> str:
    """A table row; `sides` has an r for each cell that stands to the right."""
    made = (
        f"<{tag}{' class=r' if side == 'r' else ''}>{cell}</{tag}>" for cell, side in zip(cells, sides, strict=True)
    )
    return f"<tr>{''.join(made)}</tr>"


def table(rows: Sequence[str]) -> str:
    """A table of rows that scrolls by itself where a screen is narrower."""
    return f'<div class="scroll"><table>{"".join(rows)}</table></div>'


def words(text: str) -> str:
    """A line of the terminal as a reader of a page expects it: ± and superscripts."""
    return escape(text.replace("+-", "±").replace("^2", "²").replace("^3", "³"))


def figure(draw: Callable[[Path], Path], caption: str, kind: str = "wide", alt: str = "") -> str:
    """A picture inside the page; draw: writes it as PNG to a path; kind: "wide" or "narrow"; alt: what it shows, for those
    who do not see it, default the caption."""
    with tempfile.TemporaryDirectory() as folder:
        data = base64.b64encode(draw(Path(folder) / "figure.png").read_bytes()).decode("ascii")
    return (
        f'<figure class="{kind}"><img alt="{escape(alt or caption)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )
