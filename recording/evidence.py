"""Weak-form evidence: channels compared over short windows by their slopes and means, never by sample-to-sample differences.

The least-squares slope of a channel over a window and the slope of the integral of its claimed rate over the same samples are
the same weighted mean of the rate: noise averages out, and nothing is differentiated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.clock import on_even_clock, unwrapped
from softsoil.recording.drive import Array, Recording
from softsoil.recording.noise_level import noise_level

WINDOW = 0.5
"""s: length of a window, five samples at least."""
SPIKE = 12.0
"""m/s^2: an accelerometer beyond this has been hit."""
SLOWEST = 1.0
"""m/s: below this, mean speed of a window, angles have no meaning."""
HUBER = 2.5
"""Robust standard deviations beyond which a window counts linearly."""

MOSTLY = 0.5
"""Share of a feature's variance from which on it is noise."""
COLLINEAR = 1e-3
"""Least eigenvalue of the features' correlation matrix, below which they cannot be separated."""


@dataclass(frozen=True)
class Line:
    """A robust linear regression.

    value, std (K,): coefficients; r2: share of the variance explained; scale: robust standard deviation of what is left;
    std is infinite where the features do not determine a coefficient; alone (K,): root mean square of what each feature has that
    no combination of the others has; bias (K,): departure that is no evidence, see `disturbed`.
    """

    value: Array
    std: Array
    r2: float
    scale: float
    alone: Array
    bias: Array

    def unattenuated(self, index: int, share: float) -> Line:
        """The line with coefficient number `index` corrected for a feature of whose variance noise is this share.

        Errors in a feature draw its coefficient towards zero by 1 - share; half of the correction counts as uncertain. Of a
        feature that is mostly noise nothing is known.
        """
        if share > MOSTLY:
            return replace(self, std=np.where(np.arange(len(self.std)) == index, np.inf, self.std))
        factor = 1.0 / (1.0 - max(share, 0.0))
        value, std = self.value.copy(), self.std.copy()
        std[index] = factor * std[index] + 0.5 * abs(value[index]) * (factor - 1.0)
        value[index] *= factor
        return replace(self, value=value, std=std)

    def bracketed(self, index: int, reverse: Line) -> Line:
        """The line with coefficient number `index` between itself and what the regression the other way round says.

        reverse: of that feature on y (its coefficient 0) and the other features. Errors in the feature draw this coefficient
        towards zero, errors in y draw that of the reverse, white or not: the truth lies between this one and 1/reverse. Where 1
        does, too, the coefficient is the middle, uncertain by half of the bracket; else it is the end nearer to 1.
        """
        back, error = float(reverse.value[0]), float(reverse.std[0])
        value, std = self.value.copy(), self.std.copy()
        if abs(back) < 2.0 * error or back * value[index] <= 0.0:
            std[index] = np.inf
            return replace(self, value=value, std=std)
        far = error / min(back**2, abs(back))  # as many standard errors from 1 as the reverse itself
        ends = sorted(((float(value[index]), float(std[index])), (1.0 / back, far)))
        (low, low_std), (high, high_std) = ends
        if low < 1.0 < high:
            value[index], std[index] = 0.5 * (low + high), np.hypot(0.5 * (high - low), max(low_std, high_std))
        else:
            value[index], std[index] = ends[0] if low >= 1.0 else ends[1]
        return replace(self, value=value, std=std)

    def disturbed(self, rms: float) -> Line:
        """The line of a y that may hold something unmodelled of root mean square `rms`: what that does to each coefficient at
        worst, where it is in step with the feature, is its bias."""
        return replace(self, bias=rms / np.maximum(self.alone, 1e-12))

    def only(self, index: int) -> Line:
        """The coefficient number `index` alone."""
        one = slice(index, index + 1)
        return replace(self, value=self.value[one], std=self.std[one], alone=self.alone[one], bias=self.bias[one])


