"""The body's roll and the wheels' places: the declared bicycle against the plant's own motion in a turning drive."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import savgol_filter

from softsoil.codegen.predictor import Predictor
from softsoil.mpc_demo.blind_test import PLANT_VEHICLE
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Speed
from softsoil.plant.simulate import recording_of
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.states import measured_states
from softsoil.symbolic.body_roll import roll_angle
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import add_effect
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.soil import CLAY, SANDY_LOAM
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

SETTLED = 250
"""Rows left out, the plant's start."""


@pytest.fixture(scope="module", params=[CLAY.with_(n=0.6), SANDY_LOAM.with_(n=0.7)], ids=lambda soil: soil.name)
def drive(request):
    """(soil, recording, wheel centres (N, 4, 2) in the yaw frame)."""
    soil = request.param
    plant, rows, places = Plant(soil, start=Start(u=5.0)), [], []
    driver, seen, within = (
        Manoeuvre("turns", MultiSine(seed=7), Speed(5.0, 1.0, 9.0)),
        plant.sample(),
        np.arange(6) * plant.dt,
    )
    for _ in range(1600):
        plant.advance(np.ascontiguousarray(driver(plant.time + within, seen)))
        seen = plant.sample()
        rows.append(seen.row.copy())
        cos, sin = np.cos(seen["psi"]), np.sin(seen["psi"])
        places.append(plant.info[:, 6:8] @ np.array([[cos, -sin], [sin, cos]]))
    return soil, recording_of(np.array(rows), "turns"), np.array(places)


def test_effects_of_the_roll_share_its_memory():
    """Once in the model, whichever comes first; another memory of its name is refused."""
    vehicle = load_vehicle(PLANT_VEHICLE)
    known, bare = catalogue(vehicle), bicycle(vehicle.with_(effects={}), CLAY)
    for names in (("load_transfer", "wheel_lean"), ("wheel_lean", "load_transfer")):
        model = add_effect(add_effect(bare, known[names[0]]), known[names[1]])
        assert [memory.name for memory in model.memories].count("body_roll") == 1
        assert model.u.names.count("roll_a") == 1
    alien = replace(known["wheel_lean"].memories[0], cells=Layout.of(Signal("other", "", "another cell")))
    with pytest.raises(ValueError, match="body_roll"):
        add_effect(add_effect(bare, known["load_transfer"]), replace(known["wheel_lean"], memories=(alien,)))


def test_the_body_rolls_as_the_plants_does(drive):
    """Springs and sinking wheels, nothing fitted: the swing within 10 %, and what is left of it."""
    soil, log, _ = drive
    model = bicycle(load_vehicle(PLANT_VEHICLE), soil)
    model = model.correct("forces", lambda q: dict(zip(("rolled", "rate"), roll_angle(q), strict=True)))
    inputs, _ = measured_inputs(log, model.external)
    states, p = measured_states(log), model.p.nominal
    _, full = Predictor(model, log.dt).track_memory(states, inputs, p)
    rolled, rate = model.probe("rolled", "rate").map(len(states))(states.T, full.T, p).full()[:, SETTLED:]
    true = log.truth["true_roll"][SETTLED:]
    assert np.polyfit(true, rolled, 1)[0] == pytest.approx(1.0, abs=0.1)
    assert np.std(rolled - true) < 0.15 * np.std(true)
    assert np.corrcoef(rate, np.gradient(true, log.dt))[0, 1] > 0.95


def test_the_load_moves_between_the_wheels_as_on_the_plant(drive):
    """Per axle, right less left: the swing within 12 %, and what is left of it."""
    soil, log, _ = drive
    model = bicycle(load_vehicle(PLANT_VEHICLE), soil)
    model = model.correct("tracks", lambda q: {f"load_{w.name}": w.load for w in q["wheels"]})
    inputs, _ = measured_inputs(log, model.external)
    states, p = measured_states(log), model.p.nominal
    _, full = Predictor(model, log.dt).track_memory(states, inputs, p)
    names = ("load_fl", "load_fr", "load_rl", "load_rr")
    loads = dict(zip(names, model.probe(*names).map(len(states))(states.T, full.T, p).full()[:, SETTLED:], strict=True))
    for axle in "fr":
        told = loads[f"load_{axle}r"] - loads[f"load_{axle}l"]
        true = (log.truth[f"true_fz_{axle}r"] - log.truth[f"true_fz_{axle}l"])[SETTLED:]
        assert np.polyfit(told, true, 1)[0] == pytest.approx(1.0, abs=0.12)
        assert np.corrcoef(told, true)[0, 1] > 0.97


def test_the_axles_push_as_the_plants_do(drive):
    """Lateral force of each axle at the plant's own motion, nothing fitted: the front one's within 2 %, the rear one's, in ruts,
    within 3 %, and what is left of both."""
    soil, log, _ = drive
    model = bicycle(load_vehicle(PLANT_VEHICLE), soil)
    inputs, _ = measured_inputs(log, model.external)
    states, p = measured_states(log), model.p.nominal
    _, full = Predictor(model, log.dt).track_memory(states, inputs, p)
    found = model.probe("force_f", "force_r").map(len(states))(states.T, full.T, p).full()
    for axle, force, off, left in zip("fr", found, (0.02, 0.03), (0.045, 0.14), strict=True):
        told, true = (
            savgol_filter(a, 9, 2)[SETTLED:]
            for a in (force, log.truth[f"true_fy_{axle}l"] + log.truth[f"true_fy_{axle}r"])
        )
        assert told @ true / (true @ true) == pytest.approx(1.0, abs=off)
        assert np.std(told - true) < left * np.std(true)


def test_the_wheels_stand_where_they_are_declared(drive):
    """Tracks, and how the front one shrinks as the wheels turn about axes that they stand outside of."""
    _, log, places = drive
    vehicle = load_vehicle(PLANT_VEHICLE)
    front, rear = (places[SETTLED:, left, 1] - places[SETTLED:, left + 1, 1] for left in (0, 2))
    turned = 1.0 - np.cos(log["steer"][SETTLED:])
    slope, ahead = np.polyfit(turned, front, 1)
    assert ahead == pytest.approx(vehicle.track, abs=0.003)
    assert rear.mean() == pytest.approx(vehicle.rear_track, abs=0.003)
    assert slope == pytest.approx(-2.0 * vehicle.scrub, rel=0.4)
