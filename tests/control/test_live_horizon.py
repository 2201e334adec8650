"""The verdict while driving: a driver on the plant says when its n may be used, and drives on it from then on."""

import subprocess
import sys
from functools import lru_cache

import numpy as np
import pytest

import identified
from nmpc_problem import small_ocp
from softsoil.control.declared import for_control
from softsoil.control.driver import Driver
from softsoil.control.driver_types import NOT_JUDGED, DriverSettings
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.live_horizon import LiveHorizon
from softsoil.control.nmpc import Nmpc
from softsoil.control.path import Path
from softsoil.control.pedals import Pedals
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.moving_horizon import LEAST_NOISE
from softsoil.files.package_data import VEHICLES
from softsoil.mpc_demo.closed_loop_parts import NoisySensors
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.states import sensor_std
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.windows.shooting import shooting_drive

pytestmark = [pytest.mark.slow, pytest.mark.compiler]
SPEED, N_0 = 6.0, 0.7
SETTINGS = DriverSettings()


def course(weaves: bool) -> Path:
    """Two sines of different length on top of one another, or straight on."""
    x = np.arange(0.0, 150.0, 0.25)
    y = np.clip(x / 8.0, 0.0, 1.0) ** 2 * (1.2 * np.sin(2 * np.pi * x / 22.0) + 0.8 * np.sin(2 * np.pi * x / 13.0 + 1.0))
    return Path(np.stack([x, y if weaves else 0.0 * x], axis=1))


def believed(inertia: float) -> Declaration:
    """The plant's bicycle, its yaw inertia times `inertia`."""
    vehicle = load_vehicle(VEHICLES / "plant.toml")
    return Declaration(vehicle.with_(yaw_inertia=inertia * vehicle.yaw_inertia), CLAY)


@lru_cache(maxsize=2)
def estimator(inertia: float) -> LiveEstimator:
    """The filter of that bicycle."""
    return LiveEstimator(believed(inertia).build(), SETTINGS.sensor_std, tick=SETTINGS.tick)


@lru_cache(maxsize=2)
def judge(inertia: float) -> LiveHorizon:
    """The horizon of that bicycle."""
    return LiveHorizon(believed(inertia), SETTINGS.sensor_std)


@lru_cache(maxsize=4)
def drive(weaves: bool, inertia: float = 1.0, seconds: float = 12.0):
    """Commands of a driver on the plant, with Table-5 noise."""
    path, own = course(weaves), judge(inertia)
    x, y, psi = path.at(np.zeros(1))[0]
    plant, sensors, pedals = Plant(CLAY, start=Start(x=x, y=y, psi=psi, u=SPEED)), NoisySensors(1), Pedals(tick=SETTINGS.tick)
    start = [x, y, psi, SPEED, 0.0, 0.0]
    driver = Driver(
        small_ocp(), path, SPEED, n0=N_0, settings=SETTINGS, solver=Nmpc(small_ocp()), estimator=estimator(inertia), judge=own,
        start=start,
    )  # fmt: skip
    commands, measured = [], {}
    for k in range(round(seconds / SETTINGS.tick)):
        command = driver.tick(k * SETTINGS.tick, measured)
        commands.append(command)
        throttle, brake = pedals(command.a_x, command.speed, float(command.state[3]))
        sample = plant.step((command.steer, throttle, brake), SETTINGS.tick)
        states = dict(zip(STATE_CHANNELS, sensors.read((k + 1) * SETTINGS.tick, sample), strict=True))
        measured = {**states, **{name: sample[name] for name in (*WHEEL_CHANNELS, "a_x_imu")}}
    return commands, own.n


@pytest.mark.study
def test_a_weave_is_identified_and_its_n_goes_to_the_controller():
    """A closed loop lets rounding grow: with another compiler's the verdict comes a window earlier or later."""
    commands, n = drive(True, seconds=23.0)
    last = commands[-1]
    assert last.verdict == "identified"
    assert last.n == last.n_used == n
    assert abs(n - CLAY.n) < abs(N_0 - CLAY.n)
    first = next(c for c in commands if c.verdict == "identified")
    assert 3.0 < first.t < 22.0


def test_before_that_the_controller_drives_on_the_safe_side():
    commands, _ = drive(True)
    before = [c for c in commands if c.t < 3.0]
    assert {c.verdict for c in before} == {"not_excited"}
    assert all(c.n_used >= c.n for c in before)
    assert before[0].n_used > before[0].n + 0.1


def test_straight_on_nothing_is_identified():
    assert {c.verdict for c in drive(False)[0]} == {"not_excited"}


@pytest.mark.study
def test_with_a_yaw_inertia_off_by_40_percent_nothing_is_identified():
    assert "identified" not in {c.verdict for c in drive(True, 1.4)[0]}


def test_a_vehicle_that_stands_identifies_nothing():
    own = judge(1.0)
    own.start(0.0, N_0)
    inputs = dict.fromkeys(("steer", "steer_rate", "a_x", *WHEEL_CHANNELS), 0.0)
    rng = np.random.default_rng(0)
    for k in range(1000):
        own.tick(k * SETTINGS.tick, inputs, np.array(SETTINGS.sensor_std) * rng.normal(size=6))
    assert own.verdict == "not_excited"
    assert own.n == N_0


@pytest.mark.study
def test_a_load_on_an_identified_vehicle_is_said():
    declared = for_control(Declaration(identified.vehicle(), CLAY))
    log = identified.drive({**declared.vehicle.effects, **identified.LOAD}, "good")
    driven = shooting_drive(log, declared.build(), 1.0, live=True)
    own = LiveHorizon(declared, sensor_std(log, LEAST_NOISE), driven.dt)
    own.start(0.0, N_0)
    names = declared.build().external.names
    for t, u, y in zip(driven.t, driven.inputs, driven.measured, strict=True):
        own.tick(float(t), dict(zip(names, u, strict=True)), y)
    assert own.verdict == "inconsistent"
    assert own.evidence.load * declared.vehicle.mass == pytest.approx(400.0, rel=0.3)
    assert own.evidence.strain > 3.5


def test_without_joint_error_nothing_is_said_of_a_load():
    assert np.isnan(judge(1.0).evidence.load)


def test_without_a_judge_nothing_is_judged():
    driver = Driver(small_ocp(), course(False), SPEED, n0=N_0, start=[0.0, 0.0, 0.0, SPEED, 0.0, 0.0])
    assert driver.tick(0.0, {}).verdict == NOT_JUDGED


def test_a_live_horizon_loads_no_plant_and_no_numba():
    code = "import sys, softsoil.control.live_horizon; print([m for m in ('softsoil.plant', 'numba') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
