"""Single-wheel runs: the motion of one wheel, the load it carries and the forces the soil gave, in the wheel frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RIG_RADIUS, RIG_WIDTH, RIG_ARM = 0.330229, 0.2121, 0.3
"""The reference rig: wheel radius and width, wheel centre to the left of its yaw axis (m)."""
RIG_ZERO = 0.5
"""m: `wheel_z` is zero where the wheel's lowest point is this high above the soil."""
RIG_STEP = 1e-3
RIG_PATCH = 1.6
"""s: time step of the reference rig's runs."""
SMOOTHING = 0.025
"""s: loads and forces are compared as means over this time."""
SOIL_KEYS = ("k_phi", "k_c", "n", "c", "phi", "k")
_CONDITIONS = (*SOIL_KEYS, "load", "slip", "speed")
_SERIES = ("wheel_yaw", "omega", "fx", "fy", "fz")


@dataclass(frozen=True)
class WheelRun:
    """One run of one wheel.

    name; group: soil class, for tables; soil: parameters by name (SI); radius, width: of the wheel (m);
    slip: nominal longitudinal slip (paper's sign). All else (N,), SI: dt: sample interval (s), None for steady rows;
    v_x, v_y, omega, yaw_rate, steer_rate, dv_y, load: as in symbolic.wheel.Contact; f_x, f_y: measured force on the wheel
    in the wheel frame (N); yaw: wheel frame against the frame in which the lateral force is judged (rad);
    sinkage (m) and m_y (N m): where measured; contact_step, patch_length: time step of a simulated soil (s) and the
    length over radius of the patch that its contact search finds, 0 for a real soil;
    reference_rig: whether the reference simulator's rig made it, whose numerics a calibration may know.
    Raises ValueError where lengths differ or a value is not finite.
    """

    name: str
    group: str
    soil: Mapping[str, float]
    radius: float
    width: float
    slip: float
    dt: float | None
    v_x: Array
    v_y: Array
    omega: Array
    yaw_rate: Array
    steer_rate: Array
    dv_y: Array
    load: Array
    f_x: Array
    f_y: Array
    yaw: Array
    sinkage: Array | None = None
    m_y: Array | None = None
    contact_step: float = 0.0
    patch_length: float = 0.0
    reference_rig: bool = False

    def __post_init__(self) -> None:
        length = len(self.v_x)
        for key in (*MOTION, "f_x", "f_y", "yaw", "sinkage", "m_y"):
            values = getattr(self, key)
            if values is None:
                continue
            if np.shape(values) != (length,):
                raise ValueError(f"{self.name}: {key}: expected shape ({length},), found {np.shape(values)}")
            if not np.all(np.isfinite(values)):
                row = int(np.argmin(np.isfinite(values)))
                raise ValueError(f"{self.name}: {key}: expected finite numbers, found {values[row]} at sample {row}")

    def __len__(self) -> int:
        return len(self.v_x)

    def motion(self) -> Array:
        """(7, N): v_x, v_y, omega, load, yaw_rate, steer_rate, dv_y, in the order of softsoil.symbolic.wheel.Contact."""
        return np.array([getattr(self, key) for key in MOTION])

    def lateral(self, f_x: Array, f_y: Array) -> Array:
        """Force to the left in the frame of judgement (N), of a force in the wheel frame."""
        return f_x * np.sin(self.yaw) + f_y * np.cos(self.yaw)

    def longitudinal(self, f_x: Array, f_y: Array) -> Array:
        """Force forward in the frame of judgement (N), of a force in the wheel frame."""
        return f_x * np.cos(self.yaw) - f_y * np.sin(self.yaw)

    def smooth(self, values: Array) -> Array:
        """Centred mean of values (N,) over SMOOTHING; steady rows stay as they are."""
        if self.dt is None:
            return np.asarray(values, dtype=float)
        return moving_mean(values, max(1, round(SMOOTHING / self.dt)))


MOTION = ("v_x", "v_y", "omega", "load", "yaw_rate", "steer_rate", "dv_y")


def moving_mean(values: Array, width: int) -> Array:
    """Centred mean of values (N,) over `width` samples (an odd number is used), ends held."""
    half = width // 2
    padded = np.pad(np.asarray(values, dtype=float), half, mode="edge")
    kernel = np.full(2 * half + 1, 1.0 / (2 * half + 1))
    return np.convolve(padded, kernel, "valid")


