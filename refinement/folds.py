"""Candidates judged on the whole drive: a third of its windows at a time, by a fit to the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from refinement.fit import fit
from refinement.trace import Bench, Candidate, fit_base, gain_of, held_cost

Array = NDArray[np.float64]

FOLDS = 3
"""Turns in which windows are held out."""


def cross_validated(
    bench: Bench, candidates: Sequence[Candidate], workers: int = 1, one_wave: bool = False
) -> list[Candidate]:
    """The candidates with gain, its standard error and windows over all folds, best gain first.

    A third of the windows is held out in turns: a few held-out windows tell a small effect from none only by luck.
    workers: threads; one_wave: as of `folded`.
    """
    if not candidates:
        return []
    parts = [folded(bench, fold, one_wave) for fold in range(FOLDS)]

    def one(candidate: Candidate | None, part: Bench) -> Array:
        """Cost of the part's held-out windows, with the candidate or without one."""
        if candidate is None:
            return held_cost(part, fit_base(part).p)
        tried = candidate.fit
        found = fit(
            part.shootings, part.fitted, part.weights, tried.free, tried.value, tried.p, settle=False, errors=False
        )
        return held_cost(part, found.p)

    pairs = [(candidate, part) for candidate in (None, *candidates) for part in parts]
    costs = Parallel(n_jobs=workers, prefer="threads")(delayed(one)(*pair) for pair in pairs)
    before, *after = [np.concatenate(costs[i : i + FOLDS]) for i in range(0, len(costs), FOLDS)]

    def judged(candidate: Candidate, cost: Array) -> Candidate:
        gain, std = gain_of(before, cost, bench.floor)
        return replace(candidate, windows=cost, gain=gain, std=std, whole=float(1.0 - cost.sum() / before.sum()))

    return sorted(map(judged, candidates, after), key=lambda c: -c.gain)


def folded(bench: Bench, fold: int, one_wave: bool = False) -> Bench:
    """The bench with a third of every drive's windows, number `fold`, held out and the rest fitted.

    Every third window, so that what is met on a part of a drive, as a change of soil, is both fitted and judged in every turn;
    a contiguous third where the steering repeats one wave: there, neighbouring windows are copies of each other.
    """
    fitted, held = [], []
    for shooting in bench.shootings:
        rows = np.arange(len(shooting.rows))
        out = np.array_split(rows, FOLDS)[fold] if one_wave else rows[fold::FOLDS]
        held.append(out)
        fitted.append(np.setdiff1d(rows, out))
    return replace(bench, fitted=tuple(fitted), held=tuple(held))
