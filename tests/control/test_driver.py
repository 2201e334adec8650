"""The driver: its parts, a drive of a small vehicle, and what it does when measurements or plans are missing."""

import importlib.util
import math
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from driven_vehicle import NAMES, SENSORS, Braked, ModelVehicle, driven, parts
from drives import PROJECT, reference_vehicle
from nmpc_problem import small_ocp
from softsoil.control.courses import double_lane_change, straight
from softsoil.control.declared import for_control
from softsoil.control.driver import Driver
from softsoil.control.driver_types import DriverCommand, DriverSettings
from softsoil.control.follower import PlanFollower
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.nmpc_status import Status
from softsoil.control.ocp import Ocp, OcpSettings
from softsoil.control.path import Path
from softsoil.control.pedals import Pedals
from softsoil.declaration.model_file import Declaration
from softsoil.files.steering_map import SteeringMap
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.soil import CLAY


def test_the_estimator_begins_each_drive_anew():
    estimator = LiveEstimator(small_ocp().model, np.full(6, 0.1))
    inputs = {signal.name: signal.nominal for signal in small_ocp().model.external}
    x0 = np.array([0.0, 0.0, 0.0, 5.0, 0.0, 0.0])
    found = []
    for _ in range(2):
        estimator.start(x0, 0.7, True)
        for k in range(50):
            estimator.tick(inputs, x0 + [0.06 * (k + 1), 0.0, 0.0, 0.0, 0.0, 0.0])
        found.append((estimator.filter.x, estimator.n_std))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert found[0][1] == found[1][1]


def test_a_prediction_without_a_usable_answer_is_refused_and_the_filter_comes_back():
    estimator = LiveEstimator(small_ocp().model, np.full(6, 0.1))
    inputs = {signal.name: signal.nominal for signal in small_ocp().model.external}
    x0 = np.array([1.0, 2.0, 0.0, 5.0, 0.0, 0.0])
    estimator.start(x0, 0.7, True)
    wild = estimator.filter.x
    wild[estimator.augmented.x.index("omega_z")] = 1e4
    estimator.filter.x = wild
    estimator.tick(inputs, x0)
    assert estimator.status.refused
    for _ in range(400):
        x0[0] += 5.0 * estimator.terrain.dt
        estimator.tick(inputs, x0)
    assert not estimator.status.refused
    # The heading came back from 36 turns and 0.2 rad, inside its gate: n may move, by less than it is known to.
    assert abs(estimator.n - 0.7) < estimator.n_std and estimator.n_std > 0.25
    np.testing.assert_allclose(estimator.states[:2], x0[:2], atol=0.5)


def test_without_a_plan_the_vehicle_straightens_and_brakes():
    follower = PlanFollower(0.1)
    follower.take(0.0, np.full(11, 0.2), np.full(11, 5.0), np.zeros(10))
    assert follower.command(0.5, 0.2) == pytest.approx((0.2, 5.0, 0.0))
    steer, _, a_x = follower.command(1.5, 0.2)
    assert 0.0 < steer < 0.2 and a_x < 0
    throttle, brake = Pedals()(-2.0, 0.0, 5.0)
    assert throttle == 0.0 and brake > 0


def test_a_stranger_starts_from_its_first_measurements_and_comes_to_the_path():
    _, log = driven(ModelVehicle())
    assert log.error is None and log.commands[-1].finished and log.failures == 0
    left = log.column("left")
    assert left[0] == pytest.approx(0.4, abs=0.1) and np.abs(left[300:]).max() < 0.3
    np.testing.assert_allclose(log.commands[0].state[:6], [0.0, 0.4, 0.0, 5.0, 0.0, 0.0], atol=1e-12)


