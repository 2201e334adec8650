"""An inertial unit that is turned on the vehicle: its heading is not that of the vehicle's axis."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle


def effect(vehicle: Vehicle) -> Effect:
    """y_psi = psi + b, while positions move along psi and the side slip."""
    return Effect(
        name="heading_offset",
        doc="heading sensor turned on the vehicle",
        kind="sensor",
        reference="rigid-body kinematics",
        parameters=Layout.of(Signal("heading_offset", "rad", "heading measured less true one", 0.0, -0.5, 0.5, spread=0.05)),
        typical={"heading_offset": 0.03},
        corrections={"outputs": Correction(lambda q: {"y_psi": q["y_psi"] + q["heading_offset"]}, adds=("y_psi",))},
        signatures=("late or displaced sensor",),
        separates="straight driving: the course is then the heading, wherever the position is measured",
        rests_on=("x", "y", "psi"),
    )
