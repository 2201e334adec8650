"""Figures of a refinement: residual before and after, ranking, held-out paths."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.figures.gaps import bridged, broken, root_mean_square
from softsoil.figures.labels import plain, quantity
from softsoil.figures.refine_views import DriveView
from softsoil.figures.style import ESTIMATED, INITIAL, SOFT, TRUE, page
from softsoil.refinement.residual import WINDOW
from softsoil.refinement.result import Refinement
from softsoil.refinement.rules import RULES
from softsoil.refinement.trace import Candidate
from softsoil.refinement.words import bound_words

PLAIN = "time"
"""What a residual that is merely constant is drawn against."""


def draw_axles(view: DriveView, path: Path) -> Path:
    """Unexplained lateral force of each axle over time, and against the signal that it correlates with most before."""
    title = f"{view.name}: unexplained lateral force, windows of {WINDOW:g} s"
    with page(path, title, 10, 5.6, 2, 2, width_ratios=(2, 1), sharey="row") as axes:
        for row, axle in zip(axes, ("front", "rear"), strict=True):
            before = view.before.force_f if axle == "front" else view.before.force_r
            after = view.after.force_f if axle == "front" else view.after.force_r
            _over_time(row[0], view, axle, before, after)
            _against(row[1], view, axle, before, after)
        axes[0, 0].figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower left", ncols=3)
        axes[1, 0].set_xlabel("time, s")
    return path


def _over_time(axis: Any, view: DriveView, axle: str, before: Any, after: Any) -> None:
    axis.axvspan(view.held_from, view.before.t[-1] + WINDOW / 2, color="#f0f4f8", zorder=0, label="judged, not fitted")
    axis.plot(*broken(view.before.t, before), color=INITIAL, lw=1.2, label="declared model")
    if view.refined:
        axis.plot(*broken(view.after.t, after), color=ESTIMATED, lw=1.2, label="refined model")
    axis.axhline(0, color=TRUE, lw=0.8)
    shares = [100 * s.share[axle] for s in (view.structure_before, view.structure_after)]
    said = [f"{share:.0f} %" for share in shares]
    words = f"{said[0]} of its force" + (f", then {said[1]}" if view.refined and said[1] != said[0] else "")
    if not np.isfinite(shares).all():
        words = "not judged, see the notes"
    axis.set(title=f"{axle.capitalize()} axle: {words}", ylabel="unexplained force, N")


def _against(axis: Any, view: DriveView, axle: str, before: Any, after: Any) -> None:
    correlations = view.structure_before.correlations[axle]
    name = next(iter(correlations), PLAIN)
    signal = PLAIN if name == "constant" else name
    shown = quantity(signal)
    axis.plot(shown.factor * view.signals[signal], before, ".", color=INITIAL, ms=4)
    if view.refined:
        axis.plot(shown.factor * view.signals[signal], after, ".", color=ESTIMATED, ms=4)
    axis.axhline(0, color=TRUE, lw=0.8)
    title = "" if not correlations else "a constant" if name == "constant" else f"correlation {correlations[name]:+.2f}"
    axis.set(title=title and f"Declared model: {title}", xlabel=shown.label)


def draw_ranking(result: Refinement, path: Path) -> Path:
    """All candidates of the first round by the share of the held-out cost that each removes, with standard errors."""
    ranking = result.ranking[::-1]
    accepted = {effect.name for effect in result.effects} | {number.name for number in result.contradicted}
    colors = [ESTIMATED if c.name in accepted else SOFT for c in ranking]
    with page(path, "Share of the held-out cost that each candidate removes", 8, 0.24 * len(ranking) + 1.2) as axis:
        places = np.arange(len(ranking))
        shares = [100 * max(c.gain, -1.0) for c in ranking]
        bars = {"ecolor": TRUE, "elinewidth": 1, "capsize": 2}
        axis.barh(
            places, shares, xerr=[100 * min(c.std, 1.0) for c in ranking], color=colors, height=0.7, error_kw=bars
        )
        axis.axvline(100 * RULES.least_gain, color=INITIAL, ls="--", lw=1)
        axis.annotate(
            f"least gain {100 * RULES.least_gain:.0f} %", (100 * RULES.least_gain, -0.4), (4, 0), textcoords="offset points",
            color=INITIAL, fontsize=8, va="center",
        )  # fmt: skip
        labels = [_label(c) for c in ranking]
        axis.set_yticks(places, labels)
        axis.set(xlabel="held-out gain ± standard error over windows, %", ylim=(-0.8, len(ranking) - 0.3))
        left = max(min([*(share for share in shares if math.isfinite(share)), 0.0]) - 5, -40)
        for place, share in zip(places, shares, strict=True):
            if share < left:
                words = f"{share:.0f} %" if share > -100.0 else "below -100 %"
                axis.annotate(words, (left, place), (3, 0), textcoords="offset points", va="center", fontsize=7)
        axis.set_xlim(left, 115)
        axis.grid(axis="y", visible=False)
    return path


def _label(c: Candidate) -> str:
    """A candidate's name, and which of its parameters ended on a bound where that is not its name once more."""
    words = plain(bound_words(c)).removeprefix(f"{plain(c.name)} ")
    return f"{plain(c.name)} ({words})" if c.fit.at_bound else plain(c.name)


