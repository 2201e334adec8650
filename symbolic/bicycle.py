"""The soft-soil bicycle (3 DoF): the only place where its equations stand.

Conventions: ISO 8855 (x forward, y left, z up), SI units, radians. (x, y) is the point on the FRONT AXLE; (u, v) is the
velocity of the CENTRE OF GRAVITY in the yaw frame: hence v + l_f omega_z in the position rows. a_x is du/dt (an
accelerometer reads du/dt - v omega_z). Wheel speeds and steering rate are inputs. Forces are per wheel; an axle has two.
Valid for forward motion (u > 0) only; below a few tenths of a metre per second the force laws fade out smoothly.

The stages, in order, and what an effect may correct after each:
inputs (delta, delta_rate, du, spin_*), vehicle (mass, l_f, l_r, yaw_inertia, h_cg, burden: mass over the declared one,
axle_ahead: how far ahead of the centre of gravity (x, y) is, rest_load_r: on the rear axle at rest, body_moment: what rolls the
body to the right besides lateral force, aside_f, aside_r: how far left of its wheels' designed places an axle's contacts are,
0 without an effect),
loads (load_f, load_r: axle loads),
tracks (wheels: position, load, steering angle, count), contacts (each wheel's soil and contact), forces (each wheel's
force), balance (force_y, moment_z in the yaw frame), rates (d_*), outputs (y_*).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from softsoil.files.identify_verdict import CONTRADICTED
from softsoil.symbolic.law_graph import wheel_force
from softsoil.symbolic.model import Model, Quantities, Scalar, Stage
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil
from softsoil.symbolic.vehicle import GRAVITY, NUMBERS, SIMULATOR, Vehicle
from softsoil.symbolic.wheel import Contact, ForceLaw, Wheel, WheelForce, force_law, simulated

STATES = Layout.of(
    Signal("x", "m", "global x position of the front axle"),
    Signal("y", "m", "global y position of the front axle"),
    Signal("psi", "rad", "yaw angle"),
    Signal("u", "m/s", "longitudinal velocity of the centre of gravity", 5.0),
    Signal("v", "m/s", "lateral velocity of the centre of gravity"),
    Signal("omega_z", "rad/s", "yaw rate"),
)
INPUTS = Layout.of(
    Signal("steer", "rad", "steering angle at the road wheels"),
    Signal("steer_rate", "rad/s", "rate of the steering angle"),
    Signal("a_x", "m/s^2", "rate of u"),
    Signal("omega_fl", "rad/s", "spin of the front left wheel", 15.0),
    Signal("omega_fr", "rad/s", "spin of the front right wheel", 15.0),
    Signal("omega_rl", "rad/s", "spin of the rear left wheel", 15.0),
    Signal("omega_rr", "rad/s", "spin of the rear right wheel", 15.0),
)


@dataclass(frozen=True)
class Corner:
    """One wheel, or the two wheels of an axle taken as one.

    axle: "f" or "r"; side: +1 left, -1 right, 0 both; count: wheels it stands for; y: lateral position (m);
    load: per wheel (N); delta: steering angle (rad); spin (rad/s); x: position ahead of the axle (m); apart: what the wheel is
    turned beyond delta, a small angle (rad); scrub: how far left of the axis that it is steered about its centre is (m); the rest
    is filled in by later stages.
    """

    axle: str
    side: int
    count: int
    y: Scalar
    load: Scalar
    delta: Scalar
    spin: Scalar
    x: Scalar = 0.0
    apart: Scalar = 0.0
    scrub: Scalar = 0.0
    soil: Soil | None = None
    contact: Contact | None = None
    force: WheelForce | None = None

    @property
    def name(self) -> str:
        """Name for messages and probes: f, fl, fr, r, rl, rr."""
        return self.axle + {0: "", 1: "l", -1: "r"}[self.side]

    @property
    def heading(self) -> tuple[Scalar, Scalar]:
        """cos and sin of delta + apart: one pair for an axle, and series in apart, within 3e-6 at 0.35 rad."""
        cos, sin, a = ca.cos(self.delta), ca.sin(self.delta), self.apart
        square = a * a
        c, s = 1.0 - square * (0.5 - square * (1.0 / 24.0)), a * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
        return cos * c - sin * s, sin * c + cos * s

    def with_(self, **values: Any) -> Corner:
        """The same corner with other values, by name."""
        return replace(self, **values)


def nominal_bicycle(
    vehicle: Vehicle, soil: Soil, law: ForceLaw | str = "turn_slip", free: Layout = Layout()  # noqa: B008
) -> Model:
    """The paper's bicycle (eq. (bicycle)) on soft soil: states of eq. (bicycle_states), outputs the states.

    vehicle: its numbers; soil: nominal values of the soil parameters p (n once per axle, n_f and n_r);
    law: per-wheel force law, or its name: then on the soil that the vehicle's simulator, if any, stands for; free: numbers of the
    vehicle, or of the simulator, that become parameters p in place of constants.
    Effects are added with `softsoil.symbolic.effect.add_effect`.
    """
    law = vehicle_law(vehicle, law)
    stages = (
        Stage("inputs", _inputs),
        Stage("vehicle", lambda q: vehicle_quantities(vehicle, {name: q[name] for name in free.names})),
        Stage("loads", _loads),
        Stage("tracks", _tracks),
        Stage("contacts", lambda q: _contacts(q, soil.name)),
        Stage("forces", lambda q: forces(q, simulated(law, {name: q[name] for name in free.names if name in SIMULATOR}))),
        Stage("balance", _balance),
        Stage("rates", _rates),
        Stage("outputs", lambda q: {f"y_{name}": q[name] for name in STATES.names}),
    )
    doubted = tuple(name for name, one in (("vehicle", vehicle), ("soil", soil)) if one.verdict == CONTRADICTED)
    parameters = soil_parameters(soil) + free
    return Model(
        f"bicycle_{law.name}", STATES, INPUTS, parameters, STATES, stages, (), (), vehicle, doubted, soil.joint_error
    )  # fmt: skip


def vehicle_law(vehicle: Vehicle, law: ForceLaw | str) -> ForceLaw:
    """The force law, or the one of a name, as on the vehicle's simulated soil, where it declares one; options of a law that are
    not at their defaults stay as they are."""
    return simulated(force_law(law) if isinstance(law, str) else law, vehicle.simulator, given=True)


def soil_parameters(soil: Soil) -> Layout:
    """Layout of the soil parameters: n_f, n_r, then the others, with `soil`'s values as nominal and its errors as spread."""
    n = SOIL_SIGNALS["n"]
    values = soil.parameters()
    both = Layout.of(*(replace(n, name=f"n_{a}", doc=f"{n.doc}, {where}") for a, where in (("f", "front"), ("r", "rear"))))
    both = both.with_nominal(n_f=values["n"], n_r=values["n"])
    stds = dict(soil.uncertainty)
    rest = (replace(s, nominal=values[s.name], spread=stds.get(s.name, s.spread)) for s in SOIL_SIGNALS.without("n"))
    return both + Layout.of(*rest)


