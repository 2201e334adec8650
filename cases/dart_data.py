"""Logs of the 1:10 car of TU Delft (DART) as drives: motion capture poses and a steering command, nothing else trusted.

The capture point lies POINT ahead of the rear axle. Its velocity is differentiated from the poses (a quadratic over WINDOW
seconds) and carried to the centre of gravity; the steering command goes through the laboratory's static map. There is no
accelerometer worth using and one wheel encoder at most, which is left out: the law of hard ground looks at no wheel speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.drive import Recording
from softsoil.recording.table import numbers, read_table

Array = NDArray[np.float64]

WHEELBASE, L_R, POINT = 0.1735, 0.0930, 0.115
"""m: wheelbase, rear axle to centre of gravity, rear axle to capture point."""
RADIUS = 0.033
"""m, of the wheels, nominal."""
YAW_OFFSET = 0.0077
"""rad that the laboratory adds to the captured yaw angle (its own processed logs differ from the raw ones by it)."""
STEP = 0.01
"""s, clock of the drives: finer than the 20 Hz logs, for a car whose yaw settles in 20 ms."""
WINDOW = 0.13
"""s of the quadratic that gives velocities."""
SLOWEST, SHORTEST = 0.6, 6.0
"""Only stretches faster than this (m/s) and longer than this (s) are used."""


def road_wheel_angle(command: Array) -> Array:
    """(N,) road-wheel angle (rad) of a command in [-1, 1]: the laboratory's map, with s = command - 0.027,
    w 0.366 tanh(1.393 s) + (1-w) 0.515 tanh(1.023 s), and w going from 0 to 1 where s changes sign.
    """
    s = np.asarray(command, dtype=float) - 0.027
    w = 0.5 * (np.tanh(30 * s) + 1)
    return w * 0.366 * np.tanh(1.393 * s) + (1 - w) * 0.515 * np.tanh(1.023 * s)


@dataclass(frozen=True)
class _Poses:
    t: Array
    x: Array
    y: Array
    psi: Array
    command: Array


def read_dart(path: str | Path) -> list[Recording]:
    """The stretches of a log in which the car drives, as drives; ValueError for a log without the columns or such stretches."""
    poses = _read(Path(path))
    channels, speed = _channels(poses)
    moving = speed > SLOWEST
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moving.astype(int), [0]])))
    stem = Path(path).name.split("_")[0] + "_" + Path(path).name.split("_")[1]
    drives = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if (last - first) * STEP < SHORTEST:
            continue
        part = {name: values[first:last] for name, values in channels.items()}
        notes = ("velocities differentiated from the captured poses",)
        drives.append(Recording(f"{stem}@{part['t'][0]:.0f}s", part, {}, notes, {"path": str(path)}))
    if not drives:
        raise ValueError(f"{path}: expected {SHORTEST:g} s of driving faster than {SLOWEST:g} m/s, found none")
    return drives


def _read(path: Path) -> _Poses:
    table = read_table(path)
    columns = ("vicon time", "vicon x", "vicon y", "vicon yaw", "steering")
    t, x, y, psi, command = (numbers(table, name, path) for name in columns)
    good = np.isfinite(t + x + y + psi + command)
    good[1:] &= np.diff(t) > 0
    t, x, y, psi, command = (values[good] for values in (t, x, y, psi, command))
    t = t - t[0]
    clock = np.arange(t[0], t[-1], STEP)
    # A command holds until the next one comes; poses are in between.
    held = command[np.clip(np.searchsorted(t, clock, side="right") - 1, 0, len(t) - 1)]
    between = [np.interp(clock, t, values) for values in (x, y, np.unwrap(psi) + YAW_OFFSET)]
    return _Poses(clock, between[0], between[1], between[2], held)


def _channels(poses: _Poses) -> tuple[dict[str, Array], Array]:
    v_x, v_y, rate = (_slope(values) for values in (poses.x, poses.y, poses.psi))
    cos, sin = np.cos(poses.psi), np.sin(poses.psi)
    u, aside = v_x * cos + v_y * sin, -v_x * sin + v_y * cos
    v = aside - (POINT - L_R) * rate
    ahead = WHEELBASE - POINT
    return {
        "t": poses.t, "x": poses.x + ahead * cos, "y": poses.y + ahead * sin, "psi": poses.psi, "u": u, "v": v,
        "omega_z": rate, "steer": road_wheel_angle(poses.command),
    }, u  # fmt: skip


def _slope(values: Array) -> Array:
    """(N,) slope in the middle of a quadratic over WINDOW seconds, ends held."""
    half = round(WINDOW / STEP / 2)
    places = np.arange(-half, half + 1)
    padded = np.pad(values, half, mode="edge")
    return np.convolve(padded, -places / (STEP * float(places @ places)), "valid")