def regress(y: Array, *features: Array) -> Line | None:
    """y (M,) on features (M,) each, by iteratively reweighted least squares (Huber); None with fewer than 8 finite rows."""
    columns = np.column_stack(features)
    good = np.isfinite(y) & np.isfinite(columns).all(axis=1)
    y, columns = np.asarray(y[good], dtype=float), np.asarray(columns[good], dtype=float)
    if len(y) < max(8, 2 * columns.shape[1]):
        return None
    weight: Array = np.ones(len(y), dtype=float)
    value: Array = np.zeros(columns.shape[1])
    for _ in range(8):
        weighted = columns * weight[:, None]
        value = np.asarray(np.linalg.lstsq(weighted.T @ columns, weighted.T @ y, rcond=1e-12)[0], dtype=np.float64)
        left = y - columns @ value
        scale = 1.4826 * float(np.median(np.abs(left))) + 1e-12
        weight = np.asarray(np.minimum(1.0, HUBER * scale / np.maximum(np.abs(left), 1e-300)), dtype=float)
    weighted = columns * weight[:, None]
    normal = weighted.T @ columns
    inverse = np.linalg.pinv(normal, rcond=1e-12)
    meat = (weighted * left[:, None]).T @ (weighted * left[:, None])
    std = np.sqrt(np.maximum(np.diag(inverse @ meat @ inverse), 0.0))
    std[_undetermined(normal)] = np.inf
    alone = 1.0 / np.sqrt(np.maximum(np.diag(inverse), 1e-300) * max(float(weight.sum()), 1e-300))
    total = float(np.sum(weight * (y - np.average(y, weights=weight)) ** 2))
    r2 = 1.0 - float(np.sum(weight * left**2)) / total if total > 1e-12 else 0.0
    return Line(value, std, r2, scale, alone, np.zeros(len(value)))


def _undetermined(normal: Array) -> NDArray[np.bool_]:
    """(K,) coefficients that features hardly tell from each other, from the normal matrix (K, K)."""
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, axes = np.linalg.eigh(normal / np.outer(size, size))
    return (np.abs(axes[:, values < COLLINEAR]) > 0.1).any(axis=1)


