"""An inertial unit that is turned on the vehicle: its heading is not that of the vehicle's axis."""

from __future__ import annotations

from softsoil.symbolic.effect import Effect
from softsoil.symbolic.signals import Layout, Signal


def heading_offset() -> Effect:
    """y_psi = psi + b, while positions move along psi and the side slip."""
    return Effect(
        name="heading_offset",
        doc="heading sensor turned on the vehicle",
        reference="rigid-body kinematics",
        parameters=Layout.of(Signal("heading_offset", "rad", "heading measured less true one", 0.0, -0.5, 0.5, spread=0.05)),
        typical={"heading_offset": 0.03},
        corrections={"outputs": lambda q: {"y_psi": q["y_psi"] + q["heading_offset"]}},
        confusable=("lever_arm",),
        separates="straight driving: the course is then the heading, wherever the position is measured",
    )
