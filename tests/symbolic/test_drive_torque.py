"""The propeller shaft's moment on the body: the bicycle, which knows no engine, against the plant, which has one."""

from dataclasses import replace

import numpy as np
import pytest

from axles import axle_of
from softsoil.codegen.predictor import Predictor, substeps_for
from softsoil.mpc_demo.blind_test import PLANT_VEHICLE
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Manoeuvre, Sine, SineThrottle
from softsoil.plant.simulate import recording_of
from softsoil.plant.start import Start
from softsoil.plant.state import PITMAN, TRAVEL, rotation
from softsoil.plant.world import Plant
from softsoil.recording.states import measured_states
from softsoil.symbolic.body_roll import roll_angle
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SAND, SANDY_LOAM
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

SETTLED = 250
"""Rows left out, the plant's start."""
SOILS = [CLAY.with_(n=0.6), SANDY_LOAM.with_(n=0.8), SAND.with_(n=1.0)]


def driven(soil, torque_reaction: float = 1.0):
    """(recording, half shafts' torques together (N,), mean lean and steering of the rear wheels (N, 2)) of a drive of the
    plant that hardly turns, with a waving throttle."""
    vehicle = load_plant_vehicle()
    vehicle = replace(vehicle, machine=vehicle.machine._replace(torque_reaction=torque_reaction))
    plant = Plant(soil, vehicle=vehicle, start=Start(u=5.0))
    driver = Manoeuvre("straight", Sine(amplitude=0.02), SineThrottle(0.4, 0.15, 4.0))
    rows, torques, axles, within, turn = [], [], [], np.arange(6) * plant.dt, np.empty((3, 3))
    seen = plant.sample()
    for _ in range(1000):
        plant.advance(np.ascontiguousarray(driver(plant.time + within, seen)))
        seen = plant.sample()
        rotation(plant.state, turn)
        rear = np.mean([axle_of(wheel, plant.state[TRAVEL + wheel], plant.state[PITMAN]) for wheel in (2, 3)], axis=0)
        rows.append(seen.row.copy())
        torques.append(plant.info[:, 16].sum())
        axles.append([turn[2] @ rear, np.arctan2(-rear[0], rear[1])])
    return recording_of(np.array(rows), "straight"), np.array(torques), np.array(axles)


def on_body(recording, soil, shaft_share: float | None = None):
    """(N, 2) driving torque (N m) and roll of the body (rad) by the declared bicycle along a recording."""
    model = bicycle(load_vehicle(PLANT_VEHICLE), soil)
    model = model.correct("forces", lambda q: {"rolled": roll_angle(q)[0]})
    inputs, _ = measured_inputs(recording, model.external)
    states, p = measured_states(recording), model.p.nominal
    if shaft_share is not None:
        p[model.p.index("shaft_share")] = shaft_share
    predictor = Predictor(model, recording.dt, substeps=substeps_for(recording.dt))
    _, full = predictor.track_memory(states, inputs, p)
    return model.probe("drive_torque", "rolled").map(len(states))(states.T, full.T, p).full().T


@pytest.mark.parametrize("soil", SOILS, ids=lambda soil: soil.name)
def test_the_torque_is_what_the_plants_shafts_carry(soil):
    """Mean and swing over a drive; nothing of the plant but its sensor channels and soil goes in."""
    recording, torque, _ = driven(soil)
    said, true = on_body(recording, soil)[SETTLED:, 0], torque[SETTLED:]
    assert true.mean() > 400.0
    assert said.mean() == pytest.approx(true.mean(), rel=0.2)
    assert np.corrcoef(said, true)[0, 1] > 0.9


def test_it_rolls_the_rear_wheels_as_it_does_the_plants():
    """Lean and steering of the rear wheels, with the shaft's reaction less without it: straight on, so it is all the moment's."""
    declared, soil = load_vehicle(PLANT_VEHICLE).effects["wheel_lean"], SAND.with_(n=1.0)
    recording, _, axles = driven(soil)
    moved = (axles - driven(soil, torque_reaction=0.0)[2])[SETTLED:].mean(axis=0)
    rolled = on_body(recording, soil)[SETTLED:, 1].mean()
    assert moved[0] < -0.002
    assert declared["lean_rear"] * rolled == pytest.approx(moved[0], rel=0.25)
    assert declared["steer_rear"] * rolled == pytest.approx(moved[1], rel=0.5)


def test_the_torque_forgives_wheel_speeds_that_read_wrong():
    """Half a per cent on every wheel speed would be 50 N m of torque by the slip alone; what accelerates the vehicle is seen."""
    soil = CLAY.with_(n=0.6)
    recording, _, _ = driven(soil)
    off = replace(
        recording,
        channels={
            key: values * 1.005 if key in ("omega_fl", "omega_fr", "omega_rl", "omega_rr") else values
            for key, values in recording.channels.items()
        },
    )
    right, wrong = (on_body(log, soil)[SETTLED:, 0].mean() for log in (recording, off))
    assert abs(wrong - right) < 10.0
