"""Steering that does not do at once what it is asked to: `python -m benchmarks.steering_actuators`.

A double lane change at 6 m/s on clay, driven by `softsoil.control.driver.Driver` on sensors with the noise `good`. The vehicle is
the controller's own model, so that everything which goes wrong is the steering's: its lag, its greatest rate, its lock, its zero,
its sensor. Printed for each: whether the drive came to its end, the distance from the path (rms and worst, m), the lag that the
driver knows at its end (s), and why it halted.
"""

from __future__ import annotations

import argparse
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from softsoil.control.courses import double_lane_change
from softsoil.control.drive_loop import DriveLog, drive
from softsoil.control.driver import Driver
from softsoil.control.driver_types import DriverCommand, DriverSettings
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.nmpc import Nmpc
from softsoil.control.ocp import Ocp
from softsoil.recording.noise import GOOD
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.soil import SOILS
from softsoil.symbolic.vehicle import load_vehicle

VEHICLE = Path(__file__).resolve().parents[1] / "vehicles" / "reference.toml"
NAMES = ("x", "y", "psi", "u", "v", "omega_z")
FAILS = 5.0
"""s into the drive: from here on what is stuck is stuck."""
DECLARED = "actuator_lag = 0.2"
Steering = Callable[[float, float, float], float]
"""From the angle of the wheels (rad), the command (rad) and the time (s) to the angle a tick later."""
Sensor = Callable[[float, float], float]
"""From the angle of the wheels (rad) and the time (s) to what is measured (rad)."""


def exact(angle: float, command: float, t: float) -> float:
    """At once."""
    return command


def lagging(seconds: float, tick: float) -> Steering:
    """First order."""
    share = 1.0 - np.exp(-tick / seconds)
    return lambda angle, command, t: angle + share * (command - angle)


def slow(rate: float, tick: float) -> Steering:
    """At a rate of its own at most (rad/s)."""
    return lambda angle, command, t: angle + float(np.clip(command - angle, -rate * tick, rate * tick))


def late(seconds: float, tick: float) -> Steering:
    """A dead time."""
    waiting = deque([0.0] * round(seconds / tick))

    def answer(angle: float, command: float, t: float) -> float:
        waiting.append(command)
        return waiting.popleft()

    return answer


def true_sensor(angle: float, t: float) -> float:
    """The angle of the wheels."""
    return angle


def reads(gain: float, off: float = 0.0) -> Sensor:
    """A sensor with a gain and an offset (rad)."""
    return lambda angle, t: gain * angle + off


def obeys(gain: float, off: float = 0.0) -> Steering:
    """Wheels with a gain and an offset (rad)."""
    return lambda angle, command, t: gain * command + off


def stuck() -> Sensor:
    """A sensor that stops moving at FAILS."""
    last = [0.0]

    def sensor(angle: float, t: float) -> float:
        last[0] = angle if t < FAILS else last[0]
        return last[0]

    return sensor


def cases(tick: float) -> Iterator[tuple[str, Steering, Sensor | None]]:
    """(what it is, steering, sensor or None for none; the lag is declared where that says so)."""
    yield "as commanded", exact, true_sensor
    yield "as commanded, no sensor", exact, None
    for seconds in (0.05, 0.1, 0.2, 0.4):
        yield f"lag {seconds:g} s", lagging(seconds, tick), true_sensor
    yield "lag 0.2 s, no sensor", lagging(0.2, tick), None
    yield f"lag 0.2 s, no sensor, {DECLARED}", lagging(0.2, tick), None
    yield "dead time 0.1 s", late(0.1, tick), true_sensor
    for rate in (0.5, 0.25):
        yield f"{rate:g} rad/s at most", slow(rate, tick), true_sensor
    for off in (0.02, 0.05):
        yield f"sensor {off:g} rad off", exact, reads(1.0, off)
        yield f"wheels {off:g} rad off", obeys(1.0, -off), true_sensor
    yield "sensor reads 0.8 of it", exact, reads(0.8)
    yield "wheels do 0.8 of it", obeys(0.8), true_sensor
    yield "lock at 0.1 rad", lambda angle, command, t: float(np.clip(command, -0.1, 0.1)), true_sensor
    yield "sensor stuck", exact, stuck()
    yield "sensor with a value lost and a wild one each second", exact, lambda angle, t: (
        np.nan if 0.5 < t % 1.0 < 0.6 else 1.2 if 0.8 < t % 1.0 < 0.8 + tick else angle
    )
    yield "wheels stuck", lambda angle, command, t: command if t < FAILS else angle, true_sensor


