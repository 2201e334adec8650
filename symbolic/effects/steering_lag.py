"""Road wheels that follow the command with a first-order lag."""

from softsoil.symbolic.effect import Effect, Layout, Signal, Vehicle
from softsoil.symbolic.history import lag_share
from softsoil.symbolic.model import Memory, Quantities
from softsoil.symbolic.steering import RESTS_ON, SEPARATES, added, differences

CELLS = Layout.of(
    Signal("lag_angle_state", "rad", "lagged steering angle"),
    Signal("lag_rate_state", "rad/s", "lagged steering rate"),
    Signal("lag_share", "", "share of the way that a step goes", 1.0, 0.0, 1.0),
)


def effect(vehicle: Vehicle) -> Effect:
    """tau d(delta_a)/dt + delta_a = delta (first-order actuator), as a history: exact over a step with delta held."""
    return Effect(
        name="steering_lag",
        doc="road wheels follow the command with a first-order lag",
        kind="steering",
        reference="first-order actuator",
        parameters=Layout.of(Signal("steering_lag", "s", "time constant of the steering", 0.0, 0.0, 1.0, spread=0.4)),
        typical={"steering_lag": 0.1},
        corrections={"inputs": added("lagged")},
        memories=(Memory("steering_lag", CELLS, differences("lagged", "the lag"), _read, _advance, _start),),
        signatures=("late steering",),
        separates=SEPARATES,
        repeats=True,
        rests_on=RESTS_ON,
        answers_to={"steer_lag": ("steering_lag",)},
    )


def _follow(q: Quantities) -> tuple:
    m = q["memory"]
    angle = m["lag_angle_state"] + m["lag_share"] * (q["steer"] - m["lag_angle_state"])
    return angle, m["lag_rate_state"] + m["lag_share"] * (q["steer_rate"] - m["lag_rate_state"])


def _read(q: Quantities) -> Quantities:
    angle, rate = _follow(q)
    return {"lagged_angle": angle - q["steer"], "lagged_rate": rate - q["steer_rate"]}


def _advance(q: Quantities) -> Quantities:
    angle, rate = _follow(q)
    return {"lag_angle_state": angle, "lag_rate_state": rate, "lag_share": lag_share(q["dt"], q["steering_lag"] + 1e-6)}


def _start(q: Quantities) -> Quantities:
    return {"lag_angle_state": q["steer"], "lag_rate_state": q["steer_rate"], "lag_share": 1.0}
