"""A driver and a vehicle in a loop, with a log that survives what the vehicle does."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from softsoil.control.driver import Driver
from softsoil.control.driver_types import DrivenVehicle, DriverCommand

Array = NDArray[np.float64]


@dataclass
class DriveLog:
    """commands: of every tick; error: what the vehicle raised, None where it did not."""

    commands: list[DriverCommand] = field(default_factory=list)
    error: Exception | None = None

    def column(self, name: str) -> Array:
        """(K, ...) of the named quantity of the commands."""
        return np.array([getattr(command, name) for command in self.commands])

    @property
    def failures(self) -> int:
        """Solves whose plan could not be used."""
        return sum(command.solved and not command.status.usable for command in self.commands)


def drive(driver: Driver, vehicle: DrivenVehicle, seconds: float, log: DriveLog | None = None) -> DriveLog:
    """Drive until the path is done, the vehicle has stopped or raised, or `seconds` (s) are over.

    log: to be written to; what the vehicle raises ends the drive and stands in `log.error`.
    """
    log = DriveLog() if log is None else log
    tick = driver.settings.tick
    for k in range(round(seconds / tick)):
        try:
            command = driver.tick(k * tick, vehicle.measure())
            log.commands.append(command)
            if command.finished or command.stopped:
                break
            vehicle.apply(command, tick)
        except (OSError, RuntimeError, ArithmeticError, LookupError, ValueError) as error:
            log.error = error
            break
    return log
