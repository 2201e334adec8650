"""The vehicle of 3 t: its declared bicycle against the plant's own bodies and motion, nothing fitted."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from softsoil.codegen.predictor import Predictor
from softsoil.files.package_data import VEHICLES, plant_file
from softsoil.mpc_demo.scenarios import scenarios, size_of
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Speed
from softsoil.plant.simulate import recording_of
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.states import measured_states
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

SETTLED, ROWS = 250, 1000
SOIL = CLAY.with_(n=0.6)


@pytest.fixture(scope="module")
def machine():
    return load_plant_vehicle(plant_file("heavy"))


@pytest.fixture(scope="module")
def drive(machine):
    plant, rows = Plant(SOIL, vehicle=machine, start=Start(u=5.5)), []
    driver, seen, within = Manoeuvre("turns", MultiSine(seed=7), Speed(5.5, 1.0, 9.0)), plant.sample(), np.arange(6) * plant.dt
    for _ in range(ROWS):
        plant.advance(np.ascontiguousarray(driver(plant.time + within, seen)))
        seen = plant.sample()
        rows.append(seen.row.copy())
    return recording_of(np.array(rows), "turns")


def test_mass_and_place_are_those_of_the_bodies(machine):
    vehicle = load_vehicle("heavy")
    assert vehicle.mass == pytest.approx(machine.machine.total_mass, rel=1e-4)
    assert vehicle.wheelbase == pytest.approx(machine.l_f + machine.l_r, abs=0.01)
    assert vehicle.radius == pytest.approx(machine.machine.radius[0]) and vehicle.max_steer <= machine.max_steer


@pytest.mark.study
def test_the_axles_push_and_the_load_moves_as_on_the_plant(drive):
    """Lateral force of each axle at the plant's own motion within 4 %, and what is left of it; the load's move within 12 %."""
    model = bicycle(load_vehicle("heavy"), SOIL)
    names = ("load_fl", "load_fr", "load_rl", "load_rr")
    model = model.correct("tracks", lambda q: {f"load_{w.name}": w.load for w in q["wheels"]})
    inputs, _ = measured_inputs(drive, model.external)
    states, p = measured_states(drive), model.p.nominal
    _, full = Predictor(model, drive.dt).track_memory(states, inputs, p)
    rows = model.probe("force_f", "force_r", *names).map(len(states))(states.T, full.T, p).full()[:, SETTLED:]
    loads = dict(zip(names, rows[2:], strict=True))
    for axle, force, left in zip("fr", rows[:2], (0.06, 0.2), strict=True):
        declared, true = (
            savgol_filter(values, 9, 2)
            for values in (force, (drive.truth[f"true_fy_{axle}l"] + drive.truth[f"true_fy_{axle}r"])[SETTLED:])
        )
        assert declared @ true / (true @ true) == pytest.approx(1.0, abs=0.04)
        assert np.std(declared - true) < left * np.std(true)
        moved = loads[f"load_{axle}r"] - loads[f"load_{axle}l"]
        true = (drive.truth[f"true_fz_{axle}r"] - drive.truth[f"true_fz_{axle}l"])[SETTLED:]
        assert np.polyfit(moved, true, 1)[0] == pytest.approx(1.0, abs=0.12)


def test_a_declared_vehicle_names_its_plant(tmp_path):
    assert plant_file("heavy") == VEHICLES / "heavy_plant.toml"
    assert plant_file("mine", tmp_path / "mine.toml") == VEHICLES / "reference_plant.toml"
    (tmp_path / "mine_plant.toml").write_text("", encoding="utf-8")
    assert plant_file("mine", tmp_path / "mine.toml") == tmp_path / "mine_plant.toml"


def test_courses_are_of_the_vehicles_size():
    assert size_of(load_vehicle("reference")) == 1.0 and size_of(load_vehicle("heavy")) == 1.3
    small, large = scenarios()["obstacles_clay"], scenarios(1.3)["obstacles_clay"]
    np.testing.assert_allclose(large.path.points, 1.3 * small.path.points)
    np.testing.assert_allclose(large.obstacles[:, :3], 1.3 * small.obstacles[:, :3])
    assert large.speed**2 == pytest.approx(1.3 * small.speed**2) and large.warm_up == pytest.approx(1.3 * small.warm_up)
    before, after = (scenarios(1.3)["two_soils"].n_true(1.3 * 74.0 + off) for off in (-0.1, 0.1))
    assert (before, after) == (0.5, 0.75)
    with pytest.raises(ValueError, match="size > 0"):
        scenarios(0.0)
