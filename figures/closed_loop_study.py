"""The closed-loop study as a table on the terminal and a figure."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from softsoil.figures.style import ESTIMATED, INITIAL, SOFT, TRUE, page
from softsoil.mpc_demo.closed_loop_study import LEAST_WORTH, Run, Worth, paired, pooled_share, worth_of

console = Console(width=None if sys.stdout.isatty() else 136)
"""Wider than elsewhere: a row of these tables is read in one go."""
FIGURES = (("tracking_rms", "tracking rms"), ("need", "clearance"))
"""Figures that are compared, smaller is better, and their names."""


def rows_of(runs: Sequence[Run]) -> list[tuple[str, str, str, list[float], Worth]]:
    """(case, side of the first guess, figure, means of guess, true and estimate, worth) over the seeds that all three have."""
    result = []
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
                result.append((case, side, words, means, worth_of(guess, true, estimate)))
    return result


def _same_seeds(runs: Sequence[Run], case: str, side: str, told: str) -> list[Run]:
    """Runs of one controller whose seeds all three controllers have driven."""
    mine = [run for run in runs if run.case == case]
    names = (side, "true", f"est_{side}")
    seeds = set.intersection(*({run.seed for run in mine if run.told == name} for name in names))
    return [run for run in mine if run.told == told and run.seed in seeds]


def say_study(runs: Sequence[Run]) -> None:
    """Two tables: what knowing n is worth, and whether the loop held."""
    table = _table("What knowing n is worth: tracking rms, or least gap to an obstacle (m), means over seeds")
    for heading in (
        "course",
        "guess",
        "",
        "guess",
        "true",
        "estimate",
        "worth (its error)",
        "recovered (90 % of resampled seeds)",
    ):
        table.add_column(heading, no_wrap=True)
    for case, side, words, (guess, true, result), worth in rows_of(runs):
        sign, short = (-1.0, "gap") if words == "clearance" else (1.0, "rms")
        table.add_row(
            short_name(case), side, short, f"{sign * guess:.3f}", f"{sign * true:.3f}", f"{sign * result:.3f}",
            f"{worth.worth:+.3f} ({worth.error:.3f})", recovered_words(worth),
        )  # fmt: skip
    console.print(table)
    _say_loop(runs)


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))


def short_name(case: str) -> str:
    """The case's name for a narrow column."""
    return case.replace("sandy_loam", "loam").replace("_", " ")


def recovered_words(worth: Worth) -> str:
    """Share recovered with its spread, or that knowing n makes no difference."""
    if worth.share is None or worth.share_low is None or worth.share_high is None:
        return "knowing the soil does not matter here" if worth.worth < LEAST_WORTH else "not beyond its scatter: more seeds"
    return f"{100 * worth.share:.0f} % ({100 * worth.share_low:.0f} to {100 * worth.share_high:.0f})"


def _say_loop(runs: Sequence[Run]) -> None:
    table = _table("Whether the loop held, all controllers (n: what the estimator had converged to when the manoeuvre began)")
    headings = ("course", "drives", "ended", "touched", "least gap", "failed", "blocked", "late", "ms", "p99")
    for heading in (*headings, "n from low", "from high"):
        table.add_column(heading, no_wrap=True)
    for case in dict.fromkeys(run.case for run in runs):
        mine = [run for run in runs if run.case == case]
        solve = np.concatenate([run.solve_ms for run in mine])
        gaps = [run.clearance for run in mine if run.clearance is not None]
        table.add_row(
            short_name(case), str(len(mine)), str(sum(run.finished for run in mine)), str(sum(gap <= 0 for gap in gaps)),
            f"{min(gaps):.2f}" if gaps else "", str(sum(run.failures for run in mine)),
            str(sum(run.blocked for run in mine)), str(sum(run.late for run in mine)), f"{np.median(solve):.2f}",
            f"{np.percentile(solve, 99):.1f}", _n_words(mine, "est_low"), _n_words(mine, "est_high"),
        )  # fmt: skip
    console.print(table)
    gaps = [run.clearance for run in runs if run.clearance is not None]
    estimated = [run.clearance for run in runs if run.clearance is not None and run.told.startswith("est_")]
    seeds, solve = len({run.seed for run in runs}), np.concatenate([run.solve_ms for run in runs])
    least = f", least gap {min(estimated):.2f} m" if estimated else ""
    console.print(
        f"{len(runs)} drives with {seeds} seeds, {len(solve)} solves (median {np.median(solve):.2f}, p99 "
        f"{np.percentile(solve, 99):.1f} ms): {sum(run.finished for run in runs)} drives to the end, "
        f"{sum(run.failures for run in runs)} solves failed, {sum(run.late for run in runs)} late\n"
        f"obstacles touched: {sum(gap <= 0 for gap in estimated)} of {len(estimated)} drives with the estimate{least}; "
        f"{sum(gap <= 0 for gap in gaps)} of {len(gaps)} in all\n{recovery_words(runs)}",
        highlight=False,
    )


def recovery_words(runs: Sequence[Run]) -> str:
    """What the estimate recovers over every course where knowing n is worth more than LEAST_WORTH in the mean, with its error."""
    triples: list[np.ndarray] = []
    drives: list[tuple[str, int]] = []
    for case, side, words, _, worth in rows_of(runs):
        if worth.worth > LEAST_WORTH:
            figure = "need" if words == "clearance" else "tracking_rms"
            three = [paired(_same_seeds(runs, case, side, told), case, told, figure) for told in (side, "true", f"est_{side}")]
            triples.append(np.array(three))
            drives += [(case, seed) for seed in sorted(run.seed for run in _same_seeds(runs, case, side, "true"))]
    if not triples:
        return f"knowing n is worth {100 * LEAST_WORTH:.0f} cm on no course"
    guess, true, estimated = np.concatenate(triples, axis=1)
    share, error = pooled_share(guess, true, estimated, drives)
    courses = len({case for case, _ in drives})
    return (
        f"recovered of what knowing n is worth, in {len(triples)} comparisons on {courses} courses where that is more than "
        f"{100 * LEAST_WORTH:.0f} cm: {100 * share:.1f} % (standard error {100 * error:.1f})"
    )


def _n_words(runs: Sequence[Run], told: str) -> str:
    n = np.array([run.n_manoeuvre for run in runs if run.told == told])
    return f"{n.mean():.2f} ± {n.std():.2f}" if len(n) else ""


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
            axis.set_yticks(range(len(mine)), [f"{short_name(row[0])}\nguess too {row[1]}" for row in mine])
            axis.set(title=f"{words}, m ({'larger' if sign < 0 else 'smaller'} is better)")
            axis.axvline(0.0, color=SOFT, lw=1)
            axis.invert_yaxis()
        for label, color in (("wrong guess", INITIAL), ("true n", TRUE), ("estimated n", ESTIMATED)):
            axes[0, 0].plot([], [], "|", color=color, ms=11, mew=2.5, label=label)
        axes[0, 0].legend(loc="upper right")
    return path
