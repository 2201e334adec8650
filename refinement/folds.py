"""Candidates judged on the whole drive: a third of its windows at a time, by a fit to the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from softsoil.refinement.fit import Fit, fit
from softsoil.refinement.rules import RULES
from softsoil.refinement.trace import Bench, Candidate, everything, fit_base, gain_of, held_cost, of_effect

Array = NDArray[np.float64]



def cross_validated(
    bench: Bench, candidates: Sequence[Candidate], workers: int = 1, one_wave: bool = False
) -> list[Candidate]:
    """The candidates with gain, its standard error and windows over all folds, and a fit to all windows; best gain first.

    A third of the windows is held out in turns: a few held-out windows tell a small effect from none only by luck.
    workers: threads; one_wave: as of `folded`.
    """
    if not candidates:
        return []
    parts = [folded(bench, fold, one_wave) for fold in range(RULES.folds)]

    def again(candidate: Candidate, part: Bench, errors: bool = False) -> Fit:
        tried = candidate.fit
        more = {"settle": False, "errors": errors}
        return of_effect(part, fit(part.shootings, part.fitted, part.weights, tried.free, tried.value, tried.p, **more))

    jobs = [delayed(lambda part: held_cost(part, fit_base(part).p))(part) for part in parts]
    jobs += [delayed(lambda c, part: held_cost(part, again(c, part).p))(c, part) for c in candidates for part in parts]
    jobs += [delayed(again)(candidate, everything(bench), errors=True) for candidate in candidates]
    done = Parallel(n_jobs=workers, prefer="threads")(jobs)
    ends = RULES.folds * (1 + np.arange(1 + len(candidates)))
    before, *after = [np.concatenate(done[end - RULES.folds : end]) for end in ends]

    def judged(candidate: Candidate, cost: Array, overall: Fit) -> Candidate:
        gain, std = gain_of(before, cost, bench.floor)
        whole = float(1.0 - cost.sum() / before.sum())
        return replace(candidate, windows=cost, gain=gain, std=std, whole=whole, overall=overall)

    return sorted(map(judged, candidates, after, done[ends[-1] :]), key=lambda c: -c.gain)


def folded(bench: Bench, fold: int, one_wave: bool = False) -> Bench:
    """The bench with a third of every drive's windows, number `fold`, held out and the rest fitted.

    Every third window, so that what is met on a part of a drive, as a change of soil, is both fitted and judged in every turn;
    a contiguous third where the steering repeats one wave: there, neighbouring windows are copies of each other.
    """
    fitted, held = [], []
    for shooting in bench.shootings:
        rows = np.arange(len(shooting.rows))
        out = np.array_split(rows, RULES.folds)[fold] if one_wave else rows[fold::RULES.folds]
        held.append(out)
        fitted.append(np.setdiff1d(rows, out))
    return replace(bench, fitted=tuple(fitted), held=tuple(held))
