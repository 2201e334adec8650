"""Road wheels that follow the command with a first-order lag."""

from softsoil.symbolic.effect import Effect, Layout, Signal, Vehicle
from softsoil.symbolic.history import lag_share
from softsoil.symbolic.model import Memory, Quantities
from softsoil.symbolic.smooth import smooth_positive
from softsoil.symbolic.steering import RESTS_ON, SEPARATES, added, differences

CELLS = Layout.of(
    Signal("lag_angle_state", "rad", "lagged steering angle"),
    Signal("lag_rate_state", "rad/s", "lagged steering rate"),
    Signal("lag_share", "", "share of the way that a step goes", 1.0, 0.0, 1.0),
    Signal("lag_step", "s", "length of that step", 0.0, 0.0, 1.0),
)
WIDTH = 2e-4
"""s: a time constant this small is none."""


def effect(vehicle: Vehicle) -> Effect:
    """tau d(delta_a)/dt + delta_a = delta (first-order actuator), as a history: exact over a step in which delta is a line.

    With delta = a + b t that is delta_a = delta - b tau + (what is left of the start) exp(-t/tau), which goes on below tau = 0: a
    steering angle that is recorded late, so that the wheels are ahead of it by b |tau|.
    """
    return Effect(
        name="steering_lag",
        doc="road wheels follow the command with a first-order lag; a negative one is an angle that is recorded late",
        kind="steering",
        reference="first-order actuator",
        parameters=Layout.of(Signal("steering_lag", "s", "time constant of the steering", 0.0, -0.08, 1.0, spread=0.4)),
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
    m, behind = q["memory"], q["steering_lag"] * q["steer_rate"]
    left = m["lag_angle_state"] - q["steer"] + m["lag_step"] * q["steer_rate"] + behind
    rate = m["lag_rate_state"] + m["lag_share"] * (q["steer_rate"] - m["lag_rate_state"])
    return q["steer"] - behind + (1.0 - m["lag_share"]) * left, rate


def _read(q: Quantities) -> Quantities:
    angle, rate = _follow(q)
    return {"lagged_angle": angle - q["steer"], "lagged_rate": rate - q["steer_rate"]}


def _advance(q: Quantities) -> Quantities:
    angle, rate = _follow(q)
    share = lag_share(q["dt"], smooth_positive(q["steering_lag"], WIDTH))
    return {"lag_angle_state": angle, "lag_rate_state": rate, "lag_share": share, "lag_step": q["dt"]}


def _start(q: Quantities) -> Quantities:
    behind = q["steering_lag"] * q["steer_rate"]
    return {"lag_angle_state": q["steer"] - behind, "lag_rate_state": q["steer_rate"], "lag_share": 1.0, "lag_step": 0.0}
