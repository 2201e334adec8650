"""What effects between the steering command and the road wheels share. Each adds its difference to the angle: they compose."""

from softsoil.symbolic.model import Correction, Quantities
from softsoil.symbolic.signals import Layout, Signal

SEPARATES = "steering at several rates, amplitudes and speeds, with straight stretches between"
RESTS_ON = ("steer", "omega_z")


def differences(prefix: str, doc: str) -> Layout:
    """Layout of <prefix>_angle and <prefix>_rate, which something named `doc` adds to steering angle and rate."""
    return Layout.of(
        Signal(f"{prefix}_angle", "rad", f"steering angle that {doc} adds"),
        Signal(f"{prefix}_rate", "rad/s", f"steering rate that {doc} adds"),
    )


def added(prefix: str) -> Correction:
    """The correction that adds <prefix>_angle and <prefix>_rate to the road wheels' angle and rate."""

    def compute(q: Quantities) -> Quantities:
        return {"delta": q["delta"] + q[f"{prefix}_angle"], "delta_rate": q["delta_rate"] + q[f"{prefix}_rate"]}

    return Correction(compute, adds=("delta", "delta_rate"))