@dataclass(frozen=True)
class Motion:
    """A drive on an even clock, cut into windows side by side.

    log: the drive; size: samples per window; channels that the drive has are asked for by name.
    """

    log: Recording
    size: int

    @classmethod
    def of(cls, recording: Recording) -> Motion:
        """The windows of a recording, WINDOW seconds or five samples long."""
        log = on_even_clock(recording)
        return cls(log, max(round(WINDOW / log.dt), 5))

    @property
    def windows(self) -> int:
        """Number of whole windows."""
        return len(self.log) // self.size

    def channel(self, name: str) -> Array:
        """(N,) the channel called `name`, psi unwrapped, spikes of accelerometers left out; NaN where missing or not measured."""
        if not self.log.measured(name):
            return np.full(len(self.log), np.nan)
        values = self.log[name]
        if name.startswith("a_"):
            return np.where(np.abs(values) > SPIKE, np.nan, values)
        return unwrapped(name, values)

    def rows(self, values: Array) -> Array:
        """(windows, size) a channel `values` (N,) cut into windows."""
        return values[: self.windows * self.size].reshape(self.windows, self.size)

    def mean(self, values: Array) -> Array:
        """(windows,) mean of values (N,) over each window; NaN where none is finite."""
        rows = self.rows(values)
        good = np.isfinite(rows)
        count = good.sum(axis=1)
        return np.where(count > 0, np.where(good, rows, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)

    def slope(self, values: Array, where: Array | None = None) -> Array:
        """(windows,) least-squares slope of values (N,) over its finite samples, or over those where `where` (N,) is finite."""
        rows = self.rows(values)
        good: NDArray[np.bool_] = np.isfinite(rows) & (np.isfinite(self.rows(where)) if where is not None else True)
        count = good.sum(axis=1)
        clock = self.log.dt * np.arange(self.size) * np.ones_like(rows)
        middle = np.where(good, clock, 0.0).sum(axis=1) / np.maximum(count, 1)
        away = np.where(good, clock - middle[:, None], 0.0)
        square = (away**2).sum(axis=1)
        enough = (count >= 3) & (square > 0.3 * (self.size * self.log.dt) ** 2 / 12 * count)
        return np.where(enough, (away * np.where(good, rows, 0.0)).sum(axis=1) / np.maximum(square, 1e-12), np.nan)

    def slope_noise(self, name: str) -> float:
        """Variance that sensor noise makes of the slope of the channel called `name` over a window, from third differences."""
        return 12.0 * self.mean_noise(name) / (self.size * self.log.dt) ** 2

    def mean_noise(self, name: str) -> float:
        """Variance that sensor noise makes of the mean of the channel called `name` over a window, from third differences."""
        values = self.channel(name)
        samples = self.size * float(np.isfinite(values).mean())  # of a channel slower than the clock, fewer than rows
        return noise_level(values, self.log.dt).white ** 2 / max(samples, 1.0)

    def integral(self, rate: Array) -> Array:
        """(N,) integral of rate (N,) from the start; short gaps are bridged, windows inside long ones stay NaN."""
        filled = interpolated(rate, round(1.0 / self.log.dt))
        total = np.cumsum(np.nan_to_num(filled)) * self.log.dt
        return np.where(np.isfinite(filled), total - 0.5 * np.nan_to_num(filled) * self.log.dt, np.nan)

    @cached_property
    def speed(self) -> Array:
        """(windows,) mean of u."""
        return self.mean(self.channel("u"))

    @cached_property
    def driving(self) -> NDArray[np.bool_]:
        """(windows,) whether the vehicle drives forwards fast enough for angles to mean something."""
        return np.nan_to_num(self.speed) > SLOWEST

    def driven(self, values: Array) -> Array:
        """values (windows,) with NaN where the vehicle does not drive."""
        return np.where(self.driving, values, np.nan)


def interpolated(values: Array, reach: int) -> Array:
    """(N,) values (N,) with gaps of up to `reach` samples filled by straight lines; longer gaps stay NaN."""
    good = np.isfinite(values)
    if good.all() or not good.any():
        return values
    rows = np.arange(len(values))
    at = np.flatnonzero(good)
    filled = np.interp(rows, at, values[good])
    after = np.searchsorted(at, rows)
    before = np.clip(after - 1, 0, len(at) - 1)
    width = at[np.clip(after, 0, len(at) - 1)] - at[before]
    outside = (rows < at[0]) | (rows > at[-1])
    return np.where(good | ((width <= reach) & ~outside), filled, np.nan)


def filled(values: Array) -> Array:
    """Values (N,) with lines where numbers are missing, the nearest at the ends; zeros where there are none at all."""
    good, rows = np.isfinite(values), np.arange(len(values))
    return np.interp(rows, rows[good], values[good]) if good.any() else np.zeros(len(values))


def lagged(a: Array, b: Array, lag: int, about_zero: bool = False) -> float:
    """Correlation of a (M,) with b (M,) `lag` samples before, where both are numbers, about their means or, with `about_zero`,
    about zero; 0 where one of them is constant."""
    first, second = (a[max(lag, 0) : len(a) + min(lag, 0)], b[max(-lag, 0) : len(b) + min(-lag, 0)])
    both = np.isfinite(first) & np.isfinite(second)
    first, second = first[both], second[both]
    if about_zero:
        return float(np.sum(first * second) / max(float(np.sqrt(np.sum(first**2) * np.sum(second**2))), 1e-12))
    if len(first) < 2 or np.std(first) < 1e-12 or np.std(second) < 1e-12:
        return 0.0
    return float(np.corrcoef(first, second)[0, 1])