def draw_paths(view: DriveView, path: Path) -> Path:
    """Held-out paths on the map, and how far to the side of the record the models' paths end up."""
    title = f"{view.name}: held-out paths, {view.horizon:g} s ahead from recorded states"
    with page(path, title, 10, 4.2, 1, 2, width_ratios=(1.3, 1)) as axes:
        for label, paths, color in (("record", view.recorded, TRUE), ("declared", view.path_before, INITIAL),
                                    ("refined", view.path_after, ESTIMATED)):  # fmt: skip
            if label == "refined" and not view.refined:
                continue
            for k, one in enumerate(paths):
                width = 2.4 if label == "record" else 1.2
                one = one[np.isfinite(one[:, :2]).all(axis=1)]
                axes[0].plot(one[:, 0], one[:, 1], color=color, lw=width, alpha=0.9, label=None if k else label)
        starts = [one[np.isfinite(one[:, :2]).all(axis=1)][:1, :2] for one in view.recorded]
        axes[0].plot(*np.concatenate(starts).T, "o", color=TRUE, ms=4)
        axes[0].set(title="Map (dots: starts)", xlabel="x, m", ylabel="y, m")
        axes[0].set_aspect("equal", adjustable="datalim")
        axes[0].legend(loc="best")
        for label, paths, color in (("declared", view.path_before, INITIAL), ("refined", view.path_after, ESTIMATED)):
            if label == "refined" and not view.refined:
                continue
            side = bridged(aside(paths, view.recorded))
            axes[1].plot(view.clock, side.T, color=color, lw=0.7, alpha=0.6)
            rms = root_mean_square(side)
            last = np.flatnonzero(np.isfinite(rms))[-1:]
            said = "".join(f": rms {rms[k]:.2f} m at {view.clock[k]:.1f} s" for k in last)
            axes[1].plot(view.clock, rms, color=color, lw=2.4, label=f"{label}{said}")
        axes[1].axhline(0, color=TRUE, lw=0.8)
        axes[1].set(title="To the side of the record", xlabel="time since the start, s", ylabel="m, left positive")
        axes[1].legend(loc="upper left")
    return path


def aside(paths: Any, recorded: Any) -> Any:
    """(W, N) distance of predicted points to the left of the recorded ones, across the recorded heading (m).

    paths, recorded (W, N, 3): x, y, psi.
    """
    apart = paths - recorded
    return -apart[..., 0] * np.sin(recorded[..., 2]) + apart[..., 1] * np.cos(recorded[..., 2])
