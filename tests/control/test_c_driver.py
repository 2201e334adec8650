"""The generated driver: the same commands as Python's on the same measurements, and what it promises."""

import importlib.util
import sys
from functools import lru_cache

import numpy as np
import pytest

from drives import PROJECT, reference_vehicle
from softsoil.control.c_folder import controller_texts
from softsoil.control.courses import double_lane_change
from softsoil.control.driver import Driver
from softsoil.control.driver_binding import CDriver
from softsoil.control.driver_types import DriverSettings
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.nmpc import Nmpc
from softsoil.control.ocp import Ocp
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.soil import CLAY

pytestmark = [pytest.mark.compiler, pytest.mark.slow]
SENSORS = DriverSettings(sensor_std=(0.05, 0.05, 0.003, 0.05, 0.05, 0.005))
DECLARED = Declaration(reference_vehicle(), CLAY, "hard_ground")
OBSTACLES = np.array([[62.0, 1.6, 1.0, 0.0, 0.0], [92.0, 2.4, 1.0, -0.1, 0.0]])
TICK, SPEED, N0 = SENSORS.tick, 6.0, 0.7
COMPARED = (
    "steer", "steer_rate", "speed", "a_x", "a_asked", "n", "n_std", "n_used", "slip", "along", "left", "lost", "halt", "finished",
    "stopped", "solved",
)  # fmt: skip


@lru_cache(maxsize=1)
def problem() -> Ocp:
    """The reference vehicle on hard ground, whose equations compile quickly, with its effects and histories."""
    return Ocp(DECLARED.build(), DECLARED.vehicle)


@lru_cache(maxsize=1)
def in_c() -> CDriver:
    return CDriver(controller_texts(DECLARED, driver=SENSORS), len(problem().z))


@lru_cache(maxsize=1)
def parts() -> tuple[Nmpc, LiveEstimator]:
    return Nmpc(problem()), LiveEstimator(problem().model, SENSORS.sensor_std)


def in_python(**more) -> Driver:
    solver, estimator = parts()
    given = {"obstacles": OBSTACLES, "n0": N0, "settings": SENSORS, "solver": solver, "estimator": estimator, **more}
    return Driver(problem(), double_lane_change(), SPEED, **given)


def started(**more) -> CDriver:
    given = {"obstacles": OBSTACLES, "n0": N0, **more}
    in_c().start(double_lane_change(), SPEED, **given)
    return in_c()


def strangers_vehicle():
    """The vehicle of examples/bring_your_own_vehicle.py, in a process of its own."""
    file = PROJECT / "examples" / "bring_your_own_vehicle.py"
    spec = importlib.util.spec_from_file_location("bring_your_own_vehicle", file)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    return example.LineVehicle([sys.executable, str(file), "vehicle"])


def driven(driver) -> np.ndarray:
    """(K, 4) x, y, psi, u of the stranger's vehicle, driven to the end of the course."""
    rows = []
    with strangers_vehicle() as vehicle:
        for k in range(3000):
            measured = vehicle.measure()
            command = driver.tick(k * TICK, measured)
            rows.append([measured[name] for name in ("x", "y", "psi", "u")])
            if command.finished:
                break
            vehicle.apply(command, TICK)
    return np.array(rows)


def test_a_strangers_vehicle_drives_the_same_path_by_python_and_by_c():
    """Filter, histories, solves and following of plans, from a first state that is measured: position to 1e-6 m."""
    one, other = driven(in_python()), driven(started())
    assert len(one) == len(other) and one[-1, 0] > 100.0
    np.testing.assert_allclose(other, one, atol=1e-6)


def faulty(k: int, measured: dict[str, float]) -> dict[str, float]:
    """Channels that are missing for a while, absurd once, or heading wrapped elsewhere."""
    lost = {"x", "y", "u"} if 200 < k < 260 else {"omega_fl"} if 300 < k < 330 else {"a_x_imu"} if 340 < k < 360 else set()
    out = {name: value for name, value in measured.items() if name not in lost}
    out["psi"] = measured["psi"] + 2 * np.pi * (k // 100)
    if k == 400:
        out["y"] += 30.0
    if k == 410:
        out["steer"] = 1e300
    return out


@pytest.mark.parametrize(("learn", "start"), ((True, None), (False, None), (True, [0.0, 0.0, 0.0, 5.5, 0.0, 0.0])))
def test_every_command_is_pythons(learn, start):
    """Tick by tick on the same measurements, dropouts and outliers among them; the first ones come without a speed."""
    one, other = in_python(learn=learn, start=start), started(learn=learn, start=start)
    with strangers_vehicle() as vehicle:
        for k in range(600):
            measured = faulty(k, vehicle.measure())
            if k < 5:
                del measured["u"]
            ours, theirs = other.tick(k * TICK, measured), one.tick(k * TICK, measured)
            for name in COMPARED:
                assert getattr(ours, name) == pytest.approx(float(getattr(theirs, name)), abs=1e-6), (k, name)
            if ours.started:
                np.testing.assert_allclose(ours.z, theirs.state, atol=1e-6)
            vehicle.apply(theirs, TICK)
    assert ours.solved == 0 and ours.started == 1 and ours.n_used <= ours.n + SENSORS.most


def test_it_stops_before_what_it_cannot_pass_and_without_measurements():
    wall = [[86.0, 0.2, 25.0, 0.0, 0.0]]
    driver, stood = started(obstacles=wall), None
    with strangers_vehicle() as vehicle:
        for k in range(2000):
            measured = vehicle.measure()
            command = driver.tick(k * TICK, measured)
            stood = k if command.stopped else None
            if stood:
                break
            vehicle.apply(command, TICK)
    assert stood and command.halt and not command.finished and measured["x"] < 61.0
    driver = started()
    for k in range(200):
        command = driver.tick(k * TICK, {})
    assert command.lost and command.steer == 0.0 and command.a_asked < 0.0 and not command.started


def test_wrong_tasks_are_refused():
    for wrong in ({"n0": 3.0}, {"obstacles": [[np.nan, 0.0, 1.0, 0.0, 0.0]]}, {"start": [np.inf, 0.0, 0.0, 5.0, 0.0, 0.0]}):
        with pytest.raises(ValueError, match="out of its range"):
            started(**wrong)
    with pytest.raises(ValueError, match="has not been called"):
        in_c().tick(0.0, {})
    driver = started()
    with pytest.raises(ValueError, match="out of its range"):
        driver.tick(float("nan"), {})
