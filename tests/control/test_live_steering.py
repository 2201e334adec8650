"""A steering that lags, is slow, off or stuck: what is learnt of it, where plans begin, and when the vehicle halts."""

import math
from dataclasses import replace

import numpy as np
import pytest

from driven_vehicle import NAMES, SENSORS, Braked, driven
from softsoil.control.driver_types import DriverSettings
from softsoil.control.live_steering import STILL, LiveSteering
from softsoil.control.nmpc_status import Status

TICK, RATE, GAP = 0.0125, 1.0, 0.1
T = np.arange(0.0, 20.0, TICK)


class Steered(Braked):
    """A vehicle whose wheels go from their angle where `steering` lets them, with a sensor of it, from (angle, t) where given."""

    def __init__(self, steering, sensor=lambda angle, t: angle) -> None:
        super().__init__()
        self.steering, self.sensor = steering, sensor

    def measure(self) -> dict[str, float]:
        angle, t = float(self.z[-1]), self.k * SENSORS.tick
        return {name: float(self.z[i]) for i, name in enumerate(NAMES)} | {"steer": self.sensor(angle, t)}

    def apply(self, command, seconds) -> None:
        angle = self.steering(float(self.z[-1]), command.steer, self.k * SENSORS.tick)
        super().apply(replace(command, steer=angle), seconds)


def lagging(seconds, tick=SENSORS.tick):
    share = 1.0 - math.exp(-tick / seconds)
    return lambda angle, command, t: angle + share * (command - angle)


def at_once(angle, command, t):
    return command


def never(angle, t):
    return math.nan


@pytest.mark.parametrize("seconds", (0.1, 0.3))
def test_the_lag_of_a_steering_is_learnt_and_made_up_for(seconds):
    """Plans that began at the measured angle asked for a tenth of every step; without the lag in them the vehicle weaves."""
    _, exact = driven(Steered(at_once), 10.0)
    _, log = driven(Steered(lagging(seconds)), 10.0)
    assert log.commands[-1].finished and log.failures == 0
    assert log.commands[-1].actuator_lag == pytest.approx(seconds, abs=0.03)
    assert exact.commands[-1].actuator_lag == pytest.approx(0.0, abs=0.01)
    worst = [np.abs(one.column("left")[200:]).max() for one in (exact, log)]
    assert worst[1] < worst[0] + 0.15


def test_a_declared_lag_serves_where_no_angle_is_measured():
    worst = []
    for lag in (0.0, 0.3):
        _, log = driven(Steered(lagging(0.3), never), 10.0, settings=replace(SENSORS, actuator_lag=lag))
        assert log.commands[-1].actuator_lag == lag
        worst.append(np.abs(log.column("left")[200:]).max())
    assert worst[1] < 0.4 < 0.6 < worst[0]


@pytest.mark.parametrize("off", (0.05, -0.05))
def test_a_sensor_that_is_off_does_not_drive_the_command_on(off):
    _, log = driven(Steered(at_once, lambda angle, t: angle + off))
    assert log.commands[-1].finished and np.abs(log.column("left")[300:]).max() < 0.35


@pytest.mark.parametrize("what", ("wheels", "sensor"))
def test_wheels_or_a_sensor_that_are_stuck_halt_the_vehicle(what):
    """From 3 s on, the sensor 0.1 rad beside where the wheels were then."""
    kept: list[float] = []

    def wheels(angle, command, t):
        return command if what == "sensor" or t < 3.0 else angle

    def sensor(angle, t):
        if t < 3.0 or what == "wheels":
            return angle
        kept.append(angle)
        return kept[0] - 0.1

    _, log = driven(Steered(wheels, sensor), 20.0)
    last = log.commands[-1]
    assert last.stopped and last.halt and last.status is Status.STEERING_STUCK and not log.column("finished").any()
    first = next(c.t for c in log.commands if c.halt)
    assert 3.0 + STILL < first < 8.0 and np.abs(log.column("left")).max() < 3.0


def test_a_vehicle_whose_steering_follows_again_goes_on():
    """Wheels that hang in a bend, and are let go a while after the vehicle came to a stand."""
    follow = lagging(0.1)
    vehicle = Steered(lambda angle, command, t: 0.25 if 3.0 < t < 9.0 else follow(angle, command, t))
    driver, halted, command = driven(vehicle, 0.0)[0], [], None
    while command is None or (not command.finished and command.t < 30.0):
        command = driver.tick(vehicle.k * SENSORS.tick, vehicle.measure())
        if command.halt:
            halted.append(command.t)
        vehicle.apply(command, SENSORS.tick)
    assert 3.0 + STILL < halted[0] < 6.0 and 9.0 < halted[-1] < 14.0
    assert command.finished and not command.halt


