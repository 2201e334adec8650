"""The aligning moment of the contacts."""

from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, Vehicle
from softsoil.symbolic.model import Quantities


def effect(vehicle: Vehicle) -> Effect:
    """Lateral forces act off the wheels' centres: M_z += sum over wheels of share * integral X dF_y, by the force law itself.

    1 is what the soil under a rigid wheel does; a suspension whose trail or compliance takes part of it up leaves less, and
    steered wheels may leave theirs to the steering.
    """

    def share(axle: str, where: str) -> Signal:
        return Signal(f"aligning_{axle}", "", f"share of the {where} wheels' aligning moment", 0.0, 0.0, 2.0, spread=1)

    return Effect(
        name="aligning_moment",
        doc="the aligning moment of the contacts: lateral stress acts ahead of and behind the wheels' centres",
        kind="soil",
        reference="moment of the contact stresses about the wheel's vertical",
        parameters=Layout.of(share("f", "front"), share("r", "rear")),
        typical={"aligning_f": 1.0, "aligning_r": 1.0},
        corrections={"balance": Correction(_compute, reads=("wheel.force.m_z",), adds=("moment_z",))},
        signatures=("cornering slope", "turning moment"),
        separates="turns at several speeds and steering rates",
        rests_on=("omega_z",),
    )


def _compute(q: Quantities) -> Quantities:
    moment = sum(q[f"aligning_{corner.axle}"] * corner.count * corner.force.m_z for corner in q["wheels"])
    return {"moment_z": q["moment_z"] + moment}
