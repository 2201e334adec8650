"""The plant's vehicle: TOML with parts and hardpoints in, the arrays that the dynamics need out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from softsoil.files.package_data import VEHICLES
from softsoil.files.toml_file import read_toml
from softsoil.plant.kinematics import fit_polynomials, solve_axle
from softsoil.plant.reference.idler import idler_of

Array = NDArray[np.float64]

REFERENCE = VEHICLES / "reference_plant.toml"
RPM = np.pi / 30.0
_SECTIONS = ("chassis", "wheel", "front", "rear", "steering", "driveline")


class Machine(NamedTuple):
    """What the kernel knows of a vehicle; chassis frame with its origin at the sprung centre of gravity; SI units.

    Wheels in the order front left, front right, rear left, rear right.
    """

    sprung_mass: float
    sprung_inertia: Array  # (3, 3)
    unsprung_mass: Array  # (4,)
    total_mass: float
    paths: Array  # (4, 14, 6, 6) polynomials of softsoil.plant.kinematics
    origin: Array  # (3,) sprung centre of gravity in the vehicle's frame
    front_point: Array  # (3,) middle of the front axle in the chassis frame
    radius: Array  # (4,)
    width: Array  # (4,)
    spin_inertia: float  # wheel and half shaft
    gyro_inertia: float  # the wheel alone
    free_length: Array  # (4,)
    spring_front: Array  # (N, 2) force against change of length
    spring_rear: Array
    damper_front: Array
    damper_rear: Array
    bar: Array  # (2, 3) stiffness, damping, lever of each axle's roll bar; lever 1 and stiffness 0 where there is none
    steer_table: Array  # (N, 2) road-wheel angle a command stands for; pitman angle
    servo: Array  # (3,) natural frequency, damping ratio, inertia
    wheel_mass: float
    steer_inertia: float  # of a steered wheel and its carrier about the vertical
    link_arm: float  # radius on which the steering link swings
    idler_pivot: Array  # (3,) pivot of the idler arm, from the chassis's own centre of gravity
    idler_load: Array  # (3,) what it carries: mass (kg), share of the left and of the right rod's pull down
    idler_error: float  # share of the reference's error in the moment of what the idler carries on the chassis
    final_drive: float
    box_inertia: Array  # (3,) centre, front and rear, at axle speed
    lock_limit: Array  # (3,) torque that the locks of centre, front and rear can hold, at axle speed
    gears: Array
    shift: Array  # (2,) down, up in rad/s
    full_throttle: Array  # (N, 2) torque against rad/s
    zero_throttle: Array
    brake_torque: float
    front_drive: float  # share of the driving torque that the centre gives to the front axle
    torque_reaction: float  # share of the propeller shaft's torque that the chassis feels about x
    joint_reaction: float  # share of a half shaft's torque that the chassis feels about the steered wheel's axle, not y


@dataclass(frozen=True)
class PlantVehicle:
    """A vehicle for the plant.

    name; machine: the kernel's numbers; l_f, l_r: axles to the centre of gravity as designed (m); max_steer: greatest
    road-wheel angle that a command can stand for (rad).
    """

    name: str
    machine: Machine
    l_f: float
    l_r: float
    max_steer: float

    @property
    def yaw_inertia(self) -> float:
        """Yaw inertia of all bodies about the whole vehicle's centre of gravity as designed (kg m^2)."""
        m = self.machine
        design = m.paths[:, :2, 0, 0]
        centre = (m.unsprung_mass @ design) / m.total_mass
        wheels = m.unsprung_mass @ ((design - centre) ** 2).sum(axis=1)
        return float(m.sprung_inertia[2, 2] + m.sprung_mass * (centre @ centre) + wheels)

    @property
    def half_track(self) -> float:
        """Half the front track as designed (m)."""
        return float(self.machine.paths[0, 1, 0, 0])


@lru_cache(maxsize=8)
def load_plant_vehicle(path: Path = REFERENCE) -> PlantVehicle:
    """The vehicle in a TOML file (see vehicles/reference_plant.toml for the keys).

    Raises ValueError naming the file and the missing section or key.
    """
    table = read_toml(Path(path), "plant's vehicle")
    for section in _SECTIONS:
        if section not in table:
            raise ValueError(f"{path}: expected a section [{section}], found {', '.join(table)}")
    try:
        return build_vehicle(table, str(table.get("name", Path(path).stem)))
    except KeyError as error:
        raise ValueError(f"{path}: expected the key {error}, found none") from None


