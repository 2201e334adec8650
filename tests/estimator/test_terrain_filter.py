"""One policy: the terrain filter in Python and the generated C library give the same n on logs where everything goes wrong, and
on a drive where n jumps and seems to jump."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from c_folders import SCALAR, declared, library, library_of
from drives import CLAY_LOG, LOAM_LOG, MULTI_LOG, reference_vehicle
from softsoil.codegen.c_library.binding import CFilter
from softsoil.codegen.c_library.build import FLAGS
from softsoil.codegen.sampling import STEP
from softsoil.control.c_estimator import c_parts
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.terrain import estimate_terrain
from softsoil.estimator.terrain_filter import TerrainFilter, first_state
from softsoil.estimator.tuning import Tuning
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine
from softsoil.plant.simulate import simulate
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start
from softsoil.recording.clock import on_even_clock
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.recording.states import known_states, measured_states, sensor_std
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.inputs import measured_inputs

SAME = 1e-9
STANDING, GATED, JUMPED, SOIL_CHANGED, DRIFTING, SOIL_KEPT = BITS = 1, 2, 4, 8, 16, 32


def spoiled(path: Path, model, seed: int):
    """Times, inputs and measurements of a log with noise, dropouts, outliers, bursts, jumps and a stop."""
    log = on_even_clock(add_noise(read_drive(path), "good", seed))
    log = log.between(log.t[0] + 2.0, np.inf)
    rng = np.random.default_rng(seed)
    u, y = measured_inputs(log, model.external)[0], measured_states(log)
    x0, std = known_states(log)[0], sensor_std(log, np.array(Tuning().sensor_floor))
    y[rng.random(y.shape) < 0.05] = np.nan
    wild = rng.random(y.shape) < 0.01
    y[wild] += 20.0 * rng.choice([-1.0, 1.0], y.shape)[wild]
    y[rng.random(y.shape) < 2e-3] = 1e12
    u[rng.random(u.shape) < 0.01] = np.nan
    u[rng.random(u.shape) < 2e-3] = 1e8
    u[500:560] = np.nan  # inputs that are missing for longer than they are held
    y[400:480] = np.nan  # a second without any measurement
    y[600:640, 5] += 1.0  # a gyro that leaps, for longer than the patience lasts
    y[700:760, 0] += 30.0  # a position that leaps
    y[900:1000, 3] = 0.0 + 0.05 * rng.normal(size=100)  # speed of a vehicle that has stopped, for one that has not
    y[1100:1120, 3] = -3.0
    return log.dt, u, y, x0, std


def both(name: str, path: Path, seed: int, flags=SCALAR):
    """`together` on a spoiled log with a declared model of `c_folders`."""
    model = c_parts(declared(name)).model
    return together(model, library(name, flags), *spoiled(path, model, seed))[:2]


def together(model, lib, dt, u, y, motion, std, n0=0.62):
    """n by Python and by C (K, A) after each update, what Python's statuses said and the flags of C, and the filter of each."""
    tuning = Tuning()
    x0, std0 = first_state(model, motion, n0), tuning.std0(model.x, std)
    python = TerrainFilter(model, dt, std, tuning)
    python.start(x0, std0)
    options = lib.defaults()
    options.r_std[:] = std
    c = CFilter(lib, x0, std0, options)
    soil = [model.x.index(n) for n in lib.formulation["soil_states"]]
    found, said = [], []
    for k in range(len(u) - 1):
        python.predict(u[k])
        c.predict(u[k], dt)
        if k % 2:
            python.update(y[k + 1])
            c.update(y[k + 1], c.state.t)
            s = python.status
            assert abs(s.drift - c.state.drift) < 1e-6
            flags = (s.standing, bool(s.gated), bool(s.jumped), s.soil_changed, bool(s.drifting), s.soil_kept)
            said.append((c.state.flags, sum(bit for bit, on in zip(BITS, flags, strict=True) if on)))
            found.append((python.n, c.x[soil].copy(), python.n_std, c.std[soil].copy()))
    return np.array(found), np.array(said), python, c


EXAMPLES = [CLAY_LOG, MULTI_LOG, LOAM_LOG]


def agree(found, said) -> int:
    """Assert that Python and C say the same; returns every flag that was met."""
    assert np.abs(found[:, 0] - found[:, 1]).max() < SAME
    assert np.abs(found[:, 2] - found[:, 3]).max() < SAME
    np.testing.assert_array_equal(said[:, 0], said[:, 1])
    return int(np.bitwise_or.reduce(said[:, 0]))