def test_a_vehicle_with_a_steering_map_is_commanded_in_its_unit_and_measured_in_it():
    steering = SteeringMap((-8.0, 0.0, 6.0), (-0.5, 0.03, 0.5))
    ocp = small_ocp()
    mapped = Ocp(ocp.model, ocp.vehicle.with_(steering=steering), ocp.settings)
    solver, estimator = parts()
    driver = Driver(mapped, Path(straight().points[:160]), 5.0, settings=SENSORS, solver=solver, estimator=estimator)
    measured = {"x": 0.0, "y": 0.4, "psi": 0.0, "u": 5.0, "steer_command": 1.2}
    first = driver.tick(0.0, measured)
    assert steering.angle_of(first.steer_command) == pytest.approx(first.steer, abs=1e-9)
    assert driver._steering(measured) == pytest.approx(float(steering.angle_of(1.2)))
    assert driver._steering({**measured, "steer": 0.1}) == 0.1
    assert math.isnan(driver._steering({}))
    plain, _ = driven(ModelVehicle(), 0.1)
    assert math.isnan(plain.tick(0.2, {}).steer_command)


class Sure:
    """A judge that is sure of an n, the vehicle's own where nothing else is said, from the first tick on."""

    verdict, n_std = "identified", 0.02

    def __init__(self, n: float = 0.5) -> None:
        self.n = n

    def start(self, t, n0):
        """A drive begins."""

    def tick(self, t, inputs, y):
        """A sample comes."""


def test_without_wheel_speeds_and_accelerometer_n_is_still_learnt_and_the_uncertain_n_is_on_the_safe_side():
    _, log = driven(ModelVehicle())
    first, last = log.commands[0], log.commands[-1]
    assert first.n == 0.7 and first.n_used == pytest.approx(0.95) and first.verdict == "not_judged"
    assert last.n_std < first.n_std and last.n_used <= last.n + SENSORS.most
    _, judged = driven(ModelVehicle(), 2.0, judge=Sure())
    assert all(command.n_used == command.n == 0.5 for command in judged.commands)
    assert judged.commands[0].verdict == "identified" and judged.commands[0].n_std == Sure.n_std


def test_an_n_that_the_filter_contests_is_not_identified():
    """While the filter knows little the judge's n counts; once it is sure of another one, neither does."""
    _, log = driven(ModelVehicle(), 2.0, judge=Sure(0.6))
    first, last = log.commands[0], log.commands[-1]
    assert first.verdict == "identified" and first.n_used == 0.6
    assert last.verdict == "inconsistent" and last.n == pytest.approx(0.5, abs=0.03) and last.n_used < 0.55


class HeldBack(ModelVehicle):
    """A vehicle that the soil holds back by 0.6 m/s^2, of which the controller's model knows nothing."""

    def apply(self, command: DriverCommand, seconds: float) -> None:
        super().apply(command, seconds)
        self.z[3] -= 0.6 * seconds


def test_the_speed_is_held_against_what_the_plan_does_not_know():
    free = driven(ModelVehicle(), 6.0)[1].column("state")[-1, 3]
    driver, log = driven(HeldBack(), 6.0)
    assert log.column("state")[-1, 3] == pytest.approx(free, abs=0.05)
    assert driver.resistance == pytest.approx(0.6, abs=0.15)
    careless = replace(SENSORS, resistance_share=0.0)
    assert driven(HeldBack(), 6.0, settings=careless)[1].column("state")[-1, 3] < 4.8


def test_a_vehicle_far_from_the_path_is_no_faster_than_a_share_above_what_was_asked():
    _, log = driven(ModelVehicle(y=15.0), 8.0)
    speeds = log.column("state")[:, 3]
    assert speeds.max() < 1.25 * 5.0 and log.column("speed").max() < 1.25 * 5.0
    assert abs(log.column("left")[-1]) < 3.0, "it comes to the path"
    hasty = replace(SENSORS, overspeed=10.0)
    assert driven(ModelVehicle(y=15.0), 8.0, settings=hasty)[1].column("state")[:, 3].max() > 1.4 * 5.0


def test_the_commanded_angle_stays_inside_the_lock():
    """Plans that turn towards a path far away violate the soft limit."""
    lock = small_ocp().vehicle.max_steer
    solver, estimator = parts()
    path = Path(straight().points[:160])
    driver = Driver(small_ocp(), path, 2.0, settings=SENSORS, solver=solver, estimator=estimator)
    vehicle, planned = ModelVehicle(y=15.0), []
    for k in range(400):
        command = driver.tick(k * SENSORS.tick, vehicle.measure())
        assert abs(command.steer) <= lock + 1e-12
        planned.append(np.abs(command.plan_z[:, -1]).max())
        vehicle.apply(command, SENSORS.tick)
    assert max(planned) > 1.2 * lock


