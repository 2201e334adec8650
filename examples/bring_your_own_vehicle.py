"""Drive a vehicle that lives in another process: it speaks lines of JSON on standard input and output.

    python examples/bring_your_own_vehicle.py                       # the small vehicle at the end of this file
    python examples/bring_your_own_vehicle.py -- ./my_simulator     # or yours

The protocol: the vehicle writes one line with its measurements (names and units of `softsoil.control.driver_types.Measured`),
reads one line with a command {"steer", "steer_rate", "speed", "a_x", "seconds"}, carries it out for so many seconds, and
writes its next measurements. An empty line ends the drive.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys

SPEED = 6.0


def main(command: list[str], driver=None) -> int:
    """Drive the process `command` along a double lane change; 0 where it came to the end of it. driver: another than ours."""
    from softsoil.control.drive_loop import drive

    driver = driver or our_driver()
    with LineVehicle(command) as vehicle:
        log = drive(driver, vehicle, seconds=40.0)
    if log.error is not None:
        print(f"the vehicle stopped answering after {len(log.commands)} ticks: {log.error}", file=sys.stderr)
    if not log.commands:
        return 1
    last = log.commands[-1]
    left = [abs(command.left) for command in log.commands if command.along > 45.0]
    print(f"{last.t:.1f} s, {last.along:.1f} m along the path, at most {max(left, default=math.nan):.2f} m off it")
    print(f"n: {last.verdict}; estimate {last.n:.2f} ± {last.n_std:.2f}; {log.failures} solves failed")
    return 0 if last.finished else 1


def our_driver():
    """A driver that takes the vehicle for the reference vehicle on clay, and n for 0.7 at first."""
    from softsoil.control.courses import double_lane_change
    from softsoil.control.driver import Driver
    from softsoil.control.driver_types import DriverSettings
    from softsoil.declaration.model_file import Declaration
    from softsoil.files.package_data import REFERENCE_VEHICLE
    from softsoil.symbolic.soil import CLAY
    from softsoil.symbolic.vehicle import load_vehicle

    declared = Declaration(load_vehicle(REFERENCE_VEHICLE), CLAY)
    sensors = DriverSettings(sensor_std=(0.05, 0.05, 0.003, 0.05, 0.05, 0.005))
    return Driver(declared, double_lane_change(), SPEED, n0=0.7, settings=sensors)


class LineVehicle:
    """The process on the other side of the lines."""

    def __init__(self, command: list[str]) -> None:
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def measure(self) -> dict[str, float]:
        """The next line of the process; RuntimeError where there is none."""
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"expected a line of measurements, found the end of the output of {self.process.args}")
        return json.loads(line)

    def apply(self, command, seconds: float) -> None:
        """One line with the command."""
        asked = {
            "steer": command.steer,
            "steer_rate": command.steer_rate,
            "speed": command.speed,
            "a_x": command.a_asked,
        }
        print(json.dumps({**asked, "seconds": seconds}), file=self.process.stdin, flush=True)

    def __enter__(self) -> LineVehicle:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.stdin.close()
        try:
            self.process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()


def vehicle() -> None:
    """A small vehicle with numbers and equations of its own: soft tyres, a slow steering, accelerations with a lag."""
    mass, inertia, front, rear, radius = 2100.0, 2300.0, 1.35, 1.45, 0.47
    x, y, psi, u, v, omega, steer, a = 0.0, 0.3, 0.0, 5.5, 0.0, 0.0, 0.0, 0.0
    while True:
        ahead = v + front * omega
        spin = u / radius / 0.96
        measured = {"x": x, "y": y, "psi": psi, "u": u, "v": v, "omega_z": omega, "a_x_imu": a - v * omega}
        print(json.dumps(measured | {f"omega_{wheel}": spin for wheel in ("fl", "fr", "rl", "rr")}), flush=True)
        line = sys.stdin.readline()
        if not line.strip():
            return
        asked = json.loads(line)
        steps = 12
        h = asked["seconds"] / steps
        for _ in range(steps):
            steer += h / 0.05 * (asked["steer"] - steer)
            a += h / 0.1 * (asked["a_x"] - a)
            ahead = v + front * omega
            force_front = -7000.0 * math.tanh((math.atan2(ahead, u) - steer) / 0.18)
            force_rear = -7000.0 * math.tanh(math.atan2(v - rear * omega, u) / 0.16)
            x += h * (u * math.cos(psi) - ahead * math.sin(psi))
            y += h * (u * math.sin(psi) + ahead * math.cos(psi))
            psi, u = psi + h * omega, max(u + h * a, 0.0)
            v += h * ((force_front * math.cos(steer) + force_rear) / mass - u * omega)
            omega += h * (front * force_front * math.cos(steer) - rear * force_rear) / inertia


if __name__ == "__main__":
    if sys.argv[1:] == ["vehicle"]:
        vehicle()
    else:
        given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
        raise SystemExit(main(given or [sys.executable, __file__, "vehicle"]))
