"""What is left of the axle forces after a model, as a share of what was there, and its correlations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.horizons import bridged
from softsoil.recording.clock import on_even_clock
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.states import measured_states, sensor_std
from softsoil.refinement.residual import WINDOW, drive_residual, rms, slope, split_by_axle
from softsoil.refinement.rules import RULES
from softsoil.symbolic.model import Model
from softsoil.symbolic.vehicle import Vehicle
from softsoil.windows.inputs import measured_inputs

Array = NDArray[np.float64]

AGAIN = 3
"""Times that noise is added once more, to see what it makes of axle forces, and how much that scatters."""
OWN = 17
"""Beside its number, the seed of that noise: a log made with noise of a seed of the user's has none of it."""


@dataclass(frozen=True)
class Structure:
    """Unexplained share of the lateral force per axle (rms over rms), and its correlations.

    share: axle -> rms of the residual force over rms of the force, what sensor noise makes of it taken off, with two standard
    deviations of that; NaN where v or omega_z is not measured; correlations:
    axle -> signal -> coefficient, the strongest first.
    """

    share: dict[str, float]
    correlations: dict[str, dict[str, float]]

    @property
    def left(self) -> bool:
        """Whether more is left than a good model leaves."""
        return any(share > RULES.largest_share for share in self.share.values())

    @property
    def judged(self) -> bool:
        """Whether the drive says anything of axle forces: v and omega_z are measured."""
        return all(np.isfinite(share) for share in self.share.values())


def structure(recording: Recording, model: Model, vehicle: Vehicle, p: Array, start: float) -> Structure:
    """The structure that the model with parameters p (n_p,) leaves in a drive's axle forces."""
    residual = drive_residual(recording, model, vehicle, p, start)
    total_f, total_r, signals = axle_windows(recording, model, vehicle, residual.t)
    left = {"front": residual.force_f, "rear": residual.force_r}
    more = [drive_residual(_noisier(recording, seed), model, vehicle, p, start) for seed in range(AGAIN)]
    noisier = {"front": [rms(one.force_f) ** 2 for one in more], "rear": [rms(one.force_r) ** 2 for one in more]}
    share = {}
    for axle, total in (("front", total_f), ("rear", total_r)):
        square = rms(left[axle]) ** 2
        noise = max(float(np.mean(noisier[axle])) - square, 0.0) + 2.0 * float(np.std(noisier[axle], ddof=1))
        share[axle] = float(np.sqrt(max(square - noise, 0.0)) / max(rms(total), 1e-9))
    correlations = {axle: _correlations(values, signals) for axle, values in left.items()}
    return Structure(share, correlations)


def _noisier(recording: Recording, seed: int) -> Recording:
    """The recording with as much noise on its states once more: what is left of the axle forces grows by what noise makes of it,
    by rates, slips and ruts."""
    sigma = sensor_std(recording, np.zeros(len(STATE_CHANNELS)))
    measured = {name: std for name, std in zip(STATE_CHANNELS, sigma, strict=True) if recording.measured(name)}
    return add_noise(recording, measured, (seed, OWN))


def axle_windows(
    recording: Recording, model: Model, vehicle: Vehicle, middles: Array
) -> tuple[Array, Array, dict[str, Array]]:
    """Lateral force of front and rear axle (N) by the rates of the record alone, and mean signals by name, per window.

    recording, model, vehicle: as of `structure`; middles (M,): middles of the windows (s).
    """
    log = on_even_clock(recording)
    states, (inputs, _) = bridged(measured_states(log), log.dt), measured_inputs(log, model.external)
    half = max(round(WINDOW / log.dt / 2), 1)
    rows = np.searchsorted(log.t, middles)[:, None] + np.arange(-half, half + 1)
    rows = np.clip(rows, 0, len(log) - 1)
    clock = log.dt * np.arange(rows.shape[1])
    psi, u, v, omega_z = (states[:, i][rows] for i in (2, 3, 4, 5))
    rate_v = slope(clock, v) + (u * omega_z).mean(axis=1)
    rate_r = slope(clock, omega_z)
    steer = inputs[:, model.external.index("steer")][rows]
    signals = {
        "steer": steer.mean(axis=1),
        "steer_rate": slope(clock, steer),
        "u": u.mean(axis=1),
        "a_y": (u * omega_z).mean(axis=1),
        "omega_z": omega_z.mean(axis=1),
        "side_slip": (v / np.maximum(u, 0.5)).mean(axis=1),
        "a_x": inputs[:, model.external.index("a_x")][rows].mean(axis=1),
        "cos_heading": np.cos(psi).mean(axis=1),
        "sin_heading": np.sin(psi).mean(axis=1),
        "time": clock.mean() + log.t[rows[:, 0]],
        "constant": np.ones(len(rows)),
    }
    return *split_by_axle(rate_v, rate_r, vehicle), signals


def _correlations(values: Array, signals: dict[str, Array]) -> dict[str, float]:
    found = {}
    for name, signal in signals.items():
        good = np.isfinite(values) & np.isfinite(signal)
        a, b = values[good], signal[good]
        if name == "constant" and len(a):
            found[name] = float(a.mean() / max(np.sqrt(np.mean(a**2)), 1e-12))
        elif len(a) > 3 and a.std() > 0 and b.std() > 0:
            found[name] = float(np.corrcoef(a, b)[0, 1])
    return dict(sorted(found.items(), key=lambda item: -abs(item[1])))
