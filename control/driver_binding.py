"""The driver in C, compiled and called from Python."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.compiled import FLAGS, build_library
from softsoil.control.c_controller import sources
from softsoil.control.driver_checks import check_names
from softsoil.control.driver_types import MEASUREMENTS, Measured
from softsoil.control.nmpc_binding import ALIGNMENT, REFUSED
from softsoil.control.path import Path

Array = NDArray[np.float64]
_REAL, _WHOLE = ctypes.c_double, ctypes.c_int32


class CPath(ctypes.Structure):
    """softsoil_nmpc_path_t."""

    _fields_ = [("n", ctypes.c_size_t)] + [(name, ctypes.c_void_p) for name in ("x", "y", "s", "psi")]


class Task(ctypes.Structure):
    """softsoil_driver_task_t."""

    _fields_ = [
        ("path", CPath), ("speed", _REAL), ("obstacles", ctypes.c_void_p), ("obstacle_count", ctypes.c_size_t), ("n0", _REAL),
        ("learn", _WHOLE), ("known", _WHOLE), ("start", _REAL * 6),
    ]  # fmt: skip


def command_type(states: int) -> Any:
    """softsoil_driver_command_t of a controller with so many states."""
    reals = (
        "steer", "steer_rate", "speed", "a_x", "a_asked", "n", "n_std", "n_used", "slip", "resistance", "along", "left",
        "position_std", "dead_reckoned", "actuator_lag",
    )  # fmt: skip
    flags = ("status", "filter_status", "disagreement", "lost", "halt", "finished", "stopped", "started", "solved")

    class Command(ctypes.Structure):
        """softsoil_driver_command_t."""

        _fields_ = [*[(name, _REAL) for name in reals], ("z", _REAL * states), *[(name, _WHOLE) for name in flags]]

    return Command


class CDriver:
    """One driver: softsoil_driver_t in memory of Python's.

    texts: files of a folder (`controller_texts`); states: n_z of the controller; flags: of the compiler. Raises ValueError where
    there is no compiler or it refuses.
    """

    def __init__(self, texts: Mapping[str, str], states: int, flags: Sequence[str] = FLAGS) -> None:
        own = {name: text for name, text in texts.items() if name.startswith(("include/", "src/"))}
        library = build_library("driver", sources(own), flags)
        if library is None:
            raise ValueError("driver: expected a C compiler ($CC, cc, gcc or clang) that takes the generated files, found none")
        self.c = ctypes.CDLL(str(library))
        self.c.softsoil_driver_size.restype = ctypes.c_size_t
        self.c.softsoil_nmpc_status_text.restype = self.c.softsoil_driver_fault.restype = ctypes.c_char_p
        self._memory = bytearray(int(self.c.softsoil_driver_size()) + ALIGNMENT)
        first = ctypes.c_char.from_buffer(self._memory)
        self.self = ctypes.c_void_p(ctypes.addressof(first) + (-ctypes.addressof(first) % ALIGNMENT))
        self.command = command_type(states)()
        self._kept: list[Array] = []
        self._given = np.full(len(MEASUREMENTS), np.nan)

    def start(
        self, path: Path, speed: float, obstacles: ArrayLike = (), n0: float = 0.7, learn: bool = True,
        start: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        """Begin a drive: see `softsoil.control.driver.Driver` for path, speed (m/s), obstacles (K, 5), n0, learn and start (6,).

        Raises ValueError where the library refuses them, with what it says of them.
        """
        columns = [np.ascontiguousarray(path.points[:, i], dtype=float) for i in (0, 1)]
        columns += [np.zeros(len(path.points)) for _ in range(2)]
        places = np.ascontiguousarray(obstacles, dtype=float).reshape(-1, 5)
        self._kept = [*columns, places]
        task = Task(
            CPath(len(path.points), *[column.ctypes.data for column in columns]), speed, places.ctypes.data, len(places), n0,
            int(learn), int(start is not None),
        )  # fmt: skip
        if start is not None:
            task.start[:] = [float(value) for value in np.asarray(start)]
        self._check("path", self.c.softsoil_nmpc_path(ctypes.byref(task.path)))
        fault = self.c.softsoil_driver_fault(None, ctypes.byref(task))
        if fault is not None:
            raise ValueError(f"{fault.decode()}; found speed {speed}, n0 {n0}, start {start!r}, obstacles {places.tolist()}")
        self._check("init", self.c.softsoil_driver_init(self.self, None, ctypes.byref(task)))

    def tick(self, t: float, measured: Measured) -> Any:
        """The command from t (s) on, from what was measured at t; the same structure at every tick; ValueError as of `Driver`."""
        self.take(measured)
        return self.tick_held(t)

    def judge(self, identified: bool, n: float = 0.0, n_std: float = 0.0) -> None:
        """Hand over a judge's verdict, whether n is identified, its n and n_std; ValueError for an n out of bounds."""
        self._check("judge", self.c.softsoil_driver_judge(self.self, int(identified), _REAL(n), _REAL(n_std)))

    def take(self, measured: Measured) -> None:
        """Measurements for the next `tick_held`; ValueError for a name that is not among `MEASUREMENTS`."""
        check_names(measured, MEASUREMENTS)
        self._given[:] = [measured.get(name, np.nan) for name in MEASUREMENTS]

    def tick_held(self, t: float) -> Any:
        """The command from t (s) on, from the measurements taken last: the thinnest call."""
        pointer = ctypes.c_void_p(self._given.ctypes.data)
        status = self.c.softsoil_driver_tick(self.self, _REAL(t), pointer, ctypes.byref(self.command))
        last = "not before the last tick's unless the clock is set back"
        self._check("tick", status, f"; expected a finite t, {last}, found {t} s")
        return self.command

    def _check(self, call: str, status: int, more: str = "") -> None:
        if status >= REFUSED:
            raise ValueError(f"softsoil_driver_{call}: {self.c.softsoil_nmpc_status_text(status).decode()}{more}")