def steering(commands, angles, every: int = 1, lag: float = 0.0) -> tuple[LiveSteering, list[float], list[bool]]:
    """After commands and angles tick by tick, measured at one in `every` of them: what it took, and whether it said stuck."""
    live = LiveSteering(RATE, TICK, GAP, lag)
    live.begin(float(angles[0]))
    taken, stuck = [], []
    for k, (command, angle) in enumerate(zip(commands[:-1], angles[1:], strict=True)):
        live.ask(float(command))
        taken.append(live.take(float(angle) if k % every == 0 else math.nan))
        stuck.append(live.stuck)
    return live, taken, stuck


def behind(commands, seconds):
    """Angles that lag behind the commands."""
    share, angles = 1.0 - math.exp(-TICK / seconds), [commands[0]]
    for command in commands[:-1]:
        angles.append(angles[-1] + share * (command - angles[-1]))
    return np.array(angles)


@pytest.mark.parametrize("every", (1, 8))
@pytest.mark.parametrize("noise", (0.0, 0.005))
@pytest.mark.parametrize("seconds", (0.05, 0.15, 0.4))
def test_a_lag_is_found_through_noise_offset_and_slow_sensors(seconds, noise, every):
    commands = 0.3 * np.sin(2 * np.pi * T / 4.0)
    angles = behind(commands, seconds) + 0.04 + noise * np.random.default_rng(3).standard_normal(len(T))
    for first in (0.0, 0.3):
        live, _, _ = steering(commands, angles, every, first)
        assert live.lag == pytest.approx(seconds, abs=0.02 + 0.05 * seconds), first


def test_without_a_move_or_a_measurement_the_first_guess_stays():
    assert steering(np.zeros(400), np.zeros(400), lag=0.2)[0].lag == pytest.approx(0.2, abs=1e-6)
    assert steering(0.3 * np.sin(T), np.full(len(T), math.nan), lag=0.2)[0].lag == 0.2
    noise = 0.005 * np.random.default_rng(4).standard_normal(len(T))
    assert steering(np.zeros(len(T)), noise)[0].lag < 0.02


@pytest.mark.parametrize("rate", (0.1, 0.25, 0.5))
@pytest.mark.parametrize("noise", (0.0, 0.02))
def test_a_slow_steering_is_not_stuck(rate, noise):
    """Lock to lock at a fraction of the declared rate: far behind its command, but moving."""
    live, angle, rng, behind_it = LiveSteering(RATE, TICK, GAP, 0.0), 0.0, np.random.default_rng(1), []
    live.begin(0.0)
    for t in T:
        wanted = 0.45 * np.sign(np.sin(2 * np.pi * t / 10.0))
        live.ask(live.wheels + float(np.clip(wanted - live.wheels, -0.1, 0.1)))
        angle += float(np.clip(live.command - angle, -rate * TICK, rate * TICK))
        live.take(angle + noise * rng.standard_normal())
        behind_it.append(abs(live.command - angle))
        assert not live.stuck, t
    assert max(behind_it) > 1.5 * GAP


@pytest.mark.parametrize("noise", (0.0, 0.02))
def test_a_stuck_angle_shows_through_its_noise_and_is_forgiven_when_it_follows(noise):
    commands = 0.3 * np.sin(2 * np.pi * T / 8.0)
    angles = np.where((T > 6.0) & (T < 14.0), -0.3, commands) + noise * np.random.default_rng(2).standard_normal(len(T))
    stuck, t = np.array(steering(commands, angles)[2]), T[1:]
    assert not stuck[t < 6.0].any() and stuck[(t > 9.5) & (t < 10.5)].all() and not stuck[-1]


def test_an_angle_that_cannot_be_one_is_not_taken():
    _, taken, _ = steering([0.1] * 7, [0.1, 0.1, 1.2, math.nan, math.inf, 0.12, 5.0])
    assert taken == [0.1, 0.1, 0.1, 0.1, 0.12, 0.1]
    _, taken, _ = steering([0.1] * 81, [0.1] + [0.8] * 80)
    assert taken[0] == 0.1 and taken[-1] == 0.8, "an angle that stays is believed"


def test_the_expected_angle_leads_the_measured_one_by_so_much_only():
    live = LiveSteering(RATE, TICK, GAP, 0.0)
    live.begin(0.0)
    for command, expected in ((0.15, 0.15), (0.4, 0.4 - RATE * TICK), (-0.4, -0.4 + RATE * TICK), (0.205, 0.2)):
        live.ask(command)
        live.take(0.0)
        assert live.wheels == pytest.approx(expected), command
    live.ask(0.4)
    assert live.take(math.nan) == live.wheels == pytest.approx(0.4), "nothing was measured"


def test_a_gap_or_a_lag_that_is_none_is_refused():
    with pytest.raises(ValueError, match=r"steering_gap in .0, 1000., found -1"):
        DriverSettings(steering_gap=-1.0)
    with pytest.raises(ValueError, match=r"actuator_lag in .0, 0\.5. s, found 0\.6"):
        DriverSettings(actuator_lag=0.6)
