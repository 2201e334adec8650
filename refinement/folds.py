"""Candidates judged on the whole drive: every third window by a fit to the others."""

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
"""Turns in which windows are held out: each turn's come from the whole drive, so that what is met on a part of it, as a change of
soil, is both fitted and judged in every turn."""


def cross_validated(bench: Bench, candidates: Sequence[Candidate], workers: int = 1) -> list[Candidate]:
    """The candidates with gain, its standard error and windows over all folds, best gain first.

    Every third window of every drive is held out in turns: a few held-out windows tell a small effect from none only by luck.
    workers: threads.
    """
    if not candidates:
        return []
    parts = [folded(bench, fold) for fold in range(FOLDS)]
    before = np.concatenate([held_cost(part, fit_base(part).p) for part in parts])

    def one(candidate: Candidate) -> Candidate:
        costs = []
        for part in parts:
            found = fit(
                part.shootings, part.fitted, part.weights, candidate.fit.free, candidate.fit.value, candidate.fit.p
            )
            costs.append(held_cost(part, found.p))
        after = np.concatenate(costs)
        gain, std = gain_of(before, after, bench.floor)
        whole = float(1.0 - after.sum() / before.sum())
        return replace(candidate, windows=after, gain=gain, std=std, whole=whole)

    found = Parallel(n_jobs=workers, prefer="threads")(delayed(one)(candidate) for candidate in candidates)
    return sorted(found, key=lambda c: -c.gain)


def folded(bench: Bench, fold: int) -> Bench:
    """The bench with every third window of every drive, from number `fold` on, held out and the rest fitted."""
    fitted, held = [], []
    for shooting in bench.shootings:
        rows = np.arange(len(shooting.rows))
        out = rows[fold::FOLDS]
        held.append(out)
        fitted.append(np.setdiff1d(rows, out))
    return replace(bench, fitted=tuple(fitted), held=tuple(held))
