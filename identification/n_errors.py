"""What moves n of a drive beside the noise of its log: the model's own error, and numbers of the vehicle that nobody measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from softsoil.identification.bench import Bench, fit_numbers
from softsoil.identification.errors import Errors
from softsoil.identification.rules import Rules
from softsoil.recording.drive import Recording
from softsoil.refinement.vehicle_numbers import NUMBERS, expected
from softsoil.windows.parameters import Free
from softsoil.windows.window_fit import WindowFit

Array = NDArray[np.float64]


def model_error(recording: Recording, rolling: bool, rules: Rules) -> float:
    """Share of n by which the model's own error moves it in a drive: more where the side slip is not measured, or not in all logs
    the speed of every wheel (`rolling`)."""
    unseen = (not recording.measured("v")) + (not rolling)
    return float(np.hypot(rules.model_error_n, rules.unseen_error_n * unseen**0.5))


def n_error(n: Sequence[float], std: Sequence[float]) -> float:
    """Error of n that an identified vehicle makes in all drives alike, as a share: root mean square of those of its own drives.

    n, std: of the drives of its fit.
    """
    return float(np.clip(np.sqrt(np.mean((np.array(std) / np.array(n)) ** 2)), 0.0, 1.0))


def n_stds(bench: Bench, n: Sequence[float], errors: Errors, moved: Mapping[str, Array], rules: Rules) -> tuple[float, ...]:
    """Standard deviation of n of each drive: by its log, by the model's own error and by numbers that nobody measured.

    errors: of a fit with every number free; moved: as `unmeasured` returns it.
    """
    rolling = bool(bench.balances)
    stds = []
    for i, (value, recording) in enumerate(zip(n, bench.recordings, strict=True)):
        k = errors.names.index(f"n_{i}")
        shares = [model_error(recording, rolling, rules), *(by[i] for by in moved.values())]
        stds.append(float(np.hypot(np.sqrt(errors.covariance[k, k]), np.linalg.norm(shares) * value)))
    return tuple(stds)


def unmeasured(bench: Bench, free: Sequence[Free], fit: WindowFit, fixed: Mapping[str, float]) -> dict[str, Array]:
    """Number that no log moves and nobody measured -> change of n of each drive (D,), as a share of it, where the number is one
    standard deviation larger and all others are fitted anew.

    free, fit: of a fit with every number free that logs may move; fixed: numbers that it holds elsewhere than they were given.
    One derivative would miss most of it: others change along.
    """
    before = expected(bench.known)
    values = {**fixed, **{f.name: float(v) for f, v in zip(fit.free, fit.value, strict=True) if f.drive is None}}
    n = np.array([float(v) for f, v in zip(fit.free, fit.value, strict=True) if f.drive is not None])
    moved = {}
    for number in NUMBERS:
        if not number.free and bench.known.value(number.name) is None:
            value, std = before[number.name]
            other = fit_numbers(bench, free, {**values, number.name: value + std}, n.tolist())
            there = np.array([float(v) for f, v in zip(other.free, other.value, strict=True) if f.drive is not None])
            moved[number.name] = there / n - 1.0
    return moved
