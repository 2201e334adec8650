"""A vehicle whose file states the joint error of two of its numbers, and drives of it, with a load and without."""

import numpy as np

from drives import reference_vehicle
from softsoil.declaration.driveline import with_driveline
from softsoil.files.joint_error import joint_error_of
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.noise import add_noise
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.windows.free_starts import SUBSTEPS

N = 0.6
NUMBERS, STD = ("yaw_inertia", "toe_rear"), np.array([30.0, 0.004])
ERROR = joint_error_of(NUMBERS, np.outer(STD, STD) * [[1.0, 0.3], [0.3, 1.0]])
LOAD = {"payload": {"payload_mass": 400.0, "payload_x": 2.3}}


def vehicle(joint=ERROR):
    """The reference vehicle without effects, its numbers identified."""
    return reference_vehicle().with_(effects={}, joint_error=joint)


def drive(effects, noise, seconds=26.0, wheels=True):
    """A noisy drive of that vehicle's bicycle with `effects` on clay, in the steps in which numbers are identified.

    wheels: whether the log has their speeds, or they turn as the balance of forces asks.
    """
    steer = MultiSine(0.35, seed=4)(0.012 * np.arange(round(seconds / 0.012) + 1))
    model = bicycle(vehicle(), CLAY.with_(n=N), "turn_slip", effects)
    model = model if wheels else with_driveline(model, ("fl", "fr", "rl", "rr"))
    run = {"seconds": seconds, "speed": 5.5, "steer": steer, "substeps": SUBSTEPS}
    log = add_noise(synthetic_drive(model, vehicle().radius, **run), noise, 1)
    return log if wheels else log.with_channels(**{name: np.full(len(log), np.nan) for name in WHEEL_CHANNELS})
