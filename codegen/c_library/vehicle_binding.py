"""The look at the vehicle of a generated library called from Python."""

from __future__ import annotations

import ctypes
from typing import Any

from softsoil.codegen.c_library.binding import CLibrary
from softsoil.codegen.c_library.horizon_binding import CHorizon

CHANGES = ("not_looked_at", "unknown", "same", "strained", "other_mass", "other_steering")
"""enum softsoil_vehicle_change, as words."""


class Head(ctypes.Structure):
    """softsoil_vehicle_t up to its results."""

    _fields_ = [
        ("magic", ctypes.c_uint32), ("change", ctypes.c_int32), ("windows", ctypes.c_int32), ("next", ctypes.c_int32),
        ("strain", ctypes.c_double), ("load", ctypes.c_double), ("load_std", ctypes.c_double),
        ("steering", ctypes.c_double), ("steering_std", ctypes.c_double),
    ]  # fmt: skip


class CVehicle:
    """One look at the vehicle beside a horizon: softsoil_vehicle_t in memory of Python's.

    horizon: of the same library. `head` has the fields of softsoil_vehicle_t up to its results.
    Raises ValueError for a library of a vehicle whose file states no errors of its numbers.
    """

    def __init__(self, horizon: CHorizon) -> None:
        if not looks_at_vehicle(horizon.library):
            raise ValueError(
                "C library: expected behind it a vehicle's file with [joint_error], or [uncertainty] of its numbers; found none"
            )
        self.horizon, self.c = horizon, horizon.c
        self.c.softsoil_vehicle_size.restype = ctypes.c_size_t
        self._memory = bytearray(int(self.c.softsoil_vehicle_size()))
        self.head: Any = Head.from_buffer(self._memory)
        self.start()

    def start(self) -> None:
        """Start, or start again, with the horizon."""
        self.c.softsoil_vehicle_init(ctypes.byref(self.head))

    def update(self) -> bool:
        """The next part of the work; returns whether a window has been taken in."""
        return bool(self.c.softsoil_vehicle_update(ctypes.byref(self.head), ctypes.byref(self.horizon.head)) == 1)

    @property
    def change(self) -> str:
        """Whether the vehicle has changed, one of CHANGES."""
        return CHANGES[self.head.change]


def looks_at_vehicle(library: CLibrary) -> bool:
    """Whether the library can look at its vehicle."""
    return hasattr(library.c, "softsoil_vehicle_update")
