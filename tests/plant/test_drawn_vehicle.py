"""Vehicles of the plant drawn by seed: bodies that add up, either suspension at either axle, driven as their owners would."""

import numpy as np
import pytest

from benchmarks.judges.plant_vehicles import case_of
from softsoil.plant.drawn_vehicle import DRAW, Draw, draw_vehicle
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Manoeuvre, Sine, Speed
from softsoil.plant.simulate import simulate
from softsoil.plant.start import Start
from softsoil.plant.state import TRAVEL, rotation
from softsoil.plant.suspension import STEER_TURN
from softsoil.plant.world import Plant
from softsoil.symbolic.soil import CLAY

SEEDS = range(5)


@pytest.fixture(scope="module")
def vehicles():
    return [draw_vehicle(seed) for seed in SEEDS]


def test_vehicles_stay_in_their_ranges_and_come_again_from_their_seed(vehicles):
    for drawn in vehicles:
        m = drawn.measured
        assert DRAW.mass[0] <= m["mass"] <= DRAW.mass[1] and DRAW.radius[0] <= m["radius"] <= DRAW.radius[1]
        assert DRAW.wheelbase[0] - 1e-9 <= m["l_f"] + m["l_r"] <= DRAW.wheelbase[1] + 1e-9
        inertia = drawn.vehicle.yaw_inertia / (m["mass"] * m["l_f"] * m["l_r"])
        assert DRAW.gyration[0] - 0.01 < inertia < DRAW.gyration[1] + 0.01
    again = draw_vehicle(SEEDS[3])
    assert again.measured == vehicles[3].measured
    np.testing.assert_array_equal(again.vehicle.machine.paths, vehicles[3].vehicle.machine.paths)
    assert {layout for drawn in vehicles for layout in drawn.layouts} == {"wishbone", "trailing"}


def test_rear_wheels_are_not_steered_and_front_ones_are(vehicles):
    for drawn in vehicles:
        turning = drawn.vehicle.machine.paths[:, STEER_TURN + 2, 0, 0]
        assert np.all(np.abs(turning[:2]) > 0.3) and np.all(turning[2:] == 0.0)


def test_the_references_bodies_have_the_yaw_inertia_that_its_bicycle_declares():
    assert load_plant_vehicle().yaw_inertia == pytest.approx(1795.0, rel=0.002)


def test_a_toe_turns_both_wheels_of_an_axle_inwards_or_outwards():
    drawn = draw_vehicle(0, Draw(toe=(0.01, 0.01), toe_rear=(0.0, 0.0)))
    a_x = drawn.vehicle.machine.paths[:, 3, 0, 0]
    np.testing.assert_allclose(np.arcsin(-a_x), [0.01, -0.01, 0.0, 0.0], atol=2e-4)


def test_ranges_in_which_no_suspension_reaches_its_travel_are_refused():
    with pytest.raises(ValueError, match="lighter than the vehicle"):
        draw_vehicle(0, Draw(unsprung=(60.0, 60.0)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 4])
def test_a_drawn_vehicle_drives_on_its_wheels_at_the_speed_asked_for(vehicles, seed):
    drawn = vehicles[seed]
    plant = Plant(CLAY.with_(n=0.55), vehicle=drawn.vehicle, start=Start(u=5.0), spacing=drawn.spacing)
    steer = Sine(0.95 * drawn.vehicle.max_steer, 3.0)
    drive = simulate(Manoeuvre("lock", steer, Speed(5.0)), duration=6.0, plant=plant)
    assert np.abs(drive["u"][200:] - 5.0).max() < 1.0
    loads = np.array([drive.truth[f"true_fz_{wheel}"] for wheel in ("fl", "fr", "rl", "rr")])[:, 200:]
    assert loads.min() > 0.0
    assert loads.sum(axis=0).mean() == pytest.approx(9.81 * drawn.measured["mass"], rel=0.01)
    shares = loads[:2].sum(axis=0).mean() / loads.sum(axis=0).mean()
    assert shares == pytest.approx(drawn.measured["l_r"] / (drawn.measured["l_f"] + drawn.measured["l_r"]), abs=0.03)


def test_an_owner_measures_with_errors_of_the_size_that_the_table_states():
    exact, known = case_of(5).drawn.measured, case_of(5).known
    off = {name: known[name] / value - 1.0 for name, value in exact.items()}
    assert all(value != 0.0 for value in off.values())
    assert abs(off["mass"]) < 0.0101 and abs(off["radius"]) < 0.005 and abs(off["track"]) < 0.0601


def test_rear_wheels_of_another_size_stand_level_and_are_told():
    drawn = draw_vehicle(0, Draw(rear_wheel=(1.2, 1.4)))
    plain, machine = draw_vehicle(0), drawn.vehicle.machine
    np.testing.assert_allclose(machine.radius[2:] / machine.radius[:2], 1.2)
    np.testing.assert_allclose(machine.width[2:] / machine.width[:2], 1.4)
    assert drawn.measured["radius_rear"] == machine.radius[2] and "radius_rear" not in plain.measured
    assert drawn.open_centre and not plain.open_centre
    assert draw_vehicle(0, Draw(front_drive=0.0)).vehicle.machine.front_drive == 0.0
    assert drawn.measured["mass"] == pytest.approx(plain.measured["mass"], rel=1e-9)
    plant = Plant(CLAY, vehicle=drawn.vehicle, start=Start(u=3.0))
    turn = np.empty((3, 3))
    rotation(plant.state, turn)
    assert np.abs(plant.state[TRAVEL : TRAVEL + 4]).max() < 0.05 and abs(turn[2, 0]) < 0.01
