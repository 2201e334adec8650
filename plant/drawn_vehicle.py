"""Vehicles of the plant drawn by seed: from a light robot to a truck, each with suspensions of its own.

The hardpoints of the reference vehicle are scaled to the vehicle's size; springs and dampers follow from natural frequencies,
masses of wheels and links from the wheels' size. Nothing is shared with the bicycle model.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.files.toml_file import read_toml
from softsoil.plant.kinematics import QUANTITIES, solve_axle
from softsoil.plant.machine import REFERENCE, PlantVehicle, build_vehicle

Array = NDArray[np.float64]
Table = dict[str, Any]
GRAVITY = 9.81
"""m/s^2"""
LAYOUTS = ("wishbone", "trailing")
"""Suspensions of either axle."""
LONGER = 1.6
"""Steering arms of wheels on trailing arms, which swing back and forth, over those of wheels on wishbones."""
TRIES = 8
"""Draws of one seed before its ranges are refused."""
NARROWER = 0.85
"""Full lock of wheels on trailing arms over that of wheels on wishbones: their rods lie flat, beyond it they stall."""
_A_X, _STRUT = (QUANTITIES.index(name) for name in ("a_x", "strut"))
_FRONT_POINTS = (
    "upper_chassis", "upper_carrier", "lower_chassis", "lower_carrier", "tie_rod_chassis", "tie_rod_carrier", "strut_chassis",
    "strut_arm",
)  # fmt: skip
_REAR_POINTS = ("arm_chassis", "links_chassis", "links_carrier", "strut_chassis", "strut_arm", "bar_link")


@dataclass(frozen=True)
class Draw:
    """Ranges that vehicles are drawn from, uniformly; lengths and masses by the cube root law of like vehicles, times a draw.

    mass (kg), by its logarithm; size, wheel: wheelbase and wheel radius over those of a vehicle of the same mass that is like the
    reference one; radius, wheelbase (m): limits of both; track: over the wheelbase; front: l_f over the wheelbase; height: of the
    centre of gravity over the track; gyration: yaw inertia over mass l_f l_r; pressure: weight over radius times width of a wheel
    (Pa); narrow: limits of width over radius; frequency: of the springs (Hz); damping: ratio; bar: roll bar over the springs;
    scrub: share of the radius added; rods: tie rod's end moved, share of the track; toe, toe_rear: of each wheel (rad);
    lock: pitman angle (rad); unsprung: mass of wheel and links over that of the reference vehicle's by size. rear_wheel: radius
    and width of the rear wheels over those of the front ones, front_drive: the front axle's share of the torque behind an open
    centre, None for a locked one, of every vehicle.
    """

    mass: tuple[float, float] = (600.0, 4000.0)
    size: tuple[float, float] = (0.85, 1.15)
    wheel: tuple[float, float] = (0.85, 1.3)
    radius: tuple[float, float] = (0.25, 0.6)
    wheelbase: tuple[float, float] = (1.8, 3.6)
    track: tuple[float, float] = (0.44, 0.58)
    front: tuple[float, float] = (0.42, 0.57)
    height: tuple[float, float] = (0.36, 0.48)
    gyration: tuple[float, float] = (0.75, 1.1)
    pressure: tuple[float, float] = (35e3, 55e3)
    narrow: tuple[float, float] = (0.4, 0.9)
    frequency: tuple[float, float] = (1.3, 2.0)
    damping: tuple[float, float] = (0.3, 0.5)
    bar: tuple[float, float] = (0.0, 1.5)
    scrub: tuple[float, float] = (-0.05, 0.2)
    rods: tuple[float, float] = (-0.008, 0.004)
    toe: tuple[float, float] = (-0.006, 0.006)
    toe_rear: tuple[float, float] = (-0.004, 0.004)
    lock: tuple[float, float] = (0.42, 0.5)
    unsprung: tuple[float, float] = (0.8, 1.2)
    rear_wheel: tuple[float, float] = (1.0, 1.0)
    front_drive: float | None = None


DRAW = Draw()
LIKE_MASS = 1378.0
"""kg: of the reference vehicle, whose wheelbase and wheels are those below."""
LIKE_WHEELBASE, LIKE_RADIUS, LIKE_TRACK, LIKE_WIDTH = 2.715, 0.330229, 1.232, 0.2121


@dataclass(frozen=True)
class DrawnVehicle:
    """A vehicle of the plant and what a person with a scale and a tape would measure of it, without error.

    vehicle; measured: mass, l_f, l_r, track, track_rear, radius, width, h_cg (SI units), radius_rear and width_rear where rear
    wheels are of another size; layouts: suspension in front and rear; spacing: of the soil's grid that resolves its wheels as the
    reference vehicle's are resolved (m); open_centre: whether its axles turn freely of each other.
    """

    vehicle: PlantVehicle
    measured: dict[str, float]
    layouts: tuple[str, str]
    spacing: float
    open_centre: bool


def draw_vehicle(seed: int, draw: Draw = DRAW) -> DrawnVehicle:
    """The vehicle of a seed.

    seed: of all that is drawn; draw: ranges. Raises ValueError for ranges in which no suspension reaches its travel.
    """
    rng = np.random.default_rng([seed, 3])
    for _ in range(TRIES - 1):
        try:
            return _drawn(seed, rng, draw)
        except ValueError:
            continue  # links that do not reach the whole travel: nobody builds them
    return _drawn(seed, rng, draw)


def _drawn(seed: int, rng: np.random.Generator, draw: Draw) -> DrawnVehicle:
    def one(name: str) -> float:
        return float(rng.uniform(*getattr(draw, name)))

    mass = math.exp(rng.uniform(math.log(draw.mass[0]), math.log(draw.mass[1])))
    like = (mass / LIKE_MASS) ** (1.0 / 3.0)
    wheelbase = float(np.clip(LIKE_WHEELBASE * like * one("size"), *draw.wheelbase))
    radius = float(np.clip(LIKE_RADIUS * like * one("wheel"), *draw.radius))
    track = wheelbase * one("track")
    load = mass * GRAVITY / 4.0
    width = float(np.clip(load / (radius * one("pressure")), draw.narrow[0] * radius, draw.narrow[1] * radius))
    l_f = wheelbase * one("front")
    h_cg = max(track * one("height"), radius + 0.1)
    inertia = one("gyration") * mass * l_f * (wheelbase - l_f)
    layouts = (str(rng.choice(LAYOUTS)), str(rng.choice(LAYOUTS)))
    table = copy.deepcopy(read_toml(REFERENCE, "plant's vehicle"))
    table["name"] = f"drawn_{seed}"
    grown = radius / LIKE_RADIUS
    heavy = one("unsprung")
    table["wheel_rear"] = copy.deepcopy(table["wheel"])
    rear_radius, rear_width = draw.rear_wheel[0] * radius, draw.rear_wheel[1] * width
    _wheel(table["wheel"], radius, width, heavy)
    _wheel(table["wheel_rear"], rear_radius, rear_width, heavy)
    links = (mass / LIKE_MASS) * one("unsprung")
    scrub = one("scrub") * radius
    scales = (grown, track / LIKE_TRACK, grown)
    front, rear = table["front"], table["rear"]
    wishbones = copy.deepcopy(front)
    _place(front, wishbones, scales, (0.0, scrub), layouts[0])
    front["tie_rod_carrier"][1] += one("rods") * track
    if layouts[1] == "wishbone":
        rear = table["rear"] = _unsteered(wishbones, rear)
    else:
        rear["layout"] = "trailing_arm"
    _place(rear, copy.deepcopy(rear), scales, (-wheelbase, 0.0), layouts[1] if layouts[1] == "wishbone" else "")
    _lift(rear, rear_radius - radius)
    front["toe"], rear["toe"] = one("toe"), one("toe_rear")
    for axle in (front, rear):
        axle["carrier_mass"] *= links
        axle["carrier_inertia"] = [links * grown**2 * value for value in axle["carrier_inertia"]]
        axle["inner_mass"] *= links
    steering = table["steering"]
    steering["link_arm"] *= grown * (LONGER if layouts[0] == "trailing" else 1.0)
    steering["max_angle"] = one("lock") * (NARROWER if layouts[0] == "trailing" else 1.0)
    steering["inertia"] *= links
    steering.pop("idler_pivot")
    _chassis(table, mass, l_f, h_cg, inertia, track)
    for axle, wheel, lever in ((front, "wheel", wheelbase - l_f), (rear, "wheel_rear", l_f)):
        sprung = load * 2.0 * lever / wheelbase / GRAVITY - table[wheel]["mass"] - axle["carrier_mass"]
        _springs(axle, steering, sprung, one("frequency"), one("damping"), one("bar"))
    _driveline(table["driveline"], mass / LIKE_MASS, grown)
    if draw.front_drive is not None:
        table["driveline"]["front_drive"] = draw.front_drive
    steering["angle_of_command"] = _angle_of_command(front, steering)
    vehicle = build_vehicle(table, table["name"])
    measured = {
        "mass": vehicle.machine.total_mass, "l_f": vehicle.l_f, "l_r": vehicle.l_r,
        "track": 2.0 * float(front["spindle"][1]), "track_rear": 2.0 * float(rear["spindle"][1]),
        "radius": radius, "width": width, "h_cg": h_cg,
    }  # fmt: skip
    if draw.rear_wheel != DRAW.rear_wheel:
        measured |= {"radius_rear": rear_radius, "width_rear": rear_width}
    apart = draw.front_drive is not None or draw.rear_wheel[0] != 1.0  # wheels of two sizes fight where they turn alike
    return DrawnVehicle(vehicle, measured, layouts, 0.03 * grown, apart)


def _wheel(wheel: Table, radius: float, width: float, heavy: float) -> None:
    """Mass by the wheel's surface, inertias by mass and radius squared."""
    grown = radius / LIKE_RADIUS
    more = heavy * grown * 0.5 * (grown + width / LIKE_WIDTH)
    wheel.update(
        radius=radius, width=width, mass=wheel["mass"] * more, spin_inertia=wheel["spin_inertia"] * more * grown**2,
        cross_inertia=wheel["cross_inertia"] * more * grown**2,
    )  # fmt: skip


