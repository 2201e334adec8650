"""What the driveline and the steering do to the chassis: Newton's third law, and the places where the reference breaks it."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.judges.drive_windows import with_the_others_steering
from softsoil.plant.kinematics import _double_wishbone, _pose
from softsoil.plant.machine import REFERENCE, PlantVehicle, load_plant_vehicle
from softsoil.plant.masses import GRAVITY
from softsoil.plant.reference.idler import idler_moment
from softsoil.plant.start import Start
from softsoil.plant.state import SPIN
from softsoil.plant.suspension import AXLE_X, COUNT, ROD, carrier
from softsoil.plant.world import Plant
from softsoil.symbolic.soil import CLAY

STEER, THROTTLE = 0.25, 0.35
THETA = 0.3


def reactions(joint: float = 1.0, idler: float = 0.0) -> PlantVehicle:
    """The reference vehicle by Newton's third law, but for shares of its own reactions."""
    vehicle = load_plant_vehicle()
    machine = vehicle.machine._replace(torque_reaction=0.0, joint_reaction=joint, idler_error=idler)
    return replace(vehicle, machine=machine)


def turn(vehicle: PlantVehicle, steer: float = STEER) -> tuple[NDArray[np.float64], float]:
    """Mean soil moment about the centre of gravity in the yaw frame (3,), its gyroscopic part taken out, and the roll moment
    of the front half shafts' torques about their steered wheels' axles, over the last two seconds of a turn."""
    plant = Plant(CLAY, vehicle=vehicle, start=Start(u=4.0))
    moments, shafts = [], []
    for k in range(700):
        seen = plant.step((steer, THROTTLE, 0.0))
        if k < 533:
            continue
        c, s = np.cos(seen["psi"]), np.sin(seen["psi"])
        frame = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        centre = np.array([seen["true_x_cg"], seen["true_y_cg"], seen["true_z_cg"]])
        info = plant.info
        moment = sum(np.cross(row[6:9] - centre, row[0:3]) + row[3:6] for row in info)
        gyro = vehicle.machine.gyro_inertia * plant.state[SPIN : SPIN + 4].sum() * seen["omega_z"]
        moments.append(frame @ moment + [gyro, 0.0, 0.0])
        shafts.append(sum(row[16] * (frame @ row[12:15])[0] for row in info[:2]))
    return np.mean(moments, axis=0), float(np.mean(shafts))


def test_nothing_but_the_soil_turns_a_vehicle_whose_reactions_are_all_carried() -> None:
    moment, _ = turn(reactions())
    weight = load_plant_vehicle().machine.total_mass * GRAVITY
    # A millimetre of the weight's lever: the turn is not quite steady.
    assert abs(moment[0]) < 1e-3 * weight


def test_the_references_half_shafts_take_a_roll_moment_out_of_the_turn() -> None:
    carried, _ = turn(reactions())
    moment, shafts = turn(reactions(joint=0.0))
    assert shafts < -50.0
    assert moment[0] - carried[0] == pytest.approx(-shafts, rel=0.2)


def test_the_references_idler_turns_the_vehicle_to_the_left_in_the_mean_of_turns_both_ways() -> None:
    """What the soil is short of, the error of the idler's moment holds up: tie rod's force times steering, even in both."""
    even = [sum(turn(reactions(idler=share), steer)[0][2] for steer in (STEER, -STEER)) for share in (0.0, 1.0)]
    assert abs(even[0]) < 10.0
    assert -400.0 < even[1] < -60.0


def test_and_jerks_it_to_the_right_at_steps_both_ways() -> None:
    """Prescribed angles move the wheels within a step: the rods' impulses do not cancel."""
    for steer in (STEER, -STEER):
        jumps = []
        for vehicle in (with_the_others_steering(), load_plant_vehicle()):
            plant = Plant(CLAY, vehicle=vehicle, start=Start(u=4.0))
            for _ in range(80):
                before = plant.step((steer, THROTTLE, 0.0))["omega_z"]
            jumps.append(plant.step((0.0, THROTTLE, 0.0))["omega_z"] - before)
        assert -0.4 < jumps[0] - jumps[1] < -0.05


