"""What the driveline and the steering do to the chassis: Newton's third law, and the places where the reference breaks it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from plant.dynamics import GRAVITY
from plant.machine import load_plant_vehicle
from plant.start import Start
from plant.state import SPIN
from plant.world import Plant
from symbolic.soil import CLAY

STEER, THROTTLE = 0.25, 0.35


def turn(
    torque_reaction: float, joint_reaction: float, steering_reaction: float = 1.0
) -> tuple[NDArray[np.float64], float, float]:
    """Mean soil moment about the centre of gravity in the yaw frame (3,), its gyroscopic part taken out, the roll moment of
    the front half shafts' torques about their steered wheels' axles, and the soil's moment about the front wheels'
    verticals, over the last two seconds of a left turn."""
    vehicle = load_plant_vehicle()
    machine = vehicle.machine._replace(
        torque_reaction=torque_reaction, joint_reaction=joint_reaction, steering_reaction=steering_reaction
    )
    plant = Plant(CLAY, vehicle=replace(vehicle, machine=machine), start=Start(u=4.0))
    moments, shafts, aligning = [], [], []
    for k in range(700):
        seen = plant.step((STEER, THROTTLE, 0.0))
        if k < 533:
            continue
        c, s = np.cos(seen["psi"]), np.sin(seen["psi"])
        frame = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        centre = np.array([seen["true_x_cg"], seen["true_y_cg"], seen["true_z_cg"]])
        info = plant.info
        moment = sum(np.cross(row[6:9] - centre, row[0:3]) + row[3:6] for row in info)
        gyro = machine.gyro_inertia * plant.state[SPIN : SPIN + 4].sum() * seen["omega_z"]
        moments.append(frame @ moment + [gyro, 0.0, 0.0])
        shafts.append(sum(row[16] * (frame @ row[12:15])[0] for row in info[:2]))
        aligning.append(info[:2, 5].sum())
    return np.mean(moments, axis=0), float(np.mean(shafts)), float(np.mean(aligning))


def test_nothing_but_the_soil_turns_a_vehicle_whose_reactions_are_all_carried() -> None:
    moment, *_ = turn(0.0, 1.0)
    weight = load_plant_vehicle().machine.total_mass * GRAVITY
    # A millimetre of the weight's lever: the turn is not quite steady.
    assert abs(moment[0]) < 1e-3 * weight


def test_the_references_half_shafts_take_a_roll_moment_out_of_the_turn() -> None:
    carried, *_ = turn(0.0, 1.0)
    moment, shafts, _ = turn(0.0, 0.0)
    assert shafts < -50.0
    assert moment[0] - carried[0] == pytest.approx(-shafts, rel=0.2)


def test_what_the_references_steering_keeps_is_the_moment_about_its_wheels_verticals() -> None:
    carried, _, aligning = turn(0.0, 1.0)
    moment, _, kept = turn(0.0, 1.0, 0.0)
    assert min(aligning, kept) > 20.0
    assert moment[2] - carried[2] == pytest.approx(kept, rel=0.2)