def read_rig(path: str | Path) -> list[WheelRun]:
    """Runs of a `chrono_rig` archive (npz with conditions, t, series, channels).

    The wheel centre stands RIG_ARM to the left of the axis it yaws about: v_x = v cos(psi) - arm dpsi/dt,
    v_y = -v sin(psi), yaw rate dpsi/dt. Forces are turned from the travel frame into the wheel frame; the load is the
    soil's own fz, smoothed. Raises ValueError naming the file, what was expected and what was found.
    """
    path = Path(path)
    conditions, t, series, channels = _archive(path)
    group = path.stem.split("_")[0]
    return [
        run_from_rig(
            group,
            {key: float(row[key]) for key in _CONDITIONS},
            str(row["name"]),
            t,
            dict(zip(channels, s.T, strict=True)),
            reference="_plant_" not in str(row["name"]),  # the project's own rig writes the same kind of file
        )
        for row, s in zip(conditions, series.astype(float), strict=True)
    ]


def _archive(path: Path) -> tuple[Any, Array, Array, list[str]]:
    if not path.is_file():
        raise ValueError(
            f"{path}: expected a single-wheel archive (.npz), found {'a folder' if path.is_dir() else 'none'}"
        )
    try:
        with np.load(path, allow_pickle=False) as data:
            missing = [key for key in ("conditions", "t", "series", "channels") if key not in data.files]
            if missing:
                raise ValueError(f"expected arrays conditions, t, series, channels; found {', '.join(data.files)}")
            conditions, t, series = data["conditions"], np.asarray(data["t"], dtype=float), data["series"]
            channels = [str(name) for name in data["channels"]]
    except (OSError, EOFError, ValueError) as error:
        raise ValueError(f"{path}: expected a single-wheel archive (.npz): {error}") from None
    names = conditions.dtype.names or ()
    for key in ("name", *_CONDITIONS):
        if key not in names:
            raise ValueError(f"{path}: expected condition {key!r}, found {', '.join(names) or 'none'}")
    for key in _SERIES:
        if key not in channels:
            raise ValueError(f"{path}: expected channel {key!r}, found {', '.join(channels) or 'none'}")
    if series.shape != (len(conditions), len(t), len(channels)):
        expected = (len(conditions), len(t), len(channels))
        raise ValueError(f"{path}: expected series of shape {expected} (run, time, channel), found {series.shape}")
    return conditions, t, series, channels


def run_from_rig(
    group: str,
    conditions: Mapping[str, float],
    name: str,
    t: Array,
    ch: Mapping[str, Array],
    radius: float = RIG_RADIUS,
    width: float = RIG_WIDTH,
    reference: bool = True,
) -> WheelRun:
    """One run of a rig whose wheel centre stands RIG_ARM to the left of its yaw axis.

    group: soil class; conditions: soil parameters, slip and speed (SI); t (N,): s; ch: the rig's channels (N,) by name;
    radius, width: of the wheel (m); reference: whether it is the reference simulator's rig.
    """
    dt = float(np.median(np.diff(t)))
    psi = ch["wheel_yaw"]
    rate = np.gradient(psi, dt)
    v_y = -conditions["speed"] * np.sin(psi)
    cos, sin = np.cos(psi), np.sin(psi)
    f_x, f_y = cos * ch["fx"] + sin * ch["fy"], -sin * ch["fx"] + cos * ch["fy"]
    sinkage = -ch["wheel_z"] - RIG_ZERO if "wheel_z" in ch else None
    m_y = None
    if (
        "my" in ch
    ):  # about the travel frame's axis: less the side force's share, which acts about a radius below the axle
        lever = radius - (sinkage if sinkage is not None else 0.0) / 3.0
        m_y = (ch["my"] - sin * lever * f_y) / cos
    return WheelRun(
        name, group, MappingProxyType({key: conditions[key] for key in SOIL_KEYS}), radius, width, conditions["slip"], dt,
        v_x=conditions["speed"] * cos - RIG_ARM * rate, v_y=v_y, omega=ch["omega"], yaw_rate=rate, steer_rate=rate,
        dv_y=np.gradient(v_y, dt), load=moving_mean(ch["fz"], max(1, round(SMOOTHING / dt))),
        f_x=f_x, f_y=f_y, yaw=psi, sinkage=sinkage, m_y=m_y, contact_step=RIG_STEP, patch_length=RIG_PATCH,
        reference_rig=reference,
    )  # fmt: skip


def archives(folder: Path, part: str) -> list[Path]:
    """The archives in a folder whose names end with `_part`, "cal" or "val"."""
    return sorted(folder.glob(f"*_{part}.npz"))


def read_rigs(paths: Sequence[str | Path], part: str | None = "val") -> list[WheelRun]:
    """Runs of several archives, one after the other.

    part: a folder stands for those of its archives, "cal" or "val", or else, and for None, for every .npz in it.
    """
    found: list[Path] = []
    for path in map(Path, paths):
        found += ((archives(path, part) if part else []) or sorted(path.glob("*.npz"))) if path.is_dir() else [path]
    if not found:
        raise ValueError(
            f"expected single-wheel archives (.npz), found none in {', '.join(map(str, paths)) or 'nothing'}"
        )
    return [run for path in found for run in read_rig(path)]
