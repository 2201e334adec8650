"""The reference simulator's joints of half shafts, which hand a torque on about the steered wheel's axle instead of their own."""

from __future__ import annotations

from softsoil.plant.kernel import inner


@inner
def shaft_reaction(machine, torque, axle, out):
    """Take a half shaft's torque (N m) off the moment `out` on the chassis: about y, and the share joint_reaction of it about the
    wheel's axle (3,) instead."""
    for i in range(3):
        across = 1.0 if i == 1 else 0.0
        out[i] -= torque * (across + machine.joint_reaction * (axle[i] - across))