def build_vehicle(table: dict[str, Any], name: str) -> PlantVehicle:
    """The vehicle from a parsed table, its keys as in vehicles/reference_plant.toml; KeyError for a missing one.

    A rear axle of wishbones is not steered: its tie rod is a toe link. [wheel_rear] has what rear wheels have other than [wheel]:
    radius, width and mass; all four spin alike.
    """
    wheel, axles, steering, drive = (
        table["wheel"],
        (table["front"], table["rear"]),
        table["steering"],
        table["driveline"],
    )
    mass, origin, inertia = _sprung(table)
    wheels = wheel, {**wheel, **table.get("wheel_rear", {})}
    unsprung = np.repeat([one["mass"] + axle["carrier_mass"] for one, axle in zip(wheels, axles, strict=True)], 2)
    paths = np.stack(
        [
            fit_polynomials(*solve_axle(axle, steering["link_arm"], angle, side))
            for axle, angle in zip(axles, (steering["max_angle"], 0.0), strict=True)
            for side in (1, -1)
        ]
    )
    paths[:, :3, 0, 0] -= origin
    design = paths[:, :3, 0, 0]
    total = mass + unsprung.sum()
    centre = (unsprung @ design) / total
    front_point = design[:2].mean(axis=0)
    command = np.linspace(-1.0, 1.0, 81)
    angle = np.polynomial.polynomial.polyval(command, steering["angle_of_command"])
    if np.any(np.diff(angle) <= 0):
        raise ValueError(f"{name}: expected steering.angle_of_command to grow with the command over [-1, 1]")
    bars = [
        (axle.get("bar_stiffness", 0.0), axle.get("bar_damping", 0.0), axle.get("bar_lever", 1.0)) for axle in axles
    ]
    idler_pivot, idler_load = idler_of(table)
    final = drive["final_drive"]
    shaft, lock = drive["shaft_inertia"] * final**2, drive.get("axle_lock_limit", np.inf)
    machine = Machine(
        sprung_mass=mass,
        sprung_inertia=inertia,
        unsprung_mass=unsprung,
        total_mass=float(total),
        paths=paths,
        origin=origin,
        front_point=front_point,
        radius=np.repeat([float(one["radius"]) for one in wheels], 2),
        width=np.repeat([float(one["width"]) for one in wheels], 2),
        spin_inertia=float(wheel["spin_inertia"]) + float(drive.get("axle_shaft_inertia", 0.0)),
        gyro_inertia=float(wheel["spin_inertia"]),
        free_length=np.repeat([float(axle["free_length"]) for axle in axles], 2),
        spring_front=_curve(axles[0]["spring"]),
        spring_rear=_curve(axles[1]["spring"]),
        damper_front=_curve(axles[0]["damper"]),
        damper_rear=_curve(axles[1]["damper"]),
        bar=np.array(bars, dtype=float),
        steer_table=np.stack([angle, command * steering["max_angle"]], axis=1),
        servo=np.array([steering["natural_frequency"], steering["damping_ratio"], steering["inertia"]], dtype=float),
        wheel_mass=float(wheel["mass"]),
        steer_inertia=float(wheel["cross_inertia"] + axles[0]["carrier_inertia"][2]),
        link_arm=float(steering["link_arm"]),
        idler_pivot=idler_pivot,
        idler_load=idler_load,
        idler_error=float(steering.get("idler_error", 0.0)),
        final_drive=float(final),
        box_inertia=np.array([shaft, drive["box_inertia"] + shaft, drive["box_inertia"] + shaft]),
        lock_limit=np.array([drive.get("centre_lock_limit", np.inf) * final, lock, lock], dtype=float),
        gears=np.array(drive["gears"], dtype=float),
        shift=np.array([drive["downshift"] * RPM, drive["upshift"] * RPM]),
        full_throttle=_curve(drive["full_throttle"], RPM),
        zero_throttle=_curve(drive["zero_throttle"], RPM),
        brake_torque=float(drive["brake_torque"]),
        front_drive=float(drive.get("front_drive", 0.5)),
        torque_reaction=float(drive.get("torque_reaction", 0.0)),
        joint_reaction=float(drive.get("joint_reaction", 1.0)),
    )
    return PlantVehicle(
        name,
        machine,
        l_f=float(front_point[0] - centre[0]),
        l_r=float(centre[0] - design[2:, 0].mean()),
        max_steer=float(angle[-1]),
    )


def _sprung(table: dict[str, Any]) -> tuple[float, Array, Array]:
    """Mass, centre of gravity and inertia of all that rides on the springs, the carriers' own inertia with it."""
    chassis = table["chassis"]
    points = [(chassis["mass"], *chassis["position"]), *chassis.get("parts", [])]
    own = np.diag(np.array(chassis["inertia"], dtype=float))
    for name in ("front", "rear"):
        axle = table[name]
        x, y, z = axle["inner_position"]
        points += [(axle["inner_mass"], x, y, z), (axle["inner_mass"], x, -y, z)]
        cross = table["wheel"]["cross_inertia"]
        own += 2.0 * np.diag(np.array(axle["carrier_inertia"], dtype=float) + np.array([cross, 0.0, cross]))
    rows = np.array(points, dtype=float)
    mass = float(rows[:, 0].sum())
    origin = rows[:, 0] @ rows[:, 1:] / mass
    for m, *position in rows:
        r = np.array(position) - origin
        own += m * (r @ r * np.eye(3) - np.outer(r, r))
    return mass, origin, own


def _curve(rows: list[list[float]], scale: float = 1.0) -> Array:
    curve = np.array(rows, dtype=float)
    if curve.ndim != 2 or curve.shape[1] != 2 or np.any(np.diff(curve[:, 0]) <= 0):
        raise ValueError(f"vehicle: expected a curve as rows [x, value] with growing x, found {rows!r}")
    curve[:, 0] *= scale
    return curve
