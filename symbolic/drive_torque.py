"""The torque that drives the wheels, as a model without an engine knows it: what a shaft along the vehicle hands on."""

from __future__ import annotations

from softsoil.symbolic.bicycle import body_force
from softsoil.symbolic.history import lag_share
from softsoil.symbolic.model import Memory, Quantities, Scalar
from softsoil.symbolic.signals import Layout, Signal

TORQUE_TIME = 0.2
"""s: first-order lag of the torque; a suspended body rolls no faster, and measured wheel speeds are noisy."""


def drive_torque(effect: str) -> Memory:
    """Memory of an effect: provides drive_torque (N m), the sum over the wheels, driving positive, TORQUE_TIME late."""

    def advance(q: Quantities) -> Quantities:
        before = q["memory"]["torque"]
        return {"torque": before + lag_share(q["dt"], TORQUE_TIME) * (_torque(q) - before)}

    return Memory(
        f"{effect}_torque",
        Layout.of(Signal("torque", "N m", "driving torque of the wheels, a moment late")),
        Layout.of(Signal("drive_torque", "N m", "driving torque of the wheels, a moment late")),
        read=lambda q: {"drive_torque": q["memory"]["torque"]},
        advance=advance,
        start=lambda q: {"torque": _torque(q)},
    )


def _torque(q: Quantities) -> Scalar:
    """What turns the wheels against the soil's moments, -sum m_y, put right by the radius times the force that is missing.

    A wheel's slip is a small difference of measured speeds; that its force accelerates the vehicle as seen,
    sum F_x = M (du - v omega_z), takes the error of the slip out of the torque.
    """
    forward = sum(corner.count * body_force(corner)[0] for corner in q["wheels"])
    missing = q["mass"] * (q["du"] - q["v"] * q["omega_z"]) - forward
    return q["radius"] * missing - sum(corner.count * corner.force.m_y for corner in q["wheels"])
