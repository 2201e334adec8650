"""What a drive says about an estimate of n: excitation, dependence on the initial guess, axles, and what the model leaves.

All of it from windows with free initial states: the one-step innovations of a filter cannot show a wrong model, since its process
noise has been opened until they fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.inertia import inertia_error
from softsoil.estimator.late_change import parts_of
from softsoil.estimator.modes import run_guess, standing
from softsoil.estimator.moving_horizon import HorizonRules, MovingHorizon, exponents
from softsoil.estimator.soil_error import SoilError, soil_error
from softsoil.estimator.strain import VehicleChange, vehicle_change
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.noise_level import noise_level, own_samples, third_differences
from softsoil.symbolic.vehicle import JUDGED
from softsoil.windows.free_windows import FreeWindows
from softsoil.windows.window_fit import reduce_windows

Array = NDArray[np.float64]

TRIMMED = 4.0
"""Third differences beyond this many robust standard deviations are outliers or steps, not noise."""


@dataclass(frozen=True)
class Evidence:
    """Numbers that a verdict rests on.

    n, std: at the end of the drive, from windows, per axle or one for both; information_std: of n by sensor noise and model error
    alone, without the initial guess; by_guess: final n from each initial guess (G, A) whose run stands (`modes.standing`); guess:
    the first of these, which all the rest is from; left_out: guess, final n at the front, and share by which its windows cost
    more, of each run that does not stand; n_axles, axles_std (2,): n of the front and of the rear axle, fitted separately;
    unexplained, unexplained_std: mean square that the model leaves of each lateral channel beyond sensor noise, as a share of the
    channel's own mean square, and its standard error; inertia, inertia_std: share by which the drive would have the yaw inertia
    larger than declared, and its standard deviation; soil: what errors of the soil's class and of the law make of n; change: of
    the vehicle against its file, None where that states no errors; parts (2,), parts_sigmas: n of an earlier and of the later
    part of the present soil where these differ most, and by how many standard deviations; motion: root mean square lateral
    specific force u omega_z (m/s^2); windows: how many; changes: times at which windows of another soil begin (s); late: seconds
    by which a low-pass has made the yaw rate late, by the noise that it leaves.
    """

    n: Array
    std: Array
    information_std: Array
    by_guess: Array
    n_axles: Array
    axles_std: Array
    unexplained: dict[str, float]
    unexplained_std: dict[str, float]
    inertia: float
    inertia_std: float
    soil: SoilError
    change: VehicleChange | None
    parts: Array
    parts_sigmas: float
    motion: float
    windows: int
    guess: float
    left_out: tuple[tuple[float, float, float], ...] = ()
    changes: tuple[float, ...] = ()
    late: float = 0.0


def gather(windows: FreeWindows, guesses: Sequence[float], tied: bool, rules: HorizonRules | None = None) -> Evidence:
    """Evidence on n over the windows of one drive.

    guesses: initial guesses of n, the first of them the user's; tied: one n for both axles.
    """
    rules = rules or HorizonRules()
    runs, left_out = standing([run_guess(windows, guess, tied, rules) for guess in guesses])
    first = runs[0].horizon
    windows.follow(first.parameters(first.n), np.array(first.summary.states))  # histories of this run, not of the last one
    last = len(windows.rows) - 1
    weight = first.weight(last)
    n, soil, information = first.n.copy(), soil_error(windows, first), np.sqrt(first.summary.variance(first.n, weight))
    std = np.hypot(first.std(last), soil.more * n)
    axles, axles_std = _by_axle(windows, first, tied, rules)
    left = unexplained(windows, first)
    return Evidence(
        n, std, information, np.array([run.horizon.n for run in runs]), axles, axles_std, *left,
        *inertia_error(windows, first), soil, vehicle_change(windows, first),
        *parts_of(first.summary, first.since, first.share, last),
        motion_of(windows), len(windows.rows), runs[0].guess,
        tuple((run.guess, float(run.horizon.n[0]), run.worse) for run in left_out),
        tuple(float(windows.drive.t[row]) for row in first.changes),
        noise_level(_beneath(windows, "omega_z", windows.under()), windows.drive.dt).late,
    )  # fmt: skip


def _by_axle(windows: FreeWindows, horizon: MovingHorizon, tied: bool, rules: HorizonRules) -> tuple[Array, Array]:
    """n of each axle from one step of both, at the estimate."""
    last = len(windows.rows) - 1
    if not tied:
        return horizon.n, horizon.std(last)
    apart = MovingHorizon(windows, exponents(False), float(horizon.n[0]), rules)
    which = np.arange(last + 1)
    apart.take(which, [horizon.summary.states[i] for i in which])
    weight = horizon.weight(last)
    prior = np.full(2, float(horizon.n[0])), np.full(2, rules.prior)
    n, _ = apart.summary.minimum(weight, prior)
    return n, np.sqrt(apart.summary.variance(n, weight, prior))


def _beneath(windows: FreeWindows, name: str, rows: NDArray[np.intp]) -> Array:
    """(N,) a channel at rows of the drive, NaN at the others: differences of its samples span no gap between windows."""
    kept = np.full(len(windows.drive.measured), np.nan)
    kept[rows] = windows.drive.measured[rows, STATE_CHANNELS.index(name)]
    return kept


def motion_of(windows: FreeWindows) -> float:
    """Root mean square lateral specific force u omega_z under the windows (m/s^2)."""
    speed, turn = (windows.drive.smooth[windows.under(), STATE_CHANNELS.index(name)] for name in ("u", "omega_z"))
    return float(np.sqrt(np.mean((speed * turn) ** 2)))


def unexplained(windows: FreeWindows, horizon: MovingHorizon) -> tuple[dict[str, float], dict[str, float]]:
    """Share of the mean square of each channel of JUDGED, under the windows, that the model leaves beyond sensor noise, and its
    standard error.

    horizon: run to the end of the drive, whose n and initial states the histories of the windows follow.
    """
    which = np.arange(horizon.since, len(windows.rows))  # windows of an earlier soil are no fault of the model
    under = windows.under(which)
    x0 = np.array(horizon.summary.states)[which]
    linear = windows.linearise(horizon.parameters(horizon.n), x0, horizon.free, which)
    reduced = reduce_windows(linear)
    leverage = np.einsum("wmi,wij,wmj->wm", linear.by_state, reduced.inverse, linear.by_state)
    shape = windows.recorded[which].shape
    # All derivatives are 0 where the model has no finite answer: such a window says nothing.
    sound = np.abs(linear.by_state).max(axis=(1, 2))[:, None] > 0.0
    residual, leverage = linear.residual.reshape(shape) * windows.sigma, leverage.reshape(shape)
    shares, errors = {}, {}
    for name in JUDGED:
        i = STATE_CHANNELS.index(name)
        seen = np.isfinite(windows.recorded[which][..., i]) & sound
        if not seen.any() or not np.isfinite(windows.sigma[i]):
            continue
        # Medians over windows: a few that hit an obstacle or a kick of the steering are no fault of the model.
        per_window = (residual[..., i] ** 2).sum(axis=1) / np.maximum((seen - leverage[..., i] * seen).sum(axis=1), 1.0)
        per_window = per_window[seen.any(axis=1)]
        noise, noise_error = sensor_variance(_beneath(windows, name, under), windows.drive.dt)
        left, count = float(np.median(per_window)), len(per_window)
        motion = float(np.nanmean(windows.drive.smooth[under, i] ** 2)) + 1e-12
        error = max(float(np.hypot(1.25 * float(per_window.std()) / np.sqrt(count), noise_error)), 1e-15)
        shares[name], errors[name] = (left - noise) / motion, error / motion
    return shares, errors


def sensor_variance(values: Array, dt: float) -> tuple[float, float]:
    """Variance of a channel's noise from its third differences, and the standard error of that.

    values (N,): NaN between the samples of a channel that is slower than the clock; dt: of the clock (s).
    A smooth signal sampled finely has third differences of its noise only, of variance 20 sigma^2; they are correlated over four
    samples, which makes the error sqrt(4.6/N) of the variance. Of correlated noise (`noise_level`) they show a share, and fewer
    samples count.
    """
    own, _, stretch = own_samples(values, dt)
    third = third_differences(own, stretch)
    if len(third) < 8:
        return 0.0, np.inf
    robust = 1.4826 * float(np.median(np.abs(third))) + 1e-15
    kept = third[np.abs(third) < TRIMMED * robust]
    level = noise_level(values, dt)
    seen, alike = (level.std / max(level.rough, 1e-15)) ** 2, (level.white / max(level.std, 1e-15)) ** 2
    variance = seen * float(np.mean(kept**2)) / 20.0
    return variance, variance * float(np.sqrt(4.6 * alike / len(kept)))


def percent_above(share: float, limit: float) -> str:
    """A share in per cent, 999 at most, with as many decimals, up to two, as show that it is above its limit, a share, too."""
    texts = [f"{100 * min(share, 9.99):.{decimals}f}" for decimals in range(3)]
    return next((text for text in texts if float(text) > 100 * limit), texts[-1])