def _inputs(q: Quantities) -> Quantities:
    spins = {f"spin_{corner}": q[f"omega_{corner}"] for corner in ("fl", "fr", "rl", "rr")}
    motion = {"delta": q["steer"], "delta_rate": q["steer_rate"], "du": q["a_x"]}
    return {**motion, "specific_x": q["a_x"] - q["v"] * q["omega_z"], "gravity_x": 0.0, "gravity_y": 0.0, **spins}


def vehicle_quantities(vehicle: Vehicle, free: Quantities) -> Quantities:
    """Numbers of the vehicle as quantities; `free`: those that are parameters of the model. A rear wheel of another size than a
    front one keeps to it."""
    declared = {n.name: getattr(vehicle, n.name) for n in NUMBERS if n.modelled}
    numbers = {**declared, "track_rear": vehicle.rear_track, **free}
    return {
        **numbers,
        "radius_rear": _as_declared(numbers["radius"], vehicle.rear_radius / vehicle.radius),
        "width_rear": _as_declared(numbers["width"], vehicle.rear_width / vehicle.width),
        "burden": 1.0,
        "body_moment": 0.0,
        "axle_ahead": numbers["l_f"],
        "rest_load_r": numbers["mass"] * GRAVITY * numbers["l_f"] / (numbers["l_f"] + numbers["l_r"]),
        "aside_f": 0.0,
        "aside_r": 0.0,
    }


def _as_declared(front: Scalar, share: float) -> Scalar:
    """The size of a rear wheel from that of a front one and its declared share of it."""
    return front if share == 1.0 else share * front


def _loads(q: Quantities) -> Quantities:
    """Axle loads, static plus longitudinal transfer: F_zf = M (g (l_r - e) - a_x h)/L."""
    wheelbase = q["l_f"] + q["l_r"]
    front = q["mass"] * (GRAVITY * (q["l_r"] - q["load_offset"]) - q["specific_x"] * q["h_cg"]) / wheelbase
    return {"load_f": front, "load_r": q["mass"] * GRAVITY - front}