def test_brakes_that_someone_else_holds_wind_up_half():
    driver, _ = driven(ModelVehicle(), 0.0)
    for k in range(600):
        command = driver.tick(k * SENSORS.tick, {"x": 1.0, "y": 0.0, "psi": 0.0, "u": 0.0, "v": 0.0, "omega_z": 0.0})
    assert not command.halt and driver.resistance == pytest.approx(0.5 * SENSORS.most_resistance)


def test_a_driver_that_does_not_learn_keeps_what_it_was_given():
    driver, log = driven(ModelVehicle(), 1.0, learn=False)
    np.testing.assert_allclose(log.column("n"), 0.7)
    np.testing.assert_array_equal(log.column("n_used"), log.column("n"))
    driver.set_n(0.55)
    assert driver.tick(1.0, {}).n == pytest.approx(0.55)


def test_it_waits_for_a_first_state_and_the_command_meanwhile_is_safe():
    _, log = driven(ModelVehicle(keep=lambda k, name: k >= 10 or name != "u"), 1.0)
    waiting = log.commands[:10]
    assert all(c.lost and c.status is Status.NO_STATE and c.speed == 0.0 and c.steer == 0.0 for c in waiting)
    assert log.commands[10].solved and not log.commands[11].lost


def test_a_dropout_is_driven_through():
    _, log = driven(ModelVehicle(keep=lambda k, name: not 150 < k < 250))
    assert log.commands[-1].finished and np.abs(log.column("left")).max() < 1.0


def test_a_vehicle_that_sees_nothing_any_more_brakes_to_a_halt_and_says_why():
    """Nothing is measured from 1 s on: driven on for `dead_reckoning`, then halted where it truly stands, never finished."""
    settings = replace(SENSORS, dead_reckoning=2.0)
    vehicle = Braked(keep=lambda k, name: k < 84)
    _, log = driven(vehicle, 12.0, settings=settings)
    last, halt = log.commands[-1], log.column("halt")
    assert last.stopped and last.halt and last.status is Status.POSITION_UNKNOWN and not log.column("finished").any()
    begun = log.commands[int(np.argmax(halt))].t
    assert 3.0 < begun < 3.0 + 2 * SENSORS.period + SENSORS.tick and halt[int(np.argmax(halt)) :].all()
    assert vehicle.z[3] < SENSORS.standing
    assert last.dead_reckoned == pytest.approx(last.t - 83 * SENSORS.tick) and log.commands[80].dead_reckoned == 0.0
    assert last.position_std > 2 * log.commands[80].position_std > 0.0
    assert log.failures == 0


def test_a_vehicle_that_sees_again_goes_on():
    vehicle = Braked(keep=lambda k, name: not 84 <= k < 240)
    _, log = driven(vehicle, 14.0, settings=replace(SENSORS, dead_reckoning=1.5))
    assert log.column("halt").any() and not log.commands[-1].halt
    assert log.commands[-1].finished and log.commands[-1].dead_reckoned == 0.0


def test_a_position_that_is_too_uncertain_halts_though_the_speed_is_measured():
    vehicle = Braked(keep=lambda k, name: k < 84 or name == "u")
    _, log = driven(vehicle, 12.0, settings=replace(SENSORS, most_position_std=0.1))
    last = log.commands[-1]
    assert last.stopped and last.status is Status.POSITION_UNKNOWN and last.position_std > 0.1 and last.dead_reckoned == 0.0


