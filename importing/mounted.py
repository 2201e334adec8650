"""Mapped channels brought from their sensors' places and frames to the vehicle's."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from softsoil.importing.earth_velocity import turned_by_heading
from softsoil.importing.import_map import ImportMap, Mount
from softsoil.importing.sources import TABLE_SUFFIXES
from softsoil.recording.derive import REAR_COMPLIANCE
from softsoil.recording.evidence import interpolated
from softsoil.recording.geometry import Geometry
from softsoil.recording.laid_heading import laid_heading

Array = NDArray[np.float64]
ACCELERATIONS = ("a_x_imu", "a_y_imu")
AT_CENTRE = Mount()
GRAVITY = 9.81
"""m/s^2"""
CARRIED = 5
"""Samples to each side for the yaw acceleration that moves an accelerometer to the centre of gravity."""
NEAR = 0.05
"""m: a place nearer to the front axle is taken for it."""


def mounted(channels: Mapping[str, Array], plan: ImportMap, geometry: Geometry) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Channels in the project's frame: (x, y) of the front axle, velocities and accelerations of the centre of gravity; and notes
    on what a mount asks for and the map's channels do not allow.

    channels: as mapped, each (N,); plan: the map; geometry: of the vehicle.
    """
    out = dict(channels)
    offset = {name: plan.channels[name].offset for name in out if name in plan.channels}
    for name in ("y", "psi", "v", "omega_z", "a_y_imu"):
        if name in plan.channels and (m := plan.mount_of(name)) and m.frame == "z-down" and not _of_the_earth(name, plan):
            out[name] = -out[name]
    for name in offset.keys() - set(ACCELERATIONS):
        out[name] = out[name] + offset[name]
    if m := plan.mount_of("omega_z"):
        out["omega_z"] = out["omega_z"] / (np.cos(m.pitch) * np.cos(m.roll))
    omega = interpolated(out["omega_z"], len(out["t"]))
    if "psi" in plan.channels and (m := plan.mount_of("psi")):
        out["psi"] = out["psi"] - m.yaw
    notes = _velocities(out, plan, omega)
    notes += _accelerations(out, plan, omega)
    for name in offset.keys() & set(ACCELERATIONS):  # what they read beside the motion, as the checks say it
        out[name] = out[name] + offset[name]
    return out, notes + _positions(out, plan, geometry, omega)


def _of_the_earth(name: str, plan: ImportMap) -> bool:
    """Whether a channel is of the earth's frame, however its sensor hangs: metres north of a fix, a heading by a compass."""
    one = plan.channels[name]
    return one.earth or one.compass or one.fields in (("north",), ("east",))


def _turned(ahead: Array, aside: Array, yaw: float) -> tuple[Array, Array]:
    """Components in the vehicle's frame of a vector given in a frame turned to the left by yaw (rad); where it is not turned, a
    sample that one of them lacks is none of the other's."""
    if yaw == 0.0:
        return ahead, aside
    return ahead * np.cos(yaw) - aside * np.sin(yaw), ahead * np.sin(yaw) + aside * np.cos(yaw)


def _velocities(out: dict[str, Array], plan: ImportMap, omega: Array) -> tuple[str, ...]:
    """u and v at the centre of gravity: turned together where one sensor measures both, else each by the other, and moved; and
    notes."""
    ahead, aside = plan.mount_of("u") or AT_CENTRE, (plan.mount_of("v") if "v" in plan.channels else None) or AT_CENTRE
    reach = len(omega)
    if plan.channels["u"].earth:
        psi, dt = out.get("psi"), float(out["t"][1] - out["t"][0])
        along, across = turned_by_heading(out["u"], out.pop("v"), psi, dt)
        out["u"] = along + ahead.y * omega
        if psi is None:
            return ("v: the velocities to the east and north give a speed alone, since no heading is mapped",)
        out["v"] = across - ahead.x * omega
        return ()
    if "v" in out and plan.channels["v"].source == plan.channels["u"].source and ahead == aside:
        out["u"], out["v"] = _turned(out["u"], out["v"], ahead.yaw)
        out["u"], out["v"] = out["u"] + ahead.y * omega, out["v"] - ahead.x * omega
        return ()
    sideways = interpolated(out["v"], reach) if "v" in out else 0.0
    out["u"] = (out["u"] - (sideways + ahead.x * omega) * np.sin(ahead.yaw)) / np.cos(ahead.yaw) + ahead.y * omega
    if "v" in out:
        along = interpolated(out["u"], reach) - aside.y * omega
        out["v"] = (out["v"] + along * np.sin(aside.yaw)) / np.cos(aside.yaw) - aside.x * omega
    return ()


