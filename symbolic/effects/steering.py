"""Effects between the steering command and the road wheels. Each adds its difference to the angle: they compose."""

from __future__ import annotations

import casadi as ca

from softsoil.symbolic.effect import Effect
from softsoil.symbolic.history import lag_share, late_by
from softsoil.symbolic.model import Memory, Quantities
from softsoil.symbolic.signals import Layout, Signal

DELAY_CELLS = 36
DELAY_SPACING = 0.0115
"""s between remembered commands: 36 cells reach 0.4 s back."""
DELAY_VALUES = (
    Signal("angle", "rad", "steering command"),
    Signal("rate", "rad/s", "rate of the steering command"),
)
SEPARATES = "steering at several rates, amplitudes and speeds, with straight stretches between"


def _difference(prefix: str, doc: str) -> Layout:
    return Layout.of(
        Signal(f"{prefix}_angle", "rad", f"steering angle that {doc} adds"),
        Signal(f"{prefix}_rate", "rad/s", f"steering rate that {doc} adds"),
    )


def _added(prefix: str):
    def compute(q: Quantities) -> Quantities:
        return {"delta": q["delta"] + q[f"{prefix}_angle"], "delta_rate": q["delta_rate"] + q[f"{prefix}_rate"]}

    return compute


def steering_lag() -> Effect:
    """tau d(delta_a)/dt + delta_a = delta (first-order actuator), as a history: exact over a step with delta held."""
    cells = Layout.of(
        Signal("lag_angle_state", "rad", "lagged steering angle"),
        Signal("lag_rate_state", "rad/s", "lagged steering rate"),
        Signal("lag_share", "", "share of the way that a step goes", 1.0, 0.0, 1.0),
    )

    def follow(q: Quantities) -> tuple:
        m = q["memory"]
        angle = m["lag_angle_state"] + m["lag_share"] * (q["steer"] - m["lag_angle_state"])
        return angle, m["lag_rate_state"] + m["lag_share"] * (q["steer_rate"] - m["lag_rate_state"])

    def read(q: Quantities) -> Quantities:
        angle, rate = follow(q)
        return {"lagged_angle": angle - q["steer"], "lagged_rate": rate - q["steer_rate"]}

    def advance(q: Quantities) -> Quantities:
        angle, rate = follow(q)
        share = lag_share(q["dt"], q["steering_lag"] + 1e-6)
        return {"lag_angle_state": angle, "lag_rate_state": rate, "lag_share": share}

    def start(q: Quantities) -> Quantities:
        return {"lag_angle_state": q["steer"], "lag_rate_state": q["steer_rate"], "lag_share": 1.0}

    return Effect(
        name="steering_lag",
        doc="road wheels follow the command with a first-order lag",
        reference="first-order actuator",
        parameters=Layout.of(Signal("steering_lag", "s", "time constant of the steering", 0.0, 0.0, 1.0, spread=0.4)),
        typical={"steering_lag": 0.1},
        corrections={"inputs": _added("lagged")},
        memories=(Memory("steering_lag", cells, _difference("lagged", "the lag"), read, advance, start),),
        confusable=("steering_delay", "relaxation", "backlash"),
        separates=SEPARATES,
    )


def steering_delay() -> Effect:
    """delta_a(t) = delta(t - T): a dead time between command and road wheels, from remembered commands."""

    def present(q: Quantities) -> Quantities:
        return {"angle": q["steer"], "rate": q["steer_rate"]}

    def still(q: Quantities) -> Quantities:
        return {"angle": q["steer"], "rate": 0.0}

    return Effect(
        name="steering_delay",
        doc="road wheels follow the command after a dead time",
        reference="transport delay",
        parameters=Layout.of(Signal("steering_delay", "s", "dead time of the steering", 0.0, 0.0, 0.4, spread=0.4)),
        typical={"steering_delay": 0.1},
        corrections={"inputs": _added("delayed")},
        memories=(late_by("steering_delay", "delayed", DELAY_VALUES, present, still, DELAY_CELLS, DELAY_SPACING),),
        confusable=("steering_lag", "relaxation", "backlash", "sensor_delay"),
        separates=SEPARATES,
    )


def backlash() -> Effect:
    """Play operator: the road wheels rest while the command moves inside +-backlash of them."""
    cells = Layout.of(Signal("play_angle", "rad", "angle at which the play left the road wheels"))

    def held(q: Quantities):
        before = q["memory"]["play_angle"]
        return ca.fmax(ca.fmin(before, q["steer"] + q["backlash"]), q["steer"] - q["backlash"])

    def read(q: Quantities) -> Quantities:
        angle = held(q)
        resting = ca.fabs(angle - q["memory"]["play_angle"]) < 1e-9
        inside = ca.logic_and(resting, q["backlash"] > 1e-9)
        return {"play_added": angle - q["steer"], "play_rate": ca.if_else(inside, -q["steer_rate"], 0.0)}

    return Effect(
        name="backlash",
        doc="play in the steering",
        reference="play operator (hysteresis)",
        parameters=Layout.of(
            Signal("backlash", "rad", "half width of the play at the road wheels", 0.0, 0.0, 0.2, spread=0.1)
        ),
        typical={"backlash": 0.03},
        corrections={
            "inputs": lambda q: {"delta": q["delta"] + q["play_added"], "delta_rate": q["delta_rate"] + q["play_rate"]}
        },
        memories=(
            Memory(
                "backlash",
                cells,
                Layout.of(
                    Signal("play_added", "rad", "steering angle that the play adds"),
                    Signal("play_rate", "rad/s", "steering rate that the play adds"),
                ),
                read,
                advance=lambda q: {"play_angle": held(q)},
                start=lambda q: {"play_angle": q["steer"]},
            ),
        ),
        confusable=("steering_lag", "steering_delay", "steering_gain"),
        separates=SEPARATES,
    )


def steering_offset() -> Effect:
    """delta_a = delta + d0."""
    return Effect(
        name="steering_offset",
        doc="road wheels stand off the command by a constant angle",
        reference="wheel alignment",
        parameters=Layout.of(Signal("steering_offset", "rad", "constant steering angle", 0.0, -0.2, 0.2, spread=0.05)),
        typical={"steering_offset": 0.02},
        corrections={"inputs": lambda q: {"delta": q["delta"] + q["steering_offset"]}},
        confusable=("bank", "side_force", "yaw_moment"),
        separates="driving on several headings at several speeds",
    )


def steering_gain() -> Effect:
    """delta_a = k delta."""
    return Effect(
        name="steering_gain",
        doc="road wheels turn by another ratio than the command says",
        reference="steering ratio",
        parameters=Layout.of(Signal("steering_gain", "", "road-wheel angle over command", 1.0, 0.5, 1.5, spread=0.1)),
        typical={"steering_gain": 1.05},
        corrections={
            "inputs": lambda q: {
                "delta": q["delta"] + (q["steering_gain"] - 1.0) * q["steer"],
                "delta_rate": q["delta_rate"] + (q["steering_gain"] - 1.0) * q["steer_rate"],
            }
        },
        confusable=("backlash", "payload"),
        separates="small and large steering angles at several speeds: n changes the slope, the gain the angle itself",
    )
