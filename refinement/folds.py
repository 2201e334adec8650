"""Candidates judged on the whole drive: each third by a fit to the two others."""

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
"""The last third is what the ranking holds out; the first two are held out in their turns."""


def cross_validated(bench: Bench, candidates: Sequence[Candidate], workers: int = 1) -> list[Candidate]:
    """The candidates with gain, its standard error and windows over all folds, best gain first.

    Contiguous thirds of every drive are held out in turns; the bench's own fit windows and held-out windows are the last
    turn. A few held-out windows tell a small effect from none only by luck: three times as many tell more. workers: threads.
    """
    if not candidates:
        return []
    parts = [folded(bench, fold) for fold in range(FOLDS - 1)]
    bases = [fit_base(part).p for part in parts]
    before = np.concatenate(
        [*(held_cost(part, p) for part, p in zip(parts, bases, strict=True)), held_cost(bench, bench.absent)]
    )

    def one(candidate: Candidate) -> Candidate:
        costs = []
        for part in parts:
            found = fit(
                part.shootings, part.fitted, part.weights, candidate.fit.free, candidate.fit.value, candidate.fit.p
            )
            costs.append(held_cost(part, found.p))
        after = np.concatenate([*costs, held_cost(bench, candidate.fit.p)])
        gain, std = gain_of(before, after, bench.floor)
        whole = float(1.0 - after.sum() / before.sum())
        return replace(candidate, windows=after, gain=gain, std=std, whole=whole)

    found = Parallel(n_jobs=workers, prefer="threads")(delayed(one)(candidate) for candidate in candidates)
    return sorted(found, key=lambda c: -c.gain)


def folded(bench: Bench, fold: int) -> Bench:
    """The bench with one third of every drive's windows, number `fold`, held out and the rest fitted."""
    fitted, held = [], []
    for shooting in bench.shootings:
        rows = np.arange(len(shooting.rows))
        out = np.array_split(rows, FOLDS)[fold]
        held.append(out)
        fitted.append(np.setdiff1d(rows, out))
    return replace(bench, fitted=tuple(fitted), held=tuple(held))
