"""Road wheels that follow the command after a dead time."""

from softsoil.symbolic.effect import Effect, Layout, Signal, Vehicle
from softsoil.symbolic.history import late_by
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.steering import RESTS_ON, SEPARATES, added

CELLS = 36
SPACING = 0.0115
"""s between remembered commands: 36 cells reach 0.4 s back."""
VALUES = (Signal("angle", "rad", "steering command"), Signal("rate", "rad/s", "rate of the steering command"))


def effect(vehicle: Vehicle) -> Effect:
    """delta_a(t) = delta(t - T): a dead time between command and road wheels, from remembered commands."""
    return Effect(
        name="steering_delay",
        doc="road wheels follow the command after a dead time",
        kind="steering",
        reference="transport delay",
        parameters=Layout.of(Signal("steering_delay", "s", "dead time of the steering", 0.0, 0.0, 0.4, spread=0.4)),
        typical={"steering_delay": 0.1},
        corrections={"inputs": added("delayed")},
        memories=(late_by("steering_delay", "delayed", VALUES, _present, _still, CELLS, SPACING),),
        signatures=("late steering",),
        separates=SEPARATES,
        rests_on=RESTS_ON,
        answers_to={"steer_delay": ("steering_delay",)},
    )


def _present(q: Quantities) -> Quantities:
    return {"angle": q["steer"], "rate": q["steer_rate"]}


def _still(q: Quantities) -> Quantities:
    return {"angle": q["steer"], "rate": 0.0}