def _tracks(q: Quantities) -> Quantities:
    """The paper's single track: one corner per axle, standing for two equal wheels."""
    front = Corner("f", 0, 2, q["aside_f"], q["load_f"] / 2, q["delta"], (q["spin_fl"] + q["spin_fr"]) / 2)
    rear = Corner("r", 0, 2, q["aside_r"], q["load_r"] / 2, 0.0, (q["spin_rl"] + q["spin_rr"]) / 2)
    return {"wheels": (front, rear)}


def _contacts(q: Quantities, soil_name: str) -> Quantities:
    return {"wheels": tuple(_contact(q, corner, soil_name) for corner in q["wheels"])}


def _contact(q: Quantities, corner: Corner, soil_name: str) -> Corner:
    """Velocity of the wheel centre, turned into the wheel plane; steering moves a centre that stands beside its axis."""
    arm = (q["l_f"] if corner.axle == "f" else -q["l_r"]) + corner.x
    v_x, v_y = q["u"] - corner.y * q["omega_z"], q["v"] + arm * q["omega_z"]
    cos, sin = corner.heading
    steer_rate = q["delta_rate"] if corner.axle == "f" else 0.0
    contact = Contact(
        v_x=v_x * cos + v_y * sin - corner.scrub * steer_rate,
        v_y=-v_x * sin + v_y * cos,
        dv_y=-steer_rate * (v_x * cos + v_y * sin),
        omega=corner.spin,
        load=corner.load,
        yaw_rate=steer_rate + q["omega_z"],
        steer_rate=steer_rate,
    )
    values = {name: q[name] for name in SOIL_SIGNALS.names if name != "n"}
    soil = Soil(soil_name, n=q[f"n_{corner.axle}"], **values)
    return corner.with_(soil=soil, contact=contact)


def forces(q: Quantities, law: ForceLaw) -> Quantities:
    """The wheels with the force of a law on each: the stage "forces"."""
    wheels = {"f": Wheel(q["radius"], q["width"]), "r": Wheel(q["radius_rear"], q["width_rear"])}
    return {"wheels": tuple(c.with_(force=wheel_force(law, c.soil, wheels[c.axle], c.contact)) for c in q["wheels"])}


def radius_of(q: Quantities, corner: Corner) -> Scalar:
    """Radius of a corner's wheel (m)."""
    return q["radius"] if corner.axle == "f" else q["radius_rear"]


def body_force(corner: Corner) -> tuple[Scalar, Scalar]:
    """(F_x, F_y) of one wheel of the corner, turned from the wheel plane into the yaw frame (N)."""
    force = corner.force
    if force is None:
        raise ValueError(f"corner {corner.name}: expected its force, found none: the stage 'forces' has not run")
    cos, sin = corner.heading
    return force.f_x * cos - force.f_y * sin, force.f_x * sin + force.f_y * cos


def _balance(q: Quantities) -> Quantities:
    """Sum of the lateral forces, their moment, and the moment of longitudinal forces on two tracks."""
    axle = {"f": 0.0, "r": 0.0}
    track_moment = 0.0
    for corner in q["wheels"]:
        f_x, f_y = body_force(corner)
        axle[corner.axle] = axle[corner.axle] + corner.count * f_y
        track_moment = track_moment + corner.count * (corner.x * f_y - corner.y * f_x)
    return {
        "force_f": axle["f"],
        "force_r": axle["r"],
        "force_y": axle["f"] + axle["r"],
        "moment_z": axle["f"] * q["l_f"] - axle["r"] * q["l_r"] + track_moment,
    }


def _rates(q: Quantities) -> Quantities:
    """Right-hand side of eq. (bicycle)."""
    cos, sin = ca.cos(q["psi"]), ca.sin(q["psi"])
    v_axle = q["v"] + q["axle_ahead"] * q["omega_z"]
    return {
        "d_x": q["u"] * cos - v_axle * sin,
        "d_y": q["u"] * sin + v_axle * cos,
        "d_psi": q["omega_z"],
        "d_u": q["du"] + q["gravity_x"],
        "d_v": q["force_y"] / q["mass"] - q["u"] * q["omega_z"] + q["gravity_y"],
        "d_omega_z": q["moment_z"] / q["yaw_inertia"],
    }