def _place(axle: Table, like: Table, scales: tuple[float, float, float], to: tuple[float, float], layout: str) -> None:
    """Put an axle's points to `to` (m behind the front axle line as a negative x, wheel centres farther out), scaled about the
    wheel centre in x and z and about the middle in y; wishbones of the layout "trailing" become a pair of trailing arms."""
    centre = np.array(like["spindle"], dtype=float)
    names = _FRONT_POINTS if layout else _REAR_POINTS

    def moved(points: Any) -> Any:
        relative = np.array(points, dtype=float) - [centre[0], 0.0, centre[2]]
        return (relative * scales + [to[0], 0.0, centre[2]]).tolist()

    for name in (*names, "inner_position"):
        if name in like:
            axle[name] = moved(like[name])
    if layout == "trailing":
        for arm in ("upper", "lower"):
            ball = np.array(axle[f"{arm}_carrier"])
            pivot = ball + [0.38 * scales[0], 0.0, 0.02 * scales[2]]
            axle[f"{arm}_chassis"] = [(pivot * [1, share, 1]).tolist() for share in (0.55, 0.95)]
        for end in ("tie_rod_chassis", "tie_rod_carrier"):
            axle[end][0] = to[0] + LONGER * (axle[end][0] - to[0])
        axle["tie_rod_chassis"][2] = axle["tie_rod_carrier"][2]  # a rod that slopes would steer wheels that move up and down
        on_arm = 0.7 * np.array(axle["lower_carrier"]) + 0.3 * np.mean(axle["lower_chassis"], axis=0)
        seat = on_arm + [0.0, 0.0, 0.1 * scales[2]]  # above the arm's plane: a point in it has no side
        axle["strut_arm"] = seat.tolist()
        axle["strut_chassis"] = (seat + [0.05 * scales[0], -0.05 * scales[1], 0.4 * scales[2]]).tolist()
    axle["spindle"] = [to[0], centre[1] * scales[1] + to[1], float(centre[2])]