@pytest.mark.parametrize("pause", (0.5, 2.0))
def test_a_late_call_is_predicted_over(pause):
    """The loop hangs while the vehicle drives straight on: the next command knows where it is, and believes its sensors."""
    vehicle = ModelVehicle(y=0.0)
    path = Path(np.column_stack([np.arange(0.0, 60.0, 0.25), np.zeros(240)]))
    solver, estimator = parts()
    driver = Driver(small_ocp(), path, 5.0, settings=SENSORS, solver=solver, estimator=estimator, n0=0.7)
    t = 0.0
    for k in range(300):
        command = driver.tick(t, vehicle.measure())
        if k > 200:
            assert not command.filter_status.gated and abs(command.state[0] - vehicle.z[0]) < 0.1, k
        for _ in range(round(pause / SENSORS.tick) if k == 200 else 1):
            vehicle.apply(command, SENSORS.tick)
            t += SENSORS.tick
    assert not command.halt and command.status is not Status.POSITION_UNKNOWN


@pytest.mark.parametrize("share", (0.4, 0.8, 1.7))
def test_calls_at_another_pace_are_kept_up_with(share):
    """Steps follow the time of the calls; what is measured between two of them is not lost."""
    vehicle, path = ModelVehicle(y=0.0), Path(straight().points[:160])
    solver, estimator = parts()
    driver = Driver(small_ocp(), path, 5.0, settings=SENSORS, solver=solver, estimator=estimator, n0=0.7)
    period = share * SENSORS.tick
    for k in range(round(3.0 / period)):
        measured = vehicle.measure() if k % 3 == 0 else {}
        command = driver.tick(k * period, measured)
        vehicle.apply(command, period)
        assert abs(command.state[0] - vehicle.z[0]) < 0.15 and not command.filter_status.gated
    assert command.dead_reckoned < 0.1 and command.position_std < 0.05


def test_after_a_long_pause_the_drive_begins_anew_where_the_vehicle_is():
    driver, log = driven(ModelVehicle(), 3.0)
    n, t = log.commands[-1].n, log.commands[-1].t + SENSORS.dead_reckoning + 1.0
    waiting = driver.tick(t, {"u": 5.0, "psi": 0.0})
    assert waiting.lost and waiting.status is Status.NO_STATE and waiting.n == n
    again = driver.tick(t + 0.1, {"x": 25.0, "y": 0.1})
    np.testing.assert_allclose(again.state[:4], [25.0, 0.1, 0.0, 5.0])
    assert again.solved and again.status.usable and again.n == n and again.n_std > log.commands[-1].n_std
    assert again.position_std > math.hypot(*SENSORS.sensor_std[:2]) - 1e-9


def test_a_first_state_may_come_from_sensors_of_different_rates():
    driver, _ = driven(ModelVehicle(), 0.0)
    assert driver.tick(0.0, {"x": 0.5, "y": 0.4}).status is Status.NO_STATE
    first = driver.tick(0.1, {"psi": 0.02, "u": 5.0})
    assert first.solved and first.position_std > 2.0 * math.hypot(*SENSORS.sensor_std[:2]), "half a metre was driven since"
    np.testing.assert_allclose(first.state[:4], [0.5, 0.4, 0.02, 5.0])
    driver, _ = driven(ModelVehicle(), 0.0)
    driver.tick(0.0, {"x": 0.5, "y": 0.4})
    assert driver.tick(0.7, {"psi": 0.02, "u": 5.0}).status is Status.NO_STATE, "a position of too long ago"


def test_without_a_measured_speed_brakes_hold_the_estimate():
    """The commanded acceleration stands for the accelerometer: it does not drive a vehicle that stands backwards."""
    driver, _ = driven(ModelVehicle(), 0.0, settings=replace(SENSORS, dead_reckoning=0.2))
    driver.tick(0.0, {"x": 0.0, "y": 0.0, "psi": 0.0, "u": 2.0})
    commands = [driver.tick(k * SENSORS.tick, {"psi": 0.0, "omega_z": 0.0}) for k in range(1, 500)]
    speeds = [command.state[3] for command in commands]
    assert commands[-1].halt and min(speeds) > -0.05 and abs(speeds[-1]) < 0.05 and commands[-1].stopped


