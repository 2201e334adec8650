"""The closed-loop study as a table on the terminal and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from mpc_demo.closed_loop_study import Run, Worth, paired, worth_of
from mpc_demo.output import console
from mpc_demo.style import ESTIMATED, INITIAL, SOFT, TRUE, page

FIGURES = (("tracking_rms", "tracking rms"), ("need", "clearance"))
"""Figures that are compared, smaller is better, and their names."""


def rows_of(runs: Sequence[Run]) -> list[tuple[str, str, str, list[float], Worth]]:
    """(case, side of the first guess, figure, means of guess, true and estimate, worth) over the seeds that all three have."""
    found = []
    for case in dict.fromkeys(run.case for run in runs):
        for side in ("low", "high"):
            three = [_same_seeds(runs, case, side, told) for told in (side, "true", f"est_{side}")]
            if len(three[0]) < 2:
                continue
            for figure, words in FIGURES:
                guess, true, estimate = (paired(mine, case, mine[0].told, figure) for mine in three)
                if not np.isfinite(guess).all() or (figure == "tracking_rms" and three[0][0].clearance is not None):
                    continue  # no obstacles, or a path that obstacles force it to leave
                means = [float(np.mean(values)) for values in (guess, true, estimate)]
                found.append((case, side, words, means, worth_of(guess, true, estimate)))
    return found


def _same_seeds(runs: Sequence[Run], case: str, side: str, told: str) -> list[Run]:
    """Runs of one controller whose seeds all three controllers have driven."""
    mine = [run for run in runs if run.case == case]
    names = (side, "true", f"est_{side}")
    seeds = set.intersection(*({run.seed for run in mine if run.told == name} for name in names))
    return [run for run in mine if run.told == told and run.seed in seeds]


def say_study(runs: Sequence[Run]) -> None:
    """Two tables: what knowing n is worth, and whether the loop held."""
    table = Table(title="Closed loop over seeds: what knowing n is worth", title_justify="left")
    for heading in ("course", "first guess", "figure, m", "guess", "true n", "estimate", "worth", "recovered (90 %)"):
        table.add_column(heading)
    for case, side, words, (guess, true, found), worth in rows_of(runs):
        sign = -1.0 if words == "clearance" else 1.0
        table.add_row(
            case, f"too {side}", words, f"{sign * guess:.3f}", f"{sign * true:.3f}", f"{sign * found:.3f}",
            f"{worth.worth:+.3f} +- {worth.error:.3f}", recovered_words(worth),
        )  # fmt: skip
    console.print(table)
    _say_loop(runs)


def recovered_words(worth: Worth) -> str:
    """Share recovered with its spread, or that knowing n makes no difference."""
    if worth.share is None or worth.share_low is None or worth.share_high is None:
        return "knowing the soil does not matter here"
    return f"{100 * worth.share:.0f} % ({100 * worth.share_low:.0f} to {100 * worth.share_high:.0f})"


def _say_loop(runs: Sequence[Run]) -> None:
    table = Table(title="Whether the loop held, over all seeds", title_justify="left")
    headings = (
        "course",
        "told",
        "drives",
        "to the end",
        "touched",
        "least gap, m",
        "worst error, m",
        "failed",
        "blocked",
    )
    for heading in (*headings, "late", "solve ms", "p99", "n at the manoeuvre"):
        table.add_column(heading)
    for case in dict.fromkeys(run.case for run in runs):
        for told in dict.fromkeys(run.told for run in runs if run.case == case):
            mine = [run for run in runs if run.case == case and run.told == told]
            solve = np.concatenate([run.solve_ms for run in mine])
            gaps = [run.clearance for run in mine if run.clearance is not None]
            n = np.array([run.n_manoeuvre for run in mine])
            table.add_row(
                case, told, str(len(mine)), str(sum(run.finished for run in mine)), str(sum(gap <= 0 for gap in gaps)),
                f"{min(gaps):.2f}" if gaps else "", f"{max(run.max_error for run in mine):.2f}",
                str(sum(run.failures for run in mine)), str(sum(run.blocked for run in mine)),
                str(sum(run.late for run in mine)), f"{np.median(solve):.2f}", f"{np.percentile(solve, 99):.2f}",
                f"{n.mean():.2f} +- {n.std():.2f}",
            )  # fmt: skip
    console.print(table)
    gaps = [run.clearance for run in runs if run.clearance is not None]
    console.print(
        f"{len(runs)} drives, {sum(len(run.solve_ms) for run in runs)} solves: {sum(run.finished for run in runs)} drives to "
        f"the end, {sum(gap <= 0 for gap in gaps)} touched an obstacle, {sum(run.failures for run in runs)} solves "
        f"failed, {sum(run.late for run in runs)} late",
        highlight=False,
    )


def draw_study(runs: Sequence[Run], path: Path) -> Path:
    """Per case: each seed's figure of the three controllers, guesses too low and too high beside each other."""
    rows = rows_of(runs)
    with page(
        path, "Closed loop over seeds: wrong guess of n, true n, estimated n", 12, 8, 1, 2, squeeze=False
    ) as axes:
        for axis, (figure, words) in zip(axes[0], FIGURES, strict=True):
            mine = [row for row in rows if row[2] == words]
            sign = -1.0 if figure == "need" else 1.0
            for place, (case, side, _, _, _) in enumerate(mine):
                styles = ((side, INITIAL, 0.2), ("true", TRUE, 0.0), (f"est_{side}", ESTIMATED, -0.2))
                for told, color, up in styles:
                    values = sign * paired(_same_seeds(runs, case, side, told), case, told, figure)
                    axis.plot(values, np.full(len(values), place + up), ".", color=color, ms=4, alpha=0.5)
                    axis.plot(values.mean(), place + up, "|", color=color, ms=11, mew=2.5)
            axis.set_yticks(range(len(mine)), [f"{row[0].replace('_', ' ')}\nguess too {row[1]}" for row in mine])
            axis.set(title=f"{words}, m ({'larger' if sign < 0 else 'smaller'} is better)")
            axis.axvline(0.0, color=SOFT, lw=1)
            axis.invert_yaxis()
        for label, color in (("wrong guess", INITIAL), ("true n", TRUE), ("estimated n", ESTIMATED)):
            axes[0, 0].plot([], [], "|", color=color, ms=11, mew=2.5, label=label)
        axes[0, 0].legend(loc="lower right")
    return path
