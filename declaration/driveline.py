"""Driveline: speeds of wheels that a log does not measure, from the balance of forces and torques within the model.

What the wheels push is known without their speeds: sum F_x = M a_x, a_x as an accelerometer reads it. An open axle differential
gives both wheels of an axle the same torque, m_y,left = m_y,right; the centre gives both axles the same speed, or shares the
torque. Slips that fulfil this with the force law belong to one n: each hypothesis of n has its own, and none is measured noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import casadi as ca

from softsoil.symbolic.bicycle import Corner, body_force, radius_of
from softsoil.symbolic.effect import each_wheel
from softsoil.symbolic.history import lag_share
from softsoil.symbolic.model import Correction, Memory, Model, Quantities, Scalar
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import DRIVELINE

NAME = "driveline"
AXLES, SIDES = ("f", "r"), ("l", "r")
SETTLING = 0.03
"""s: time constant of the Newton iteration by which slips follow the balance, one step per time step; it averages the
accelerometer's noise, and is short beside the motions of a vehicle."""
LEAST_STIFFNESS = 0.5
"""dF_x/d(slip) over the load that the iteration takes at least: a spinning wheel has none."""
SLIPS = (-0.3, 0.6)
"""Rim speed over the wheel's own, less one: beyond, a wheel is locked or digs, which no balance of steady slips describes."""
FIRST_SLIP = 0.03
"""Slip of a driven wheel on soft soil at the start of a history."""
STANDING = 0.5
"""m/s: speed below which no speed is divided by."""


def with_driveline(model: Model, wheels: Sequence[str]) -> Model:
    """The bicycle `model` whose `wheels` turn as the balance of forces asks, whatever their speed inputs say.

    Newton's method, one iteration per time step, along the history of the slips k = r omega/v_x - 1: sum F_x = M a_x with dF_x/dk
    of the law, per axle m_y,left = m_y,right, and between two axles r omega_f = r omega_r or T_f = front_drive (T_f + T_r).
    Where one wheel of an axle is measured, its torque is the other's; where both wheels are taken as one, its speed is.
    wheels: of "fl", "fr", "rl", "rr", those whose speed is not measured; of none, or of a model that has a driveline, the model
    as it is.
    """
    if not wheels or turns_wheels(model):
        return model
    names = tuple(axle + side for axle in AXLES for side in SIDES if axle + side in wheels)
    measured = tuple(_other(c) for c in names if _other(c) not in names)
    slips = Layout(
        tuple(Signal(f"slip_{c}", "", f"rim speed over the wheel's own less one, {c}", FIRST_SLIP) for c in names)
    )
    cells = Layout(tuple(replace(s, name=f"kept_{s.name}") for s in slips))

    def turned(q: Quantities, corner: Corner) -> Corner:
        free = [c for c in _names(corner) if c in names]
        if not free or corner.contact is None:
            return corner
        if len(free) < len(_names(corner)):
            return corner.with_(contact=replace(corner.contact, omega=q[f"spin_{_other(free[0])}"]))
        rim = corner.contact.v_x * (1.0 + _mean([q[f"slip_{c}"] for c in free]))
        return corner.with_(contact=replace(corner.contact, omega=rim / radius_of(q, corner)))

    def advance(q: Quantities) -> Quantities:
        share, moves, kept = lag_share(q["dt"], SETTLING), _moves(q, names), q["memory"]
        return {
            f"kept_slip_{c}": ca.fmin(ca.fmax(kept[f"kept_slip_{c}"] + share * moves[c], SLIPS[0]), SLIPS[1])
            for c in names
        }

    memory = Memory(
        NAME, cells, slips,
        read=lambda q: {s.name: q["memory"][f"kept_{s.name}"] for s in slips},
        advance=advance,
        start=lambda q: dict.fromkeys(cells.names, FIRST_SLIP),
    )  # fmt: skip
    numbers = DRIVELINE.with_nominal(**getattr(model.geometry, NAME, {}))
    turning = Correction(
        each_wheel(turned), ("radius", "radius_rear", "wheel.contact.v_x", *(f"spin_{c}" for c in measured)),
        sets=("wheel.contact.omega",), effect=NAME,
    )
    return replace(model, u=model.u + slips, p=model.p + numbers, memories=(*model.memories, memory)).correct(
        "contacts", turning
    )