@pytest.mark.study
def test_a_small_robot_keeps_its_speed_round_a_circle():
    """Its wheelbase is a fifth of the radius: plans that keep the heading to the course drive a fifth too fast."""
    robot = reference_vehicle().with_(
        mass=45.0, l_f=0.31, l_r=0.31, yaw_inertia=3.2, track=0.5, track_rear=0.5, h_cg=0.18, radius=0.13, width=0.09,
        max_steer=0.45, max_steer_rate=2.5, effects={}, simulator={},
    )  # fmt: skip
    model = nominal_bicycle(robot, CLAY, TurnSlip(front_nodes=2))
    ocp = Ocp(model, robot, OcpSettings(steps=20, dt=0.1))
    turn = np.arange(0.0, 6.0, 0.02)
    path = Path(3.2 * np.column_stack([np.sin(turn), 1.0 - np.cos(turn)]))
    driver, rates, z = Driver(ocp, path, 1.2, settings=SENSORS, n0=0.5), ocp.dynamics(), ocp.z.pack(u=1.2)
    speeds, left = [], []
    for k in range(700):
        command = driver.tick(k * SENSORS.tick, {**dict(zip(NAMES, map(float, z), strict=False)), "steer": float(z[-1])})
        for _ in range(4):
            w = np.array([(command.steer - z[-1]) / SENSORS.tick, command.a_asked])
            z = z + SENSORS.tick / 4 * np.array(rates(z, w, np.zeros(0), ocp.s.nominal)[0]).ravel()
        speeds.append(z[3])
        left.append(command.left)
    assert np.mean(speeds[300:]) == pytest.approx(1.2, rel=0.04) and np.abs(left[300:]).max() < 0.05


@pytest.mark.parametrize("laps", (1, 2))
def test_a_closed_path_is_driven_from_its_beginning(laps):
    turn = np.linspace(0.0, 2 * np.pi * laps, 200 * laps)
    circle = Path(10.0 * np.column_stack([np.sin(turn), 1.0 - np.cos(turn)]))
    for x, y in ((-0.3, 0.0), (0.2, 0.1), (0.0, -0.5)):
        assert abs(circle.project(x, y)[0] - x) < 0.2
    assert circle.project(-2.5, 0.4)[0] == pytest.approx(-2.5, abs=0.2), "before its beginning, not at its end"
    assert circle.project(0.0, 20.0)[0] == pytest.approx(10.0 * np.pi, abs=0.2), "half-way round there is no place but that"
    assert circle.project(0.0, 0.0, near=circle.s[-1])[0] == pytest.approx(circle.s[-1], abs=0.1)


def test_a_drive_is_finished_where_the_settings_say():
    for end in (0.5, 6.0):
        _, log = driven(ModelVehicle(), 12.0, settings=replace(SENSORS, end=end))
        assert log.commands[-1].finished
        assert log.commands[-1].along == pytest.approx(Path(straight().points[:160]).s[-1] - end, abs=0.5)


@pytest.mark.parametrize("value", (None, math.nan))
def test_nothing_is_stopped_before_a_speed_is_known(value):
    driver, _ = driven(ModelVehicle(), 0.0)
    for k in range(200):
        command = driver.tick(k * SENSORS.tick, {} if value is None else dict.fromkeys(NAMES, value))
        assert command.lost and not command.stopped and math.isnan(command.position_std)


def test_the_command_tells_what_the_filter_did():
    driver, _ = driven(ModelVehicle(), 1.0)
    assert driver.tick(1.0, {"x": 500.0, "u": 5.0}).filter_status.gated == ("x",)


def test_a_vehicle_that_raises_keeps_the_log():
    _, log = driven(ModelVehicle(raises=120))
    assert isinstance(log.error, OSError) and len(log.commands) == 120