def test_a_rod_that_slopes_lifts_the_link_as_a_lifted_link_turns_the_wheel() -> None:
    """Virtual work: force up per moment about the arm is turning, of the arm as the wheel has it, per height of the inner end."""
    axle = tomllib.loads(REFERENCE.read_text(encoding="utf-8"))["front"]
    machine = load_plant_vehicle().machine
    points, equations = _double_wishbone(axle)

    def steered(theta: float, lift: float, side: int) -> float:
        shift = machine.link_arm * np.array([np.cos(theta) - 1.0, -side * np.sin(theta), 0.0]) + [0.0, 0.0, lift]
        return float(_pose(points, partial(equations, q=0.0, shift=shift), np.array([0, 0, 0, 0, 0, side * theta]))[5])

    for w, side in enumerate((1, -1)):
        value, by_q, by_angle = np.empty(COUNT), np.empty(COUNT), np.empty(COUNT)
        carrier(machine.paths[w], 0.0, THETA, value, by_q, by_angle)
        per_height = (steered(THETA, 1e-4, side) - steered(THETA, -1e-4, side)) / 2e-4
        per_angle = (steered(THETA + 1e-4, 0.0, side) - steered(THETA - 1e-4, 0.0, side)) / 2e-4
        assert value[ROD] == pytest.approx(per_height / per_angle, rel=0.01)
        assert abs(value[AXLE_X]) > 0.2


def test_the_idlers_moment_is_the_references_less_the_right_one() -> None:
    """The link in balance under both rods, its universal joint (no moment but about its own axis) and the idler."""
    machine = load_plant_vehicle().machine._replace(idler_error=1.0)
    c, s = np.cos(THETA), -np.sin(THETA)
    idler = machine.link_arm * np.array([c, s, 0.0])
    along, up = np.array([c, s, 0.0]), np.array([0.0, 0.0, 1.0])
    left, right = np.array([90.0, 800.0, -300.0]), np.array([-70.0, 500.0, 200.0])
    # From the universal joint, on the left: idler, rods and centre of the link.
    ends = {
        "idler": [0.0, -0.2, 0.0],
        "left": [0.0, 0.013, 0.0],
        "right": [0.0, -0.213, 0.0],
        "centre": [0.0, -0.1, 0.0],
    }
    at = {name: np.array(end) for name, end in ends.items()}
    weight = np.array([0.0, 0.0, -6.0 * GRAVITY])
    forces = {"left": left, "right": right, "centre": weight}
    load = np.concatenate([sum(forces.values()), sum(np.cross(at[name], force) for name, force in forces.items())])
    # Unknown: the joint's force (3), its moment about the link, the idler's pull and lift.
    columns = [np.concatenate([e, np.zeros(3)]) for e in np.eye(3)]
    columns += [np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])]
    columns += [np.concatenate([f, np.cross(at["idler"], f)]) for f in (along, up)]
    lift = np.linalg.solve(np.stack(columns, axis=1), -load)[5]
    pivot = machine.idler_pivot
    references = lift * (np.cross(up, pivot) - np.cross(along, pivot))
    right_one = np.cross(pivot + idler, -lift * up)
    found = np.zeros(3)
    idler_moment.py_func(machine, THETA, GRAVITY, left[2], right[2], found)
    assert found == pytest.approx(references - right_one, rel=1e-9)


def test_a_steering_without_an_idler_needs_none(tmp_path: Path) -> None:
    """But one that is to break the law must say where it is."""
    kept = [line for line in REFERENCE.read_text(encoding="utf-8").splitlines() if not line.startswith(("idler", "link_mass"))]
    bare, wrong = tmp_path / "bare.toml", tmp_path / "wrong.toml"
    bare.write_text("\n".join(kept), encoding="utf-8")
    at = kept.index("[steering]") + 1
    wrong.write_text("\n".join([*kept[:at], "idler_error = 1.0", *kept[at:]]), encoding="utf-8")
    assert load_plant_vehicle(bare).machine.idler_error == 0.0
    with pytest.raises(ValueError, match="idler_pivot"):
        load_plant_vehicle(wrong)
