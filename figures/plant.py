"""A picture and an animation of a drive with its ruts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from softsoil.figures.labels import plain, quantity
from softsoil.figures.style import ESTIMATED, TRUE, page
from softsoil.plant.machine import PlantVehicle, load_plant_vehicle
from softsoil.plant.world import Plant
from softsoil.recording.drive import Recording

Array = NDArray[np.float64]


def ruts(plant: Plant, axis: Axes) -> PathCollection:
    """Draw every touched node with its sinkage in cm; returns the points."""
    table = plant.grid.node_table()
    return axis.scatter(table[:, 0], table[:, 1], c=100 * table[:, 3], s=1.0, cmap="copper_r", linewidths=0)


def outline(vehicle: PlantVehicle, x: float, y: float, psi: float, delta: float) -> list[Array]:
    """Corners (4, 2) of body and wheels, given the point on the front axle (m), heading and road-wheel angle (rad)."""
    base, half = vehicle.l_f + vehicle.l_r, vehicle.half_track
    machine = vehicle.machine
    boxes = [(-0.5 * base, 0.0, 0.5 * base + 0.45, 0.45, 0.0)]
    for ahead, angle, wheel in ((0.0, delta, 0), (-base, 0.0, 2)):
        radius, width = float(machine.radius[wheel]), float(machine.width[wheel])
        boxes += [(ahead, side * half, radius, 0.5 * width, angle) for side in (1, -1)]
    shapes = []
    for ahead, aside, length, breadth, angle in boxes:
        corners = np.array([[length, breadth], [length, -breadth], [-length, -breadth], [-length, breadth]])
        shapes.append(_turn(_turn(corners, angle) + [ahead, aside], psi) + [x, y])
    return shapes


def _turn(points: Array, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def picture(recording: Recording, plant: Plant, path: str | Path) -> Path:
    """Write a PNG: the track with its ruts, and steering, speed, lateral velocity and yaw rate over time."""
    soil = plain(str(recording.meta.get("soil", "soil")))
    title = f"Simulated drive on {soil}, manoeuvre: {plain(recording.name)}"
    mosaic = [["map", "map"], ["steer", "u"], ["v", "omega_z"]]
    with page(Path(path), title, 9, 6.4, mosaic=mosaic) as axes:
        points = ruts(plant, axes["map"])
        axes["map"].plot(recording["x"], recording["y"], color=ESTIMATED, lw=0.8, label="front axle")
        for shape in outline(plant.vehicle, *(float(recording[k][-1]) for k in ("x", "y", "psi", "steer"))):
            axes["map"].add_patch(Polygon(shape, closed=True, fill=False, color=TRUE, lw=0.8))
        axes["map"].set_aspect("equal", adjustable="datalim")
        axes["map"].set(xlabel="x, m", ylabel="y, m", title="Path of the front axle, ruts, vehicle at the end")
        axes["map"].figure.colorbar(points, ax=axes["map"], label="sinkage, cm")
        for name in mosaic[1] + mosaic[2]:
            shown = quantity(name)
            axes[name].plot(recording.t, shown.factor * recording[name], color=ESTIMATED)
            axes[name].set(ylabel=shown.label, xlabel="time, s")
    return Path(path)


def animation(
    recording: Recording,
    path: str | Path,
    frames_per_second: int = 10,
    window: float = 12.0,
    vehicle: PlantVehicle | None = None,
) -> Path:
    """Write a GIF of the drive in real time, the view following the vehicle, the ruts appearing behind its wheels.

    recording: with its truth (rut depth from the wheels' sinkage); window: width of the view (m);
    vehicle: whose outline is drawn (default: the reference vehicle).
    ValueError where the recording has no `true_sinkage_*`.
    """
    if "true_sinkage_rl" not in recording.truth:
        raise ValueError(f"{recording.name}: expected truth columns true_sinkage_*, found {', '.join(recording.truth)}")
    vehicle = vehicle or load_plant_vehicle()
    moments = np.arange(recording.t[0], recording.t[-1], 1.0 / frames_per_second)
    rows = np.searchsorted(recording.t, moments)
    figure = Figure(figsize=(6, 4))
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    tracks, depth = _wheel_tracks(recording, vehicle)
    axis.set_aspect("equal")
    points = axis.scatter([], [], c=[], s=6, cmap="copper_r", vmin=0, vmax=100 * float(np.nanmax(depth)))
    patches = [Polygon(np.zeros((4, 2)), closed=True, fill=False, color="k", lw=1) for _ in range(5)]
    for patch in patches:
        axis.add_patch(patch)
    figure.colorbar(points, label="sinkage, cm", shrink=0.8)

    def show(row: int) -> list[object]:
        seen = tracks[: row + 1 : 3].reshape(-1, 2)
        points.set_offsets(seen)
        points.set_array(100 * depth[: row + 1 : 3].ravel())
        x, y, psi, steer = (float(recording[k][row]) for k in ("x", "y", "psi", "steer"))
        for patch, shape in zip(patches, outline(vehicle, x, y, psi, steer), strict=True):
            patch.set_xy(shape)
        axis.set_xlim(x - 0.5 * window, x + 0.5 * window)
        axis.set_ylim(y - window / 3, y + window / 3)
        axis.set_title(f"t = {recording.t[row]:.1f} s, {recording['u'][row]:.1f} m/s", fontsize=9)
        return [points, *patches]

    film = FuncAnimation(figure, show, frames=[int(r) for r in rows], blit=False)  # type: ignore[arg-type]
    film.save(str(path), writer=PillowWriter(fps=frames_per_second), dpi=60)
    return Path(path)


def _wheel_tracks(recording: Recording, vehicle: PlantVehicle) -> tuple[Array, Array]:
    """Places of the wheels (N, 4, 2) and their sinkage (N, 4)."""
    base, half = vehicle.l_f + vehicle.l_r, vehicle.half_track
    c, s = np.cos(recording["psi"]), np.sin(recording["psi"])
    places = []
    for ahead, aside in ((0.0, half), (0.0, -half), (-base, half), (-base, -half)):
        places.append(
            np.stack([recording["x"] + ahead * c - aside * s, recording["y"] + ahead * s + aside * c], axis=1)
        )
    depth = np.stack([recording.truth[f"true_sinkage_{w}"] for w in ("fl", "fr", "rl", "rr")], axis=1)
    return np.stack(places, axis=1), depth
