"""Steering map: from what a steering is commanded, or a steering wheel's angle, to the mean angle of the steered wheels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.files.toml_file import finite, toml_number

KEYS = ("command", "angle")


@dataclass(frozen=True)
class SteeringMap:
    """Pairs with straight lines between them, and the end pairs' angles beyond.

    command (K,): increasing, in the unit that logs and actuators hold it in; angle (K,): mean road-wheel angle (rad, positive to
    the left), increasing or decreasing with the command. Raises ValueError for fewer than two pairs, or values in no order.
    Example: SteeringMap((-1.0, 1.0), (-0.4, 0.4)).command_of(0.1) == 0.25
    """

    command: tuple[float, ...]
    angle: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.command) < 2 or len(self.command) != len(self.angle):
            counts = f"{len(self.command)} commands and {len(self.angle)} angles"
            raise ValueError(f"steering: expected two pairs of command and angle or more, found {counts}")
        if not all(np.isfinite([*self.command, *self.angle])) or np.any(np.diff(self.command) <= 0):
            raise ValueError(f"steering: expected increasing finite commands, found {list(self.command)}")
        steps = np.diff(self.angle)
        if not (np.all(steps > 0) or np.all(steps < 0)):
            raise ValueError(f"steering: expected angles that grow, or fall, with the command, found {list(self.angle)}")

    def angle_of(self, command: ArrayLike) -> NDArray[np.float64]:
        """Mean road-wheel angle (rad) of a command, or of each of an array (N,)."""
        return np.asarray(np.interp(np.asarray(command, dtype=float), self.command, self.angle))

    def command_of(self, angle: ArrayLike) -> NDArray[np.float64]:
        """Command of a mean road-wheel angle (rad), or of each of an array (N,); the end one beyond the map's angles."""
        order = slice(None) if self.angle[-1] > self.angle[0] else slice(None, None, -1)
        return np.asarray(np.interp(np.asarray(angle, dtype=float), self.angle[order], self.command[order]))

    @property
    def pairs(self) -> tuple[tuple[float, float], ...]:
        """(command, angle) pairs."""
        return tuple(zip(self.command, self.angle, strict=True))

    def toml(self, table: str = "steering") -> list[str]:
        """Lines of the table called `table` in a vehicle file."""
        rows = (f"{key} = [{', '.join(toml_number(value) for value in getattr(self, key))}]" for key in KEYS)
        return [f"[{table}]", *rows]


def steering_from_table(value: Any, where: str) -> SteeringMap | None:
    """The map in a parsed table `steering`, None for an empty one; ValueError naming `where`, the key and what was found."""
    if not isinstance(value, Mapping) or (value and sorted(value) != sorted(KEYS)):
        raise ValueError(f"{where}: steering: expected a table with lists command and angle (rad), found {value!r}")
    lists = []
    for key in KEYS if value else ():
        if not isinstance(value[key], list):
            raise ValueError(f"{where}: steering.{key}: expected a list of numbers, found {value[key]!r}")
        lists.append(tuple(finite(one, f"{where}: steering.{key}") for one in value[key]))
    try:
        return SteeringMap(*lists) if lists else None
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