class Vehicle:
    """The controller's model with a steering and a sensor of its own."""

    def __init__(self, ocp: Ocp, steering: Steering, sensor: Sensor | None, seed: int) -> None:
        self.ocp, self.steering, self.sensor, self.t = ocp, steering, sensor, 0.0
        self.rates, self.z = ocp.dynamics(), ocp.z.pack(u=5.0)
        self.rng = np.random.default_rng(seed)

    def measure(self) -> dict[str, float]:
        """What the sensors read."""
        read = {name: self.z[i] + GOOD[name] * self.rng.standard_normal() for i, name in enumerate(NAMES)}
        if self.sensor is not None:
            read["steer"] = self.sensor(self.z[-1], self.t) + GOOD["steer"] * self.rng.standard_normal()
        return read

    def apply(self, command: DriverCommand, seconds: float) -> None:
        """A tick on; below 1 m/s it rolls where its wheels point, and brakes hold it."""
        angle = self.steering(float(self.z[-1]), command.steer, self.t)
        w = np.array([(angle - self.z[-1]) / seconds, command.a_asked])
        rates = np.array(self.rates(self.z, w, np.zeros(len(self.ocp.r)), self.ocp.s.nominal)[0]).ravel()
        if self.z[3] > 1.0:
            self.z = self.z + seconds * rates
        else:
            u = max(self.z[3] + seconds * command.a_asked, 0.0)
            along = seconds * u * np.array([np.cos(self.z[2]), np.sin(self.z[2])])
            yaw_rate = u * np.tan(angle) / (self.ocp.vehicle.l_f + self.ocp.vehicle.l_r)
            self.z = np.array([*(self.z[:2] + along), self.z[2] + seconds * yaw_rate, u, 0.0, yaw_rate, angle])
        self.t += seconds


def row(name: str, log: DriveLog) -> str:
    """A line of the table."""
    left, last = log.column("left"), log.commands[-1]
    why = last.status.name if last.halt else ""
    ended = "finished" if last.finished else f"halted at {last.t:.1f} s" if last.stopped else "not finished"
    return f"{name:52s} {ended:18s} {np.sqrt(np.mean(left**2)):6.2f} {np.abs(left).max():6.2f} {last.actuator_lag:6.2f}  {why}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speed", type=float, default=6.0, help="m/s, default %(default)s")
    parser.add_argument("--soil", default="clay", choices=sorted(SOILS), help="default %(default)s")
    given = parser.parse_args()
    vehicle = load_vehicle(VEHICLE).with_(simulator={})  # its options ask for more than two nodes
    ocp = Ocp(nominal_bicycle(vehicle, SOILS[given.soil], TurnSlip(front_nodes=2)), vehicle)
    settings = DriverSettings(sensor_std=tuple(GOOD[name] for name in NAMES))
    solver, estimator = Nmpc(ocp), LiveEstimator(ocp.model, settings.sensor_std, tick=settings.tick)
    print(f"{'steering':52s} {'drive':18s} {'rms m':>6s} {'worst':>6s} {'lag s':>6s}")
    for name, steering, sensor in cases(settings.tick):
        path = double_lane_change()
        known = replace(settings, actuator_lag=0.2) if DECLARED in name else settings
        driver = Driver(ocp, path, given.speed, settings=known, solver=solver, estimator=estimator)
        print(row(name, drive(driver, Vehicle(ocp, steering, sensor, 1), 40.0)), flush=True)


if __name__ == "__main__":
    main()