@pytest.mark.compiler
@pytest.mark.parametrize("name", ["plain", "tracks"])
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name.split(".csv")[0])
def test_python_and_c_agree_on_n(name, path):
    met = agree(*both(name, path, 1))
    assert met & STANDING and met & GATED and met & JUMPED


@pytest.mark.compiler
@pytest.mark.shared
@pytest.mark.study
def test_python_and_c_agree_on_the_shared_drives(shared_data):
    """Every reference drive, in vectors; where the soil changes, both say it."""
    logs = sorted((shared_data / "chrono_vehicle").glob("*.csv.gz"))
    met = {path.name: agree(*both("tracks", path, 1, FLAGS)) for path in logs}
    assert all(m & STANDING and m & GATED and m & JUMPED for m in met.values())
    assert all(met[name] & SOIL_CHANGED for name in met if name.startswith("change_"))


@pytest.mark.compiler
def test_a_false_jump_is_revoked_and_a_true_one_stands():
    """A gyro that reads 20 % too much for two seconds is no soil, a border where n goes from 0.5 to 0.75 is one."""
    ground = SoilField.change_at(CLAY.with_(n=0.5), CLAY.with_(n=0.75), 140.0)
    clean = simulate(Manoeuvre("both", MultiSine(seed=3)), ground, 38.0, seed=3, start=Start(u=5.0))
    border = float(clean.t[np.argmax(clean["x"] > 140.0)])
    log = on_even_clock(add_noise(clean, "good", 0))
    own = Declaration(load_vehicle(PLANT_VEHICLE), CLAY)
    model = c_parts(own).model
    y = measured_states(log)
    y[(log.t > 14.0) & (log.t < 16.0), 5] *= 1.2
    inputs, motion = measured_inputs(log, model.external)[0], known_states(log)[0]
    std = sensor_std(log, np.array(Tuning().sensor_floor))
    found, said, python, c = together(model, library_of(own), log.dt, inputs, y, motion, std)
    assert agree(found, said) & SOIL_KEPT
    (false,), (true,) = python.revoked, python.changes
    assert 14.0 < false < 16.0 and border < true < border + 3.0 and python.on_trial is None
    assert c.counts["SOIL_CHANGED"] == 2 and c.counts["SOIL_KEPT"] == 1
    at = 2 * log.dt * np.arange(1, len(found) + 1)
    n, n_std = found[:, 0, 0], found[:, 2, 0]
    assert n_std[(at > false) & (at < false + 0.5)].max() > 0.15  # on trial
    calm = (at > false + 5.0) & (at < border)  # what was known before counts again
    assert np.abs(n[calm] - n[at < false - log.dt][-1]).max() < 0.04 and n_std[calm].max() < 0.04  # 5 % of it the vehicle's
    assert n[-1] == pytest.approx(0.75, rel=0.1)


@pytest.mark.compiler
def test_a_vehicle_that_stood_at_first_has_no_change_of_soil():
    """The first seconds of driving are convergence from the guess, however long it stood before them. Its rear wheels are larger
    and wider than the front ones, in both languages."""
    own = Declaration(load_vehicle(PLANT_VEHICLE).with_(radius_rear=0.36, width_rear=0.26), CLAY)
    model = c_parts(own).model
    log = add_noise(synthetic_drive(model, own.vehicle.radius, seconds=12.0, speed=5.0), "good", 1)
    inputs, moves, motion = measured_inputs(log, model.external)[0], measured_states(log), known_states(log)[0]
    std = sensor_std(log, np.array(Tuning().sensor_floor))
    before = round(14.0 / log.dt)
    rest = np.array([*motion[:3], 0.0, 0.0, 0.0])
    y = np.vstack([np.tile(rest, (before, 1)), moves])
    u = np.vstack([np.zeros((before, inputs.shape[1])), inputs])
    found, said, python, c = together(model, library_of(own), log.dt, u, y, rest, std, n0=1.1)
    assert not python.changes and not python.revoked and python.drift.alarm is None and "SOIL_CHANGED" not in c.counts
    assert agree(found, said) & STANDING
    assert found[-1, 0, 0] == pytest.approx(0.5, abs=0.05)


