"""Sensors: noise, bias, scale, lever arm, delay, dropouts and outliers on the channels of a clean recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import CHANNEL_UNITS, Recording
from softsoil.recording.noise import add_noise

Array = NDArray[np.float64]

COMMANDS = ("steer", "throttle", "brake")
"""Channels that are known, not measured: no dropouts and no delay on them."""
ODOMETRY = ("x", "y", "psi", "u", "v", "omega_z")


@dataclass(frozen=True)
class Sensors:
    """What the sensors do to a drive, in this order: lever arm, delay, scale, bias, noise, outliers, dropouts.

    noise: "none", "table5" (the paper's), "good", or standard deviations by channel; bias: added, by channel, in the
    channel's unit; scale: multiplied, by channel; lever_arm: x, y (m) from where a sensor is thought to be to where it
    is: position, u, v and the accelerations are those of the point there; delay (s) by channel, or one for all under
    "all"; dropout: share of rows lost, in gaps of `gap` s on average (NaN in every measured channel); outliers: share
    of values hit, by `outlier_size` standard deviations of the noise (or of the channel where it has none).
    ValueError for a channel that is unknown or known without a sensor (time, steering, pedals), a negative delay, or a share
    outside [0, 1).
    """

    noise: str | Mapping[str, float] = "none"
    bias: Mapping[str, float] = field(default_factory=dict)
    scale: Mapping[str, float] = field(default_factory=dict)
    lever_arm: tuple[float, float] = (0.0, 0.0)
    delay: Mapping[str, float] = field(default_factory=dict)
    dropout: float = 0.0
    gap: float = 0.2
    outliers: float = 0.0
    outlier_size: float = 10.0

    def __post_init__(self) -> None:
        sensed = [name for name in CHANNEL_UNITS if name != "t" and name not in COMMANDS]
        noise = {} if isinstance(self.noise, str) else self.noise
        for kind, table in (("bias", self.bias), ("scale", self.scale), ("delay", self.delay), ("noise", noise)):
            known = [*sensed, *(["all"] if kind == "delay" else ["steer"] if kind == "noise" else [])]
            for name in table:
                if name not in known:
                    raise ValueError(f"sensors: {kind}: expected some of {', '.join(known)}; found {name!r}")
        if any(value < 0 for value in self.delay.values()):
            raise ValueError(f"sensors: expected delays >= 0 s, found {dict(self.delay)}")
        if not (0 <= self.dropout < 1 and 0 <= self.outliers < 1 and self.gap > 0):
            raise ValueError(
                f"sensors: expected dropout and outliers in [0, 1) and gap > 0, "
                f"found {self.dropout}, {self.outliers}, {self.gap}"
            )

    def apply(self, clean: Recording, seed: int = 0) -> Recording:
        """The drive as these sensors record it; the truth stays. The same seed gives the same numbers."""
        rng = np.random.default_rng([seed, 1])
        measured = [name for name in clean.channels if name != "t" and name not in COMMANDS]
        drive = _at_lever(clean, *self.lever_arm) if any(self.lever_arm) else clean
        channels = {name: np.array(values) for name, values in drive.channels.items()}
        for name in measured:
            late = self.delay.get(name, self.delay.get("all", 0.0))
            if late > 0:
                past = np.interp(drive.t - late, drive.t, np.unwrap(channels[name]) if name == "psi" else channels[name])
                wraps = name == "psi" and np.abs(channels[name]).max() <= np.pi
                channels[name] = np.arctan2(np.sin(past), np.cos(past)) if wraps else past
            channels[name] = self.scale.get(name, 1.0) * channels[name] + self.bias.get(name, 0.0)
        clear = channels
        noisy = add_noise(replace(drive, channels=channels), self.noise, seed)
        channels = dict(noisy.channels)
        for name in measured:
            if self.outliers > 0:
                spread = float(np.std(channels[name] - clear[name])) or float(np.std(channels[name]))
                hit = rng.random(len(clean)) < self.outliers
                jump = self.outlier_size * spread * rng.choice([-1.0, 1.0], len(clean))
                channels[name] = np.where(hit, channels[name] + jump, channels[name])
        if self.dropout > 0:
            lost = _gaps(len(clean), self.dropout, max(self.gap / clean.dt, 1.0), rng)
            for name in measured:
                channels[name] = np.where(lost, np.nan, channels[name])
        return replace(clean, channels=channels)


def _at_lever(drive: Recording, a: float, b: float) -> Recording:
    """Position, velocity and acceleration of the point (a, b) from the sensors' nominal places, in the yaw frame."""
    c, s, w = np.cos(drive["psi"]), np.sin(drive["psi"]), drive["omega_z"]
    turn = np.gradient(w, drive.t)
    return drive.with_channels(
        x=drive["x"] + a * c - b * s,
        y=drive["y"] + a * s + b * c,
        u=drive["u"] - b * w,
        v=drive["v"] + a * w,
        a_x_imu=drive["a_x_imu"] - a * w**2 - b * turn,
        a_y_imu=drive["a_y_imu"] - b * w**2 + a * turn,
    )


def _gaps(rows: int, share: float, length: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Rows lost: a two-state chain whose gaps last `length` rows on average and cover `share` of the drive; longer ones where
    that share leaves no row between them."""
    end = min(1.0 / length, (1.0 - share) / share)
    begin = end * share / (1.0 - share)
    lost = np.zeros(rows, dtype=bool)
    out = False
    for k, draw in enumerate(rng.random(rows)):
        out = draw >= end if out else draw < begin
        lost[k] = out
    return lost
