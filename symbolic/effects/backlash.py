"""Play in the steering."""

import casadi as ca

from softsoil.symbolic.effect import Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Memory, Quantities, Scalar
from softsoil.symbolic.steering import RESTS_ON, SEPARATES, added, differences

CELLS = Layout.of(Signal("play_left_at", "rad", "angle at which the play left the road wheels"))


def effect(vehicle: Vehicle) -> Effect:
    """Play operator: the road wheels rest while the command moves inside +-backlash of them."""
    memory = Memory(
        "backlash",
        CELLS,
        differences("play", "the play"),
        _read,
        advance=lambda q: {"play_left_at": _held(q, q["memory"]["play_left_at"])},
        start=lambda q: {"play_left_at": q["steer"]},
    )
    return Effect(
        name="backlash",
        doc="play in the steering",
        kind="steering",
        reference="play operator (hysteresis)",
        parameters=Layout.of(Signal("backlash", "rad", "half width of the play at the road wheels", 0.0, 0.0, 0.2, spread=0.1)),
        typical={"backlash": 0.03},
        corrections={"inputs": added("play")},
        memories=(memory,),
        signatures=("late steering", "cornering slope"),
        separates=SEPARATES,
        rests_on=RESTS_ON,
        answers_to={"steer_backlash": ("backlash",)},
    )


def _held(q: Quantities, before: Scalar) -> Scalar:
    return ca.fmax(ca.fmin(before, q["steer"] + q["backlash"]), q["steer"] - q["backlash"])


def _read(q: Quantities) -> Quantities:
    before = q["memory"]["play_left_at"]
    angle = _held(q, before)
    inside = ca.logic_and(ca.fabs(angle - before) < 1e-9, q["backlash"] > 1e-9)
    return {"play_angle": angle - q["steer"], "play_rate": ca.if_else(inside, -q["steer_rate"], 0.0)}