def moving() -> TerrainFilter:
    model = c_parts(declared("plain")).model
    own = TerrainFilter(model, STEP, Tuning().sensor_floor)
    own.start(model.x.pack(u=6.0, n_f=0.5, n_r=0.5), Tuning().std0(model.x, Tuning().sensor_floor))
    return own


def test_a_place_is_believed_after_its_patience_and_a_velocity_sooner():
    own = moving()
    u = own.model.external.nominal
    for _ in range(round(Tuning().run_in / STEP) + 20):  # in the first seconds velocities follow their sensors anyway
        own.predict(u)
        own.update(own.ukf.x[:6])
    y = own.ukf.x[:6].copy()
    y[0], y[5] = 40.0, 1.0
    when: dict[str, int] = {}
    for k in range(Tuning().patience + 1):
        own.predict(u)
        own.update(y)
        for name in own.status.jumped:
            when.setdefault(name, k + 1)
    assert when["x"] == Tuning().patience and when["omega_z"] == Tuning().patience_rates
    assert own.ukf["x"] == pytest.approx(40.0, abs=0.5)


def test_a_kick_of_the_steering_and_a_start_say_little_of_n():
    """While nothing of the model's moves the vehicle, velocities follow their sensors and n keeps its uncertainty."""
    spread = {}
    for name, run_in, rate in (("driving", 0.0, 0.0), ("starting", 1.0, 0.0), ("kicked", 0.0, 2.0)):
        model = c_parts(declared("plain")).model
        own = TerrainFilter(model, STEP, Tuning().sensor_floor, replace(Tuning(), run_in=run_in))
        own.start(model.x.pack(u=6.0, v=0.05, omega_z=0.4, n_f=0.5, n_r=0.5), Tuning().std0(model.x, Tuning().sensor_floor))
        u = model.external.pack(steer=0.3, steer_rate=rate, omega_fl=15.0, omega_fr=15.0, omega_rl=15.0, omega_rr=15.0)
        for _ in range(40):
            own.predict(u)
            own.update(own.ukf.x[:6])
        spread[name] = float(own.n_std[0])
    assert spread["starting"] > 0.29 and spread["kicked"] > 0.29
    assert spread["driving"] < 0.95 * min(spread["starting"], spread["kicked"])


def test_an_uncertain_n_keeps_mean_and_variance_at_a_bound():
    """Sigma points beyond a bound of n neither move nor narrow it."""
    own = moving()
    before = own.n.copy(), np.sqrt(own.ukf.variance[-2:])
    own.predict(own.model.external.nominal)
    assert own.n == pytest.approx(before[0], abs=1e-9)
    assert np.sqrt(own.ukf.variance[-2:]) == pytest.approx(before[1], rel=1e-3)


def test_outliers_to_both_sides_are_no_jump():
    own = moving()
    u = own.model.external.nominal
    for k in range(60):
        own.predict(u)
        y = own.ukf.x[:6].copy()
        y[0] += 30.0 * (-1) ** k
        own.update(y)
        assert own.status.gated == ("x",) and not own.status.jumped


def test_a_long_prediction_is_divided():
    model = c_parts(declared("plain")).model
    slow, fast = TerrainFilter(model, 4 * STEP, Tuning().sensor_floor), TerrainFilter(model, 4 * STEP / 3, Tuning().sensor_floor)
    x0 = model.x.pack(u=6.0, v=0.1, omega_z=0.2)
    for own in (slow, fast):
        own.start(x0, Tuning().std0(model.x, Tuning().sensor_floor))
    slow.predict(model.external.nominal)
    for _ in range(3):
        fast.predict(model.external.nominal)
    np.testing.assert_allclose(slow.ukf.x, fast.ukf.x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(slow.ukf.P, fast.ukf.P, rtol=0, atol=1e-12)


@pytest.mark.study
def test_n_is_learnt_through_forces_that_build_up():
    """Forces that all sigma points share, as a history's, hid n: its standard deviation stayed at a quarter."""
    vehicle = reference_vehicle()
    model = bicycle(vehicle, CLAY, effects={**vehicle.effects, "relaxation": {"relaxation_length": 0.3}})
    drive = add_noise(synthetic_drive(model, vehicle.radius, seconds=14.0), "good", 1)
    found = estimate_terrain(drive, model, 0.7, tied=True, start=2.0)
    assert found.n_front[-1] == pytest.approx(0.5, rel=0.06) and found.n_front_std[-1] < 0.05
