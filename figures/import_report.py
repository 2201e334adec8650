"""report.html of an import: channels, rates, gaps, offsets, checks and the path on one self-contained page."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.figures.labels import quantity
from softsoil.figures.page_html import figure, items, paragraph, provenance, row, section, table, words, write_page
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, page
from softsoil.importing.bring_in import Import
from softsoil.recording.drive import CHANNEL_UNITS

SHOWN = ("u", "v", "omega_z", "steer", "a_y_imu", "omega_fl")
COLORS = {"measured": ESTIMATED, "derived": REAR, "absent": SOFT}


def write_import_report(result: Import, path: Path, about: Mapping[str, Mapping[str, str]]) -> Path:
    """Write the page to `path`; returns it. about: software and vehicle."""
    failed = [check for check in result.checks if not check.passed]
    verdict = (
        f"All {len(result.checks)} checks passed."
        if not failed
        else f"{len(failed)} of {len(result.checks)} checks failed: {', '.join(check.name for check in failed)}."
    )
    kind = "unexplained" if failed else "none"
    head = f"{len(result.drive)} rows at {1 / result.drive.dt:.4g} Hz, {np.ptp(result.drive.t):.1f} s"
    parts = [
        f'<h1>{escape(result.drive.name)}</h1><p class="sub">{escape(head)}</p>'
        f'<div class="verdict {kind}">{paragraph(verdict)}</div>',
        section("Path and channels", figure(lambda picture: _draw(result, picture), CAPTION, alt=ALT)),
        section("Channels", _channels(result)),
        section("Clocks", _offsets(result)),
        section("Checks of channels against each other", _checks(result)),
        section("Notes", items(result.drive.notes)) if result.drive.notes else "",
        section("Provenance", provenance(about)),
    ]
    return write_page(path, f"softsoil import: {result.drive.name}", parts)


def _row(cells: list[str], tag: str = "td") -> str:
    return row(cells, " " * len(cells), tag)


def _channels(result: Import) -> str:
    rows = [_row(["channel", "unit", "state", "source", "rate, Hz", "gaps", "shifted, s", "filled"], "th")]
    for name, entry in result.as_json()["channels"].items():
        share = np.isfinite(result.drive[name]).mean() if name in result.drive else 0.0
        css = {"measured": "good", "derived": "doubt"}.get(entry["state"], "soft")
        rate = "" if entry["rate_hz"] is None else f"{entry['rate_hz']:.4g}"
        gaps = "" if entry["gaps"] is None else str(entry["gaps"])
        state = f'<span class="{css}">{entry["state"]}</span>'
        shifted = f"{entry['offset_s']:+.3f}" if entry["offset_s"] else ""
        source, filled = escape(entry["source"]), f"{100 * share:.0f} %"
        rows.append(_row([name, words(CHANNEL_UNITS[name]), state, source, rate, gaps, shifted, filled]))
    return table(rows)


def _offsets(result: Import) -> str:
    if not result.offsets:
        return "<p>No pair of channels says anything of the clocks.</p>"
    rows = [_row(["channels", "against", "late, s", "standard error, s", "correlation before", "after"], "th")]
    for o in result.offsets:
        rows.append(
            _row([o.group, escape(o.against), f"{o.late_s:+.3f}", f"{o.std:.3f}", f"{o.before:.4f}", f"{o.after:.4f}"])
        )
    shifted = ", ".join(f"{escape(source)} by {value:+.3f} s" for source, value in result.shifts.items() if value)
    return table(rows) + f"<p>{'Shifted: ' + shifted if shifted else 'No clock was shifted.'}</p>"


def _checks(result: Import) -> str:
    failed = any(not check.passed for check in result.checks)
    rows = [_row(["check", "result", "measured", "expected", *(["cure"] if failed else [])], "th")]
    for check in sorted(result.checks, key=lambda c: (c.passed, not c.beyond_doubt)):
        css, word = (
            ("good", "passed")
            if check.passed
            else ("wrong", "contradiction")
            if check.beyond_doubt
            else ("doubt", "doubtful")
        )
        said = (check.found, check.expected, *([check.cure] if failed else []))
        rows.append(_row([check.name, f'<span class="{css}">{word}</span>', *map(words, said)]))
    return table(rows)


ALT = "Path of the front axle, channels over time, and steps between the samples of each source"
CAPTION = (
    "Path of the front axle, the channels over time, and the steps between samples of each source: rates and gaps. Derived "
    "channels are yellow."
)


def _draw(result: Import, path: Path) -> Path:
    """Path and channels as a picture."""
    drive = result.drive
    with page(path, "Path and channels (derived ones in yellow)", 10, 8, 4, 2) as axes:
        flat = axes.ravel()
        flat[0].plot(drive["x"], drive["y"], ".", ms=1.5, color=COLORS[drive.state_of("x")])
        flat[0].set(title="path of the front axle", xlabel="x, m", ylabel="y, m")
        flat[0].set_aspect("equal", adjustable="datalim")
        for axis, name in zip(flat[1:], SHOWN, strict=False):
            shown = quantity(name)
            if drive.state_of(name) == "absent":
                axis.text(0.5, 0.5, "absent", ha="center", va="center", transform=axis.transAxes)
                axis.set(title=shown.words, xticks=[], yticks=[])
                continue
            axis.plot(drive.t, shown.factor * drive[name], ".", ms=1.0, color=COLORS[drive.state_of(name)])
            axis.set(title=shown.words, ylabel=shown.unit)
        _timing(flat[7], result)
        for axis in flat[-2:]:
            axis.set_xlabel("time, s")
    return path


def _timing(axis: Any, result: Import) -> None:
    """Steps between the samples of each source: rates and gaps at a glance."""
    lines = []
    for i, one in enumerate(result.series.values()):
        steps = np.diff(one.t)
        seen, color = steps > 0.0, (ESTIMATED, INITIAL, REAR, SOFT)[i % 4]
        lines += axis.semilogy(one.t[1:][seen] - result.merged.start_s, steps[seen], ".", ms=2, color=color)
    steps = np.concatenate([np.diff(one.t) for one in result.series.values()])
    steps = steps[steps > 0.0]  # bursts share a time of arrival
    decades = 10.0 ** np.floor(np.log10(steps.min())), 10.0 ** (np.floor(np.log10(steps.max())) + 1.0)
    axis.set(title="steps between samples", xlabel="s", ylabel="s", ylim=decades)
    tight = {"fontsize": 6, "markerscale": 3, "handletextpad": 0.1, "columnspacing": 0.8}
    axis.legend(lines, list(result.series), loc="upper center", ncols=4, **tight)
