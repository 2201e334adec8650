"""A user's own single-wheel table, simulated or from a test rig: columns by name and unit, wheel and soil from TOML."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.files.toml_file import finite, read_toml
from softsoil.recording.columns import Source, load_columns
from softsoil.recording.rig import SMOOTHING, SOIL_KEYS, WheelRun, moving_mean
from softsoil.recording.table import numbers, read_table

Array = NDArray[np.float64]

WHEEL_UNITS: Mapping[str, str] = MappingProxyType(
    {
        "run": "", "t": "s", "speed": "m/s", "slip_angle": "rad", "v_x": "m/s", "v_y": "m/s", "omega": "rad/s",
        "rim_speed": "m/s", "slip": "", "load": "N", "f_x": "N", "f_y": "N", "yaw_rate": "rad/s", "steer_rate": "rad/s",
        "dv_y": "m/s^2", "sinkage": "m", "m_y": "N m",
    }
)  # fmt: skip
"""Channels of a single-wheel table and their units. Motion: v_x and v_y in the wheel frame, or speed and slip_angle
(positive: the wheel points left of its course). Spin: omega, rim_speed or slip (1 - v_x/(r omega) when driving,
r omega/v_x - 1 when braking). Forces on the wheel, in the wheel frame, left positive. `run` separates runs; without
`t` every row is a steady state."""

STEEPEST = 1.6
"""rad: a slip angle beyond this is taken for degrees."""


def read_wheel(path: str | Path) -> dict[str, float]:
    """radius, width (m) and, for a simulated soil, contact_step (s) and patch_length (over radius), 0 unless given, from a TOML.

    Raises ValueError naming the file, the key, what was expected and what was found.
    """
    path = Path(path)
    table = read_toml(path, "wheel")
    table = table.get("wheel", table)
    found = {"contact_step": 0.0, "patch_length": 0.0}
    least = {"radius": 1e-6, "width": 1e-6, **found}
    for key in least:
        value = finite(table.get(key, found.get(key)), f"{path}: key {key!r}")
        if not least[key] <= value < 100:
            raise ValueError(f"{path}: key {key!r}: expected a positive number (m, s), found {value!r}")
        found[key] = value
    return found


def read_wheel_table(
    path: str | Path, columns: str | Path | None, wheel: Mapping[str, float], soil: Mapping[str, float], group: str
) -> list[WheelRun]:
    """Runs of a table (CSV, CSV.gz, Parquet).

    columns: TOML map of WHEEL_UNITS, for columns with other names or units; wheel: as `read_wheel` gives; soil: by name
    (SI), one for the table; group: the soil's name. Raises ValueError naming file, column, row, expected and found.
    """
    path = Path(path)
    table = read_table(path)
    given: Mapping[str, Source] = load_columns(columns, WHEEL_UNITS) if columns else {}
    sources = {name: given.get(name, Source(name)) for name in WHEEL_UNITS}
    channels: dict[str, Array] = {}
    for name, source in sources.items():
        if name != "run" and (name in given or source.column in table.columns):
            values = numbers(table, source.column, path) * source.factor + source.offset
            if not np.all(np.isfinite(values)):
                row = int(np.argmin(np.isfinite(values)))
                raise ValueError(f"{path}: column {source.column!r}, row {row + 1}: expected a number, found none")
            channels[name] = values
    for name in ("load", "f_x", "f_y"):
        if name not in channels:
            raise ValueError(
                f"{path}: expected a column for {name} ({WHEEL_UNITS[name]}), found {', '.join(table.columns)}"
            )
    labels = np.zeros(len(table), dtype=object)
    if "run" in given or sources["run"].column in table.columns:
        if sources["run"].column not in table.columns:
            raise ValueError(f"{path}: expected column {sources['run'].column!r}, found {', '.join(table.columns)}")
        labels = table[sources["run"].column].astype(str).to_numpy()
    runs = []
    for label in dict.fromkeys(labels):
        rows = np.flatnonzero(labels == label)
        part = {name: values[rows] for name, values in channels.items()}
        runs.append(_run(f"{path}, run {label}" if len(set(labels)) > 1 else str(path), group, part, wheel, soil))
    return runs


def _run(
    name: str, group: str, ch: dict[str, Array], wheel: Mapping[str, float], soil: Mapping[str, float]
) -> WheelRun:
    length = len(ch["load"])
    dt = None
    if "t" in ch:
        steps = np.diff(ch["t"])
        if length < 3 or not np.all(steps > 0):
            row = int(np.argmin(steps > 0)) + 2 if length >= 3 else length
            raise ValueError(
                f"{name}: column for t, row {row} of the run: expected increasing time, three rows or more"
            )
        dt = float(np.median(steps))
    v_x, v_y, angle = _velocity(name, ch)
    omega = _spin(name, ch, v_x, wheel["radius"])
    rate = np.gradient(angle, ch["t"]) if dt else np.zeros(length)
    yaw_rate = ch.get("yaw_rate", rate)
    rim = wheel["radius"] * omega
    slip = float(np.median((rim - v_x) / np.maximum(np.maximum(rim, v_x), 1e-9)))
    run = WheelRun(
        name, group, {key: float(soil[key]) for key in SOIL_KEYS}, wheel["radius"], wheel["width"], slip, dt,
        v_x=v_x, v_y=v_y, omega=omega, yaw_rate=yaw_rate, steer_rate=ch.get("steer_rate", yaw_rate),
        dv_y=ch.get("dv_y", np.gradient(v_y, ch["t"]) if dt else np.zeros(length)), load=ch["load"],
        f_x=ch["f_x"], f_y=ch["f_y"], yaw=np.zeros(length), sinkage=ch.get("sinkage"), m_y=ch.get("m_y"),
        contact_step=wheel.get("contact_step", 0.0),
        patch_length=wheel.get("patch_length", 0.0),
    )  # fmt: skip
    if dt:
        run = replace(run, load=moving_mean(run.load, max(1, round(SMOOTHING / dt))))
    return run


def _velocity(name: str, ch: Mapping[str, Array]) -> tuple[Array, Array, Array]:
    """v_x, v_y (m/s) and the slip angle (rad)."""
    if "v_x" in ch and "v_y" in ch:
        v_x, v_y = ch["v_x"], ch["v_y"]
        angle = np.arctan2(-v_y, np.maximum(v_x, 1e-12))
    elif "speed" in ch and "slip_angle" in ch:
        angle = ch["slip_angle"]
        if np.abs(angle).max() > STEEPEST:
            raise ValueError(
                f"{name}: slip_angle: expected rad, found {np.abs(angle).max():g} (degrees? give the unit)"
            )
        v_x, v_y = ch["speed"] * np.cos(angle), -ch["speed"] * np.sin(angle)
    else:
        raise ValueError(f"{name}: expected columns for v_x and v_y, or speed and slip_angle; found {', '.join(ch)}")
    if np.any(v_x < -0.02 * np.hypot(v_x, v_y).max()):
        row = int(np.argmin(v_x))
        raise ValueError(f"{name}: row {row + 1} of the run: expected forward motion, found v_x = {v_x[row]:g} m/s")
    return v_x, v_y, angle


def _spin(name: str, ch: Mapping[str, Array], v_x: Array, radius: float) -> Array:
    """Wheel speed (rad/s)."""
    if "omega" in ch:
        return ch["omega"]
    if "rim_speed" in ch:
        return ch["rim_speed"] / radius
    if "slip" in ch:
        s = ch["slip"]
        if np.any(np.abs(s) >= 1.0):
            raise ValueError(f"{name}: slip: expected numbers in (-1, 1), found {s[int(np.argmax(np.abs(s)))]:g}")
        return v_x / radius * np.where(s < 0, 1.0 + s, 1.0 / (1.0 - np.maximum(s, 0.0)))
    raise ValueError(f"{name}: expected a column for omega, rim_speed or slip; found {', '.join(ch)}")


def hold_out(runs: list[WheelRun]) -> tuple[list[WheelRun], list[WheelRun]]:
    """Runs to fit on and runs to judge on: every third run, or every third row of one steady table, or the last third.

    Raises ValueError for fewer than six steady rows and fewer than two runs.
    """
    if len(runs) > 2:
        return [r for i, r in enumerate(runs) if i % 3 != 2], runs[2::3]
    if len(runs) == 1 and len(runs[0]) >= 6:
        index = np.arange(len(runs[0]))
        chosen = index % 3 == 2 if runs[0].dt is None else index >= math.floor(len(index) * 2 / 3)
        return [_rows(runs[0], ~chosen)], [_rows(runs[0], chosen)]
    raise ValueError(f"expected three runs, or one of six rows, to fit on some and judge on others; found {len(runs)}")


def _rows(run: WheelRun, chosen: NDArray[np.bool_]) -> WheelRun:
    arrays: dict[str, Any] = {key: value[chosen] for key, value in vars(run).items() if isinstance(value, np.ndarray)}
    return replace(run, **arrays)
