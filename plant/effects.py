"""What can be switched on in the world without any model knowing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Four = tuple[float, float, float, float]
Two = tuple[float, float]

MAX_DELAY_STEPS = 512
"""Longest steering delay that the state can hold, in steps."""


class World(NamedTuple):
    """The effects as the kernel reads them; see Effects."""

    slope: Array  # bank, grade, undulation amplitude, wave length
    payload: Array  # mass and position in the vehicle's frame
    steering: Array  # lag, delay, offset, gain, backlash
    force_body: Array  # force along y of the body, position
    force_world: Array  # force along x and y of the world, position
    moment_z: float
    drag: Array  # constant, per v^2
    locked: Array  # centre, front, rear: 1 locked, 0 open
    damped: float
    multipass: float
    anew: float
    creep: float
    cast: int  # 1: the reference's ray cast finds the wheel
    imbalance: Array  # per wheel, kg m
    out_of_round: Array  # per wheel, m
    damper_factor: Array  # per wheel
    bar_factor: Array  # per axle
    rear_toe: Array  # left, right
    radius_factor: Array  # per wheel
    width_factor: Array  # per wheel
    bearing: Array  # per wheel, friction torque


@dataclass(frozen=True)
class Effects:
    """Physical effects, all off by default. SI units; wheels in the order front left, front right, rear left, rear
    right.

    In the catalogue that a model may draw on:
    bank, grade: slope of the ground (rad): gravity along -y and -x of the world, whatever the heading;
    payload: mass (kg) with payload_at: x, y, z in the vehicle's frame (m, x negative behind the front axle);
    steer_lag (s, first order), steer_delay (s), steer_offset (rad), steer_gain, steer_backlash (half play, rad);
    side_force (N, along body y) at side_force_at, wind (N, along world x and y) at wind_at (m, vehicle's frame);
    yaw_moment (N m); drag (N) and drag_v2 (N s^2/m^2) against the motion;
    locked_centre, locked_front, locked_rear: differentials (the reference vehicle: centre only);
    damping: of the soil; multipass: wheels meet each other's ruts; shears_anew: where they do, soil shears as if it were fresh.

    Beyond the catalogue:
    imbalance (kg m per wheel: a force turning with the wheel), out_of_round (m per wheel: radius once per turn);
    damper_factor (per wheel: 0 broken, 10 stuck), bar_factor (per axle: roll bar, 0 broken);
    undulation (rad) with undulation_length (m): bank that waves along world x;
    rear_toe (rad, left and right: a bent axle), radius_factor, width_factor (per wheel: an odd tyre);
    bearing (N m per wheel: a seized bearing).
    creep: speed below which soil shear fades (m/s), so that a standing vehicle rests. ValueError for what cannot be.
    """

    bank: float = 0.0
    grade: float = 0.0
    payload: float = 0.0
    payload_at: tuple[float, float, float] = (-2.0, 0.0, 0.9)
    steer_lag: float = 0.0
    steer_delay: float = 0.0
    steer_offset: float = 0.0
    steer_gain: float = 1.0
    steer_backlash: float = 0.0
    side_force: float = 0.0
    side_force_at: tuple[float, float, float] = (-1.54, 0.0, 0.7)
    wind: Two = (0.0, 0.0)
    wind_at: tuple[float, float, float] = (-1.64, 0.0, 1.2)
    yaw_moment: float = 0.0
    drag: float = 0.0
    drag_v2: float = 0.0
    locked_centre: bool = True
    locked_front: bool = False
    locked_rear: bool = False
    damping: bool = True
    multipass: bool = True
    shears_anew: bool = False
    creep: float = 0.005
    imbalance: Four = (0.0, 0.0, 0.0, 0.0)
    out_of_round: Four = (0.0, 0.0, 0.0, 0.0)
    damper_factor: Four = (1.0, 1.0, 1.0, 1.0)
    bar_factor: Two = (1.0, 1.0)
    undulation: float = 0.0
    undulation_length: float = 30.0
    rear_toe: Two = (0.0, 0.0)
    radius_factor: Four = (1.0, 1.0, 1.0, 1.0)
    width_factor: Four = (1.0, 1.0, 1.0, 1.0)
    bearing: Four = (0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for field in fields(self):
            value = np.asarray(getattr(self, field.name), dtype=float)
            default = np.asarray(field.default, dtype=float)
            if value.shape != default.shape or not np.all(np.isfinite(value)):
                raise ValueError(f"effects: expected {field.name} finite of shape {default.shape}, found {value}")
        for name in ("payload", "steer_lag", "steer_delay", "steer_backlash", "drag", "drag_v2", "creep"):
            if getattr(self, name) < 0:
                raise ValueError(f"effects: expected {name} >= 0, found {getattr(self, name)}")
        for name in ("steer_gain", "undulation_length"):
            if getattr(self, name) <= 0:
                raise ValueError(f"effects: expected {name} > 0, found {getattr(self, name)}")
        for name in ("radius_factor", "width_factor"):
            if min(getattr(self, name)) <= 0:
                raise ValueError(f"effects: expected {name} > 0 for each wheel, found {getattr(self, name)}")
        for name in ("bank", "grade", "undulation"):
            if abs(getattr(self, name)) > 0.6:
                raise ValueError(f"effects: expected |{name}| <= 0.6 rad, found {getattr(self, name)} (degrees?)")

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Effects:
        """Effects from a table as JSON or TOML has it (lists for tuples); ValueError for an unknown name."""
        known = {field.name for field in fields(cls)}
        for name in table:
            if name not in known:
                raise ValueError(f"effects: expected one of {', '.join(sorted(known))}; found {name!r}")
        values: dict[str, Any] = {name: tuple(v) if isinstance(v, list) else v for name, v in table.items()}
        return cls(**values)

    def world(self, dt: float, origin: Array, cast: bool = False) -> World:
        """The kernel's arrays; positions relative to the chassis frame's origin; cast: see Plant. ValueError for too long
        a delay."""
        if self.steer_delay / dt > MAX_DELAY_STEPS - 1:
            raise ValueError(
                f"effects: expected a steer_delay below {(MAX_DELAY_STEPS - 1) * dt:g} s, found {self.steer_delay:g}"
            )
        steering = [self.steer_lag, self.steer_delay, self.steer_offset, self.steer_gain, self.steer_backlash]
        return World(
            slope=np.array([self.bank, self.grade, self.undulation, self.undulation_length]),
            payload=np.array([self.payload, *(np.array(self.payload_at) - origin)]),
            steering=np.array(steering),
            force_body=np.array([self.side_force, *(np.array(self.side_force_at) - origin)]),
            force_world=np.array([*self.wind, *(np.array(self.wind_at) - origin)]),
            moment_z=float(self.yaw_moment),
            drag=np.array([self.drag, self.drag_v2]),
            locked=np.array([self.locked_centre, self.locked_front, self.locked_rear], dtype=float),
            damped=float(self.damping),
            multipass=float(self.multipass),
            anew=float(self.shears_anew),
            creep=float(self.creep),
            cast=int(cast),
            imbalance=np.array(self.imbalance, dtype=float),
            out_of_round=np.array(self.out_of_round, dtype=float),
            damper_factor=np.array(self.damper_factor, dtype=float),
            bar_factor=np.array(self.bar_factor, dtype=float),
            rear_toe=np.array(self.rear_toe, dtype=float),
            radius_factor=np.array(self.radius_factor, dtype=float),
            width_factor=np.array(self.width_factor, dtype=float),
            bearing=np.array(self.bearing, dtype=float),
        )
