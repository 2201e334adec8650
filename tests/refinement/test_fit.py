"""The tracing's optimiser against scipy's bounded least squares and closed forms, on residuals with a known answer."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares

from softsoil.refinement.fit import HUBER, Fit, Free, Weights, fit
from softsoil.refinement.trace import Bench
from softsoil.symbolic.signals import Layout, Signal

NAMES = ("a", "b", "c")
WINDOWS, ROWS = 6, 5


@dataclass(frozen=True)
class Parameters:
    """What a fit asks of a model: where its parameters stand."""

    p: Layout = field(default_factory=lambda: Layout(tuple(Signal(name, "", name) for name in NAMES)))


@dataclass(frozen=True)
class Curved:
    """Residuals of a mildly nonlinear problem whose first two columns are nearly alike, with some outliers."""

    columns: np.ndarray
    data: np.ndarray
    model: Parameters = field(default_factory=Parameters)

    def of(self, p: np.ndarray) -> np.ndarray:
        """(M,) residuals for p (3,)."""
        return self.columns @ p + 0.05 * np.sin(self.columns[:, 0] * p[1]) - self.data

    def residual(self, p: np.ndarray, windows: np.ndarray) -> np.ndarray:
        """(..., W, N, 6) for p (..., 3), of the windows asked for."""
        rows = np.atleast_2d(p)
        found = np.array([self.of(row) for row in rows]).reshape(len(rows), WINDOWS, ROWS, 6)[:, windows]
        return found if np.ndim(p) > 1 else found[0]


def problem(seed: int) -> Curved:
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(WINDOWS * ROWS * 6, 3))
    columns[:, 1] = columns[:, 0] + 0.05 * columns[:, 1]
    data = columns @ np.array([2.0, -1.0, 0.5]) + rng.normal(size=len(columns))
    data[::17] += 20.0
    return Curved(columns, data)


def fitted(curved: Curved, free: list[Free], start: np.ndarray) -> Fit:
    return fit([curved], [np.arange(WINDOWS)], Weights(np.ones(6)), free, start, np.zeros((1, 3)))  # type: ignore[list-item]


def box(upper: float) -> list[Free]:
    return [Free(name, (name,), 1.0, -upper, upper) for name in NAMES]


@pytest.mark.parametrize("upper", [0.8, 1.5, 50.0])
@pytest.mark.parametrize("seed", range(4))
def test_the_minimum_in_a_box_is_that_of_scipy(seed: int, upper: float) -> None:
    """0.8 and 1.5 cut the true values off: a step that is cut off at the bounds instead of taken in them goes elsewhere."""
    curved = problem(seed)
    found = fitted(curved, box(upper), np.zeros(3))
    told = least_squares(curved.of, np.zeros(3), bounds=(-upper, upper), loss="huber", f_scale=HUBER, xtol=1e-12)
    size = len(curved.data)
    assert found.cost == pytest.approx(2 * told.cost / size, rel=2e-3)
    assert found.value == pytest.approx(told.x, abs=0.15)


def test_a_start_in_a_corner_leaves_it() -> None:
    curved = problem(5)
    inside = fitted(curved, box(1.5), np.zeros(3))
    corner = fitted(curved, box(1.5), np.array([-1.5, 1.5, 1.5]))
    assert corner.cost == pytest.approx(inside.cost, rel=2e-3)


def test_what_is_known_weighs_as_one_channel_of_a_window() -> None:
    """One parameter, linear: the estimate is the mean of the data's and the known value, weighed by their information."""
    rng = np.random.default_rng(1)
    columns = np.zeros((WINDOWS * ROWS * 6, 3))
    columns[:, 2] = 1.0
    curved = Curved(columns, 1.0 + 0.1 * rng.normal(size=len(columns)))
    free = Free("c", ("c",), 1.0, -10.0, 10.0)
    alone = fitted(curved, [free], np.zeros(1))
    std = 0.5
    both = fitted(curved, [replace(free, known=(3.0, std))], np.zeros(1))
    expected = (6 * WINDOWS * curved.data.mean() + 3.0 / std**2) / (6 * WINDOWS + 1 / std**2)
    assert alone.value[0] == pytest.approx(curved.data.mean(), abs=1e-6)
    assert both.value[0] == pytest.approx(expected, abs=1e-6)
    assert both.std[0] < std


@dataclass(frozen=True)
class Straight:
    """Residuals that are linear in the parameters: a line of (W, N, 6) numbers each."""

    slope: np.ndarray
    data: np.ndarray
    model: Parameters = field(default_factory=Parameters)

    def residual(self, p: np.ndarray, windows: np.ndarray) -> np.ndarray:
        rows = np.atleast_2d(p)
        found = np.einsum("sk,kwni->swni", rows, self.slope)[:, windows] - self.data[windows]
        return found if np.ndim(p) > 1 else found[0]


def test_drives_of_different_rates_are_fitted_together():
    rng = np.random.default_rng(5)
    truth, drives = np.array([2.0, -1.0, 0.5]), []
    for samples in (5, 8):
        slope = rng.normal(size=(3, WINDOWS, samples, 6))
        drives.append(Straight(slope, np.einsum("k,kwni->wni", truth, slope) + 0.1 * rng.normal(size=(WINDOWS, samples, 6))))
    free = tuple(Free(name, (name,), 1.0, -10.0, 10.0) for name in NAMES)
    found = fit(drives, [np.arange(WINDOWS)] * 2, Weights(np.full(6, 0.5)), free, np.zeros(3), np.zeros((2, 3)))
    columns = np.concatenate([one.slope.reshape(3, -1) for one in drives], axis=1).T
    expected = np.linalg.lstsq(columns, np.concatenate([one.data.ravel() for one in drives]), rcond=None)[0]
    np.testing.assert_allclose(found.value, expected, atol=1e-4)


def test_the_floor_of_noise_counts_values_as_the_cost_does():
    """A channel at a tenth of the rate counts a tenth; a sensor cannot be noisier than what is left."""
    recorded = np.zeros((4, 20, 6))
    recorded[:, np.arange(20) % 10 != 0, 0] = np.nan
    sensor = np.array([9.0, 0.1, 0.1, 0.1, 0.1, 0.1])
    bench = SimpleNamespace(shootings=(SimpleNamespace(recorded=recorded),), sensor=sensor, weights=Weights(np.ones(6)))
    assert Bench.floor.fget(bench) == pytest.approx((2 * 1.0 + 100 * 0.01) / 102)