def test_what_cannot_be_driven_is_refused():
    wrong = (
        ({"n0": 3.0}, "n0: expected"), ({"obstacles": [[1.0, 2.0]]}, "obstacles: expected .K, 5."),
        ({"obstacles": [[30.0, math.nan, 1.0, 0.0, 0.0]]}, "obstacles: expected finite .* in row 0"),
        ({"obstacles": [[30.0, 0.0, -1.0, 0.0, 0.0]]}, "radius >= 0 m, found -1"),
        ({"start": [0.0, 0.0, 0.0, math.inf, 0.0, 0.0]}, "start: expected six finite"), ({"start": [0.0]}, "start: expected six"),
    )  # fmt: skip
    for given, word in wrong:
        with pytest.raises(ValueError, match=word):
            driven(ModelVehicle(), 0.1, **given)
    for speed in (0.0, -3.0, 20.0, math.nan):
        with pytest.raises(ValueError, match=f"speed: expected 0.5 to 12 m/s.*found {speed}; .*brake"):
            Driver(small_ocp(), straight(), speed, solver=parts()[0], estimator=parts()[1])
    driver = Driver(small_ocp(), straight(), 4.0, solver=parts()[0], estimator=parts()[1])
    with pytest.raises(ValueError, match=r"speed: expected 0\.5 to 12 m/s"):
        driver.speed = 0.0
    assert driver.speed == 4.0
    points = straight().points.copy()
    points[3, 1] = math.nan
    with pytest.raises(ValueError, match=r"path: expected finite x, y, found .* in point 3"):
        Path(points)
    with pytest.raises(ValueError, match="dead_reckoning"):
        DriverSettings(dead_reckoning=math.nan)
    with pytest.raises(ValueError, match="tick"):
        DriverSettings(tick=0.0)


def test_what_is_no_declaration_or_number_is_named():
    with pytest.raises(TypeError, match=r"controller: expected a declaration, found a Vehicle: hand over softsoil\.Declaration"):
        Driver(reference_vehicle(), double_lane_change(), 6.0)
    with pytest.raises(TypeError, match=r"speed: expected a number of m/s, found '6'"):
        Driver(small_ocp(), double_lane_change(), "6", solver=parts()[0], estimator=parts()[1])


def test_a_tick_that_makes_no_sense_is_refused_and_changes_nothing():
    driver, _ = driven(ModelVehicle(), 0.5)
    with pytest.raises(ValueError, match=r"t: expected a finite time .* found nan"):
        driver.tick(math.nan, {})
    with pytest.raises(ValueError, match=r"t: expected a time that is not before the last tick's, .* 4 s; found -1.0 s"):
        driver.tick(-1.0, {})
    with pytest.raises(ValueError, match=r"measured: expected names of x, y, .*steer_command; found 'speed'"):
        driver.tick(0.6, {"speed": 5.0})
    assert not driver.tick(0.5, {"u": 5.0}).lost


def test_control_loads_no_plant_and_no_numba():
    code = "import sys, softsoil.control.driver; print([m for m in sys.modules if m.startswith(('numba', 'softsoil.plant'))])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=PROJECT)
    assert done.stdout.strip() == "[]"


def test_the_example_drives_a_vehicle_in_another_process(capsys):
    """The example's own loop and vehicle; the driver here has the small problem, whose C is built quickly."""
    file = PROJECT / "examples" / "bring_your_own_vehicle.py"
    spec = importlib.util.spec_from_file_location("bring_your_own_vehicle", file)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    solver, estimator = parts()
    driver = Driver(
        small_ocp(), double_lane_change(), 5.5, n0=0.7, settings=SENSORS, solver=solver, estimator=estimator
    )
    assert example.main([sys.executable, str(file), "vehicle"], driver) == 0
    printed = capsys.readouterr().out
    assert float(re.search(r"at most (\S+) m off", printed).group(1)) < 1.2 and "0 solves failed" in printed
    assert "not_judged" in printed, "an estimate without a verdict is not called identified"
    assert (
        example.main([sys.executable, "-c", "pass"], Driver(small_ocp(), double_lane_change(), 5.5, solver=solver)) == 1
    )


def test_a_controllers_least_effects_have_the_size_of_the_vehicle():
    for scale in (1.0, 0.3):
        vehicle = reference_vehicle().with_(h_cg=0.63 * scale, effects={})
        effects = for_control(Declaration(vehicle, CLAY)).vehicle.effects["load_transfer"]
        assert effects["transfer_height"] == pytest.approx(0.74 * scale, rel=0.01)
        assert effects["roll_sweep"] == pytest.approx(0.55 * scale, rel=0.01)