def _lift(axle: Table, height: float) -> None:
    """Raise all points of an axle (m)."""
    for name in (*_FRONT_POINTS, *_REAR_POINTS, "inner_position", "spindle"):
        if name in axle:
            axle[name] = (np.array(axle[name], dtype=float) + [0.0, 0.0, height]).tolist()


def _unsteered(wishbones: Table, rear: Table) -> Table:
    """A rear axle of wishbones as in front, with the masses of the rear one and a roll bar on its carriers."""
    axle = copy.deepcopy(wishbones)
    for name in ("carrier_mass", "carrier_inertia", "inner_mass", "bar_stiffness", "bar_damping", "bar_lever"):
        axle[name] = copy.deepcopy(rear[name])
    return axle


def _chassis(table: Table, mass: float, l_f: float, h_cg: float, inertia: float, track: float) -> None:
    """Mass, place and inertia of the chassis that give the whole vehicle its own."""
    chassis = table["chassis"]
    chassis["parts"] = []
    ground = table["front"]["spindle"][2] - table["wheel"]["radius"]
    rest, own = np.zeros(3), 0.0
    bodies = []
    for name, size in (("front", "wheel"), ("rear", "wheel_rear")):
        axle, wheel = table[name], table[size]
        bodies += [(wheel["mass"] + axle["carrier_mass"], axle["spindle"]), (axle["inner_mass"], axle["inner_position"])]
        own += 2.0 * (axle["carrier_inertia"][2] + wheel["cross_inertia"])
    left = mass - 2.0 * sum(m for m, _ in bodies)
    target = np.array([-l_f, 0.0, ground + h_cg])
    rest = (mass * target - sum(2.0 * m * np.array([p[0], 0.0, p[2]]) for m, p in bodies)) / left
    around = sum(2.0 * m * ((p[0] + l_f) ** 2 + p[1] ** 2) for m, p in bodies)
    turning = inertia - around - own - left * (rest[0] + l_f) ** 2
    if left <= 0 or turning <= 0:
        raise ValueError(f"{table['name']}: expected wheels and links lighter than the vehicle, found {mass - left:g} kg of them")
    chassis["mass"], chassis["position"] = left, rest.tolist()
    chassis["inertia"] = [left * (0.38 * track) ** 2, 0.85 * turning, turning]