def _accelerations(out: dict[str, Array], plan: ImportMap, omega: Array) -> tuple[str, ...]:
    """Specific force at the centre of gravity: gravity in a tilted sensor off, turned, moved by its lever arm; notes."""
    mounts = {name: m for name in ACCELERATIONS if name in plan.channels and (m := plan.mount_of(name)) is not None}
    dt = float(out["t"][1] - out["t"][0])
    clock = np.arange(-CARRIED, CARRIED + 1) * dt
    turning = np.convolve(np.pad(omega, CARRIED, mode="edge"), clock[::-1] / float(clock @ clock), mode="valid")
    for name, m in mounts.items():
        gravity, tilt = (GRAVITY, m.pitch) if name == "a_x_imu" else (-GRAVITY, m.roll)
        out[name] = (out[name] + gravity * np.sin(tilt)) / np.cos(tilt)
    notes: tuple[str, ...] = ()
    if len(mounts) == len(ACCELERATIONS) and mounts["a_x_imu"] == mounts["a_y_imu"]:
        ahead, aside = _turned(out["a_x_imu"], out["a_y_imu"], mounts["a_x_imu"].yaw)
        out |= {"a_x_imu": ahead, "a_y_imu": aside}
    else:
        why = "its sensor's yaw is not taken off: that takes both axes of one sensor"
        notes = tuple(f"{name}: {why}" for name, m in mounts.items() if m.yaw)
    if m := mounts.get("a_x_imu"):
        out["a_x_imu"] = out["a_x_imu"] + turning * m.y + omega**2 * m.x
    if m := mounts.get("a_y_imu"):
        out["a_y_imu"] = out["a_y_imu"] - turning * m.x + omega**2 * m.y
    return notes


def _positions(out: dict[str, Array], plan: ImportMap, geometry: Geometry, omega: Array) -> tuple[str, ...]:
    """x, y of the front axle, or a note that they stay those of the sensor."""
    if not {"x", "y"} <= set(out):
        return ()
    place = _place(plan.channels["x"].source, plan.mount_of("x"), geometry)
    if place is None:
        return ()
    ahead, left = geometry.l_f - place[0], -place[1]
    away = float(np.hypot(ahead, left))
    notes: tuple[str, ...] = ()
    psi = interpolated(out["psi"], len(out["t"])) if "psi" in out else None
    if psi is None and away > NEAR:
        psi, of = _laid(out, place, geometry, omega), f"x, y: of a point {away:.3g} m from the front axle"
        if psi is None:
            return (f"{of}: without a heading they are not moved there",)
        notes = (f"{of}: moved there by the integral of the yaw rate, aligned with them, since no heading is mapped",)
    if psi is not None:
        out["x"] = out["x"] + ahead * np.cos(psi) - left * np.sin(psi)
        out["y"] = out["y"] + ahead * np.sin(psi) + left * np.cos(psi)
    return notes


def _laid(out: Mapping[str, Array], place: tuple[float, float], geometry: Geometry, omega: Array) -> Array | None:
    """Heading (N,), rad, that lays the motion of the positions' own place on them; None where they say none."""
    u = interpolated(out["u"], len(omega))
    rear = geometry.l_r * omega - REAR_COMPLIANCE * u * np.abs(u) * omega
    v = interpolated(out["v"], len(omega)) if "v" in out else rear
    dt = float(out["t"][1] - out["t"][0])
    ahead, aside, turning = (np.nan_to_num(one) for one in (u - place[1] * omega, v + place[0] * omega, omega))
    found = laid_heading(out["x"], out["y"], ahead, aside, turning, dt)
    return None if found is None or found.scattered else found.psi


def _place(source: str, mount: Mount | None, geometry: Geometry) -> tuple[float, float] | None:
    """Place of the positions from the centre of gravity (m); None where they are of the front axle already."""
    if mount is None:
        return None if source.endswith(TABLE_SUFFIXES) else (0.0, 0.0)
    if mount.point == "front_axle":
        return None
    return (0.0, 0.0) if mount.point == "centre_of_gravity" else (mount.x, mount.y)
