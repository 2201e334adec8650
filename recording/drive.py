"""A recorded drive: named channels on one clock, with the evaluation-only truth beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHANNEL_UNITS: Mapping[str, str] = MappingProxyType(
    {
        "t": "s",
        "x": "m",
        "y": "m",
        "psi": "rad",
        "u": "m/s",
        "v": "m/s",
        "omega_z": "rad/s",
        "a_x_imu": "m/s^2",
        "a_y_imu": "m/s^2",
        "steer": "rad",
        "throttle": "",
        "brake": "",
        "omega_fl": "rad/s",
        "omega_fr": "rad/s",
        "omega_rl": "rad/s",
        "omega_rr": "rad/s",
    }
)
"""The drive columns and their units: ISO 8855, (x, y) on the front axle, (u, v) at the centre of gravity."""

STATE_CHANNELS = ("x", "y", "psi", "u", "v", "omega_z")
UNSEEN = (1.0, 1.0, 0.1, 1.0, 0.5, 0.2)
"""Standard deviations of a first x, y, psi, u, v, omega_z that was not measured, SI units."""
WHEEL_CHANNELS = ("omega_fl", "omega_fr", "omega_rl", "omega_rr")
SAME_RATE = 5e-4
"""Share of an interval of samples that is rounding of stamps, a logger's clock and jitter: in a second, 3 mm at 6 m/s."""
TRUTH_PREFIX = "true_"
CHECKED = "checked"
"""Key of `Recording.meta` of a drive whose channels have been checked against each other."""

ChannelState = Literal["measured", "derived", "absent"]
"""measured: a sensor's own; derived: computed from other channels, so that it judges nothing; absent: not in the log."""


@dataclass(frozen=True)
class Recording:
    """One drive.

    name: file stem or manoeuvre; channels: sensor channels by name, each (N,), SI units as in CHANNEL_UNITS, all on `t`;
    truth: clean `true_*` columns, for evaluation only (nothing that estimates or traces may touch it);
    notes: what the reader did to the data (gaps, outliers), one sentence each; meta: free text facts such as the soil;
    state: of channels that are not plainly measured, "measured", "derived" or "absent"; origin: latitude and longitude (deg) of
    x = y = 0, where x points east and y north; ruts: start and end (s) of each stretch in which wheels run in ruts of earlier in
    the drive, which `usable` finds.
    Raises ValueError where lengths differ, `t` does not increase or a state is none of the three.

    Example:
        >>> import numpy, softsoil
        >>> drive = softsoil.Recording("still", {"t": numpy.arange(3.0), "u": numpy.zeros(3)})
        >>> len(drive), drive.dt
        (3, 1.0)
    """

    name: str
    channels: Mapping[str, Array]
    truth: Mapping[str, Array] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    meta: Mapping[str, str] = field(default_factory=dict)
    state: Mapping[str, ChannelState] = field(default_factory=dict)
    origin: tuple[float, float] | None = None
    ruts: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        for key, value in self.state.items():
            if value not in ("measured", "derived", "absent"):
                raise ValueError(f"{self.name}: state of {key}: expected measured, derived or absent; found {value!r}")
        if "t" not in self.channels:
            raise ValueError(f"{self.name}: expected a channel 't', found {', '.join(self.channels) or 'none'}")
        length = len(self.channels["t"])
        for key, values in {**self.channels, **self.truth}.items():
            if np.shape(values) != (length,):
                raise ValueError(f"{self.name}: channel {key}: expected shape ({length},), found {np.shape(values)}")
        steps = np.diff(self.channels["t"])
        if length > 1 and not np.all(steps > 0):
            row = int(np.argmin(steps > 0)) + 1
            raise ValueError(f"{self.name}: channel t: expected increasing time, found {self.t[row]} at sample {row}")

    @property
    def t(self) -> Array:
        """(N,) time, s."""
        return self.channels["t"]

    @property
    def dt(self) -> float:
        """Mean interval of the samples, s, the shortest number within SAME_RATE: logs of one rate share compiled models.
        ValueError for fewer than two samples."""
        if len(self) < 2:
            raise ValueError(f"{self.name}: expected two samples or more, found {len(self)}")
        steps = np.diff(self.t)
        every = float(np.median(steps))
        for _ in range(2):  # the median of jittered steps is a little off, which miscounts those of a long gap
            every = float(steps.sum() / np.rint(steps / every).sum())
        rounded = (float(f"{every:.{digits}g}") for digits in range(1, 6))
        return next((short for short in rounded if abs(short - every) <= SAME_RATE * every), every)

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: str) -> Array:
        """A sensor channel; KeyError names what there is."""
        try:
            return self.channels[name]
        except KeyError:
            raise KeyError(f"{self.name}: expected one of {', '.join(self.channels)}; found {name!r}") from None

    def __contains__(self, name: str) -> bool:
        return name in self.channels

    def state_of(self, name: str) -> ChannelState:
        """State of the channel called `name`; a channel without a number is absent."""
        if name not in self.channels or not np.isfinite(self.channels[name]).any():
            return "absent"
        return self.state.get(name, "measured")

    def measured(self, *names: str) -> bool:
        """Whether all channels of these names are a sensor's own."""
        return all(self.state_of(name) == "measured" for name in names)

    def stack(self, *names: str) -> Array:
        """(N, len(names)) sensor channels side by side."""
        return np.column_stack([self[name] for name in names])

    def between(self, start: float, stop: float) -> Recording:
        """The part with start <= t < stop (s)."""
        keep = (self.t >= start) & (self.t < stop)
        return replace(
            self,
            channels={key: values[keep] for key, values in self.channels.items()},
            truth={key: values[keep] for key, values in self.truth.items()},
        )

    def with_channels(self, **channels: Array) -> Recording:
        """The same drive with channels replaced or added; it is to be checked again."""
        meta = {key: value for key, value in self.meta.items() if key != CHECKED}
        return replace(self, channels={**self.channels, **channels}, meta=meta)
