"""A small vehicle that a driver drives: the controller's own model, and what is compiled once for all its drives."""

from functools import lru_cache

import numpy as np

from nmpc_problem import small_ocp
from softsoil.control.courses import straight
from softsoil.control.drive_loop import DriveLog, drive
from softsoil.control.driver import Driver
from softsoil.control.driver_types import DriverCommand, DriverSettings
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.nmpc import Nmpc
from softsoil.control.path import Path

SENSORS = DriverSettings(sensor_std=(0.05, 0.05, 0.003, 0.05, 0.05, 0.005))
NAMES = ("x", "y", "psi", "u", "v", "omega_z")


class ModelVehicle:
    """A vehicle that obeys the controller's own model at once, and measures only what `keep` lets through."""

    def __init__(self, keep=lambda k, name: True, y: float = 0.4, raises: int | None = None) -> None:
        self.ocp, self.keep, self.raises, self.k = small_ocp(), keep, raises, 0
        self.rates, self.z = self.ocp.dynamics(), self.ocp.z.pack(u=5.0, y=y)

    def measure(self) -> dict[str, float]:
        if self.k == self.raises:
            raise OSError("the line is dead")
        return {name: float(self.z[i]) for i, name in enumerate(NAMES) if self.keep(self.k, name)}

    def apply(self, command: DriverCommand, seconds: float) -> None:
        w = np.array([(command.steer - self.z[-1]) / seconds, command.a_asked])
        rates = np.array(self.rates(self.z, w, np.zeros(len(self.ocp.r)), self.ocp.s.nominal)[0]).ravel()
        self.z, self.k = self.z + seconds * rates, self.k + 1


class Braked(ModelVehicle):
    """A vehicle whose brakes hold it where it stands, and which rolls where its wheels point while it is slow."""

    def apply(self, command: DriverCommand, seconds: float) -> None:
        if self.z[3] > 1.0:
            super().apply(command, seconds)
            return
        u = max(self.z[3] + seconds * command.a_asked, 0.0)
        yaw_rate = u * np.tan(command.steer) / (self.ocp.vehicle.l_f + self.ocp.vehicle.l_r)
        self.z[2:] = [self.z[2] + seconds * yaw_rate, u, 0.0, yaw_rate, command.steer]
        self.z[:2] += seconds * self.z[3] * np.array([np.cos(self.z[2]), np.sin(self.z[2])])
        self.k += 1


@lru_cache(maxsize=1)
def parts() -> tuple[Nmpc, LiveEstimator]:
    """Compiled once for all drives."""
    return Nmpc(small_ocp()), LiveEstimator(small_ocp().model, SENSORS.sensor_std)


def driven(vehicle: ModelVehicle, seconds: float = 8.0, **more) -> tuple[Driver, DriveLog]:
    solver, estimator = parts()
    path = Path(straight().points[: int(40 / 0.25)])
    given = {"path": path, "settings": SENSORS, "solver": solver, "estimator": estimator, "n0": 0.7, **more}
    driver = Driver(small_ocp(), speed=5.0, **given)
    return driver, drive(driver, vehicle, seconds)