def _springs(axle: Table, steering: Table, sprung: float, frequency: float, damping: float, bar: float) -> None:
    """Linear springs, dampers and roll bar of an axle that carries `sprung` kg per wheel as designed."""
    travel, _, values = solve_axle(axle, steering["link_arm"], 0.0, 1)
    middle = int(np.argmin(np.abs(travel)))
    rates = np.gradient(values[:, 0], travel, axis=0)[middle]
    ratio = -rates[_STRUT]
    stiffness = sprung * (2.0 * math.pi * frequency) ** 2
    force, spring = sprung * GRAVITY / ratio, stiffness / ratio**2
    viscous = 2.0 * damping * math.sqrt(stiffness * sprung) / ratio**2
    axle["free_length"] = float(values[middle, 0, _STRUT])
    axle["spring"] = [[-0.3, force + 0.3 * spring], [0.3, force - 0.3 * spring]]
    axle["damper"] = [[-4.0, -4.0 * viscous], [4.0, 4.0 * viscous]]
    if "bar_link" in axle or "upper_carrier" in axle:
        axle.setdefault("bar_link", axle.get("lower_carrier"))
        lever = 1.0
        axle["bar_stiffness"] = bar * stiffness / 2.0
        axle["bar_damping"], axle["bar_lever"] = 0.05 * axle["bar_stiffness"], lever


def _driveline(drive: Table, heavier: float, grown: float) -> None:
    """Torques and inertias for the mass, and a final drive that turns the motor as the reference vehicle's at the same speed."""
    drive["final_drive"] *= grown
    for name in ("full_throttle", "zero_throttle"):
        drive[name] = [[speed, heavier * torque] for speed, torque in drive[name]]
    for name in ("shaft_inertia", "centre_lock_limit", "axle_lock_limit", "axle_shaft_inertia", "box_inertia"):
        drive[name] *= heavier
    drive["brake_torque"] *= heavier * grown


def _angle_of_command(front: Table, steering: Table) -> list[float]:
    """Mean road-wheel angle of both wheels, by polynomial of a command in [-1, 1], from the hardpoints at rest."""
    limit = steering["max_angle"]
    angles = []
    for side in (1, -1):
        travel, pitman, values = solve_axle(front, steering["link_arm"], limit, side)
        row = values[int(np.argmin(np.abs(travel)))]
        a_x, a_z = row[:, _A_X], row[:, _A_X + 1]
        angles.append(np.arctan2(-a_x, np.sqrt(1.0 - a_x**2 - a_z**2)))
    return [float(c) for c in np.polynomial.polynomial.polyfit(pitman / limit, np.mean(angles, axis=0), 5)]