def turns_wheels(model: Model) -> bool:
    """Whether the model turns wheels by the balance of forces."""
    return any(memory.name == NAME for memory in model.memories)


def _moves(q: Quantities, names: Sequence[str]) -> dict[str, Scalar]:
    """Wheel -> how far its slip is from the balance, to first order."""
    wheels: dict[str, Any] = {c: w for w in q["wheels"] for c in _names(w)}
    ahead, all_slips = ca.vertcat(*[wheels[c].force.f_x for c in names]), ca.vertcat(*[q[f"slip_{c}"] for c in names])
    slopes = ca.jtimes(ahead, all_slips, ca.DM.ones(len(names)))  # a wheel's force has no slip but its own
    slope = {c: ca.fmax(slopes[i], LEAST_STIFFNESS * wheels[c].load) for i, c in enumerate(names)}
    pull = {c: -w.force.m_y / radius_of(q, w) for c, w in wheels.items()}
    moves = {c: (pull[_other(c)] - pull[c]) / slope[c] for c in names if _other(c) not in names}
    axles = [axle for axle in AXLES if all(axle + side in names for side in SIDES)]
    if not axles:
        return moves
    stiff = {axle: slope[f"{axle}l"] + slope[f"{axle}r"] for axle in axles}
    missing = q["mass"] * q["specific_x"] - sum(w.count * body_force(w)[0] for w in q["wheels"])
    mean = {axles[0]: missing / stiff[axles[0]]} if len(axles) == 1 else _both_axles(q, stiff, missing, pull, wheels)
    for axle in axles:
        aside = (pull[f"{axle}r"] - pull[f"{axle}l"]) / stiff[axle]
        moves |= {f"{axle}l": mean[axle] + aside, f"{axle}r": mean[axle] - aside}
    return moves


def _both_axles(
    q: Quantities, stiff: dict[str, Scalar], missing: Scalar, pull: dict[str, Scalar], wheels: dict[str, Any]
) -> dict[str, Scalar]:
    """Axle -> move of its slip that gives both together the force that is missing (N), and the centre what it does: to rims, as
    the final drives of axles with wheels of two sizes are made."""
    lock, front, total = q["centre_lock"], q["front_drive"], stiff["f"] + stiff["r"]
    rim = {c: 0.5 * radius_of(q, w) * w.contact.omega for c, w in wheels.items()}
    apart = rim["fl"] + rim["fr"] - rim["rl"] - rim["rr"]
    faster = total * apart / ca.sqrt(q["u"] * q["u"] + STANDING**2)
    uneven = (1.0 - front) * (pull["fl"] + pull["fr"]) - front * (pull["rl"] + pull["rr"])
    wrong = lock * faster + (1.0 - lock) * uneven
    by_front = lock * total + (1.0 - lock) * (1.0 - front) * stiff["f"]
    by_rear = -lock * total - (1.0 - lock) * front * stiff["r"]
    scale = stiff["f"] * by_rear - stiff["r"] * by_front
    return {
        "f": (missing * by_rear + stiff["r"] * wrong) / scale,
        "r": -(stiff["f"] * wrong + by_front * missing) / scale,
    }


def _names(corner: Corner) -> tuple[str, ...]:
    """Wheels that a corner stands for: fl, or both of an axle taken as one."""
    return (corner.name,) if corner.side else tuple(corner.axle + side for side in SIDES)


def _other(wheel: str) -> str:
    """The other wheel of an axle: fl -> fr."""
    return wheel[0] + SIDES[1 - SIDES.index(wheel[1])]


def _mean(values: Sequence[Scalar]) -> Scalar:
    return sum(values) / len(values)
