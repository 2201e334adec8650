"""The controller in C, compiled and called from Python."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.compiled import FLAGS, build_library, find_compiler
from softsoil.control.c_controller import sources
from softsoil.control.c_statuses import STATUSES
from softsoil.control.ocp import Ocp

Array = NDArray[np.float64]
ALIGNMENT = 64
"""Bytes: the widest vector."""


def _head(ocp: Ocp) -> tuple[type[ctypes.Structure], type[ctypes.Structure]]:
    """softsoil_nmpc_options_t, and softsoil_nmpc_t up to its options, field by field as in softsoil_nmpc.h."""
    n, nz, nw, nr = ocp.settings.steps, len(ocp.z), len(ocp.w), max(len(ocp.r), 1)
    limited, obstacles, wide = len(ocp.state_box) + nw, max(ocp.settings.obstacles, 1), (nz + 3) // 4 * 4
    real, natural, whole = ctypes.c_double, ctypes.c_uint32, ctypes.c_int32

    class Options(ctypes.Structure):
        """softsoil_nmpc_options_t."""

        _fields_ = [
            ("limits", real * 2 * limited), ("slack", real), ("slack_squared", real), ("tolerance", real), ("patience", real),
            ("straighten", real), ("slowing", real), ("braking", real), ("stopping", real), ("converge", whole), ("most", whole),
        ]  # fmt: skip

    class Head(ctypes.Structure):
        """softsoil_nmpc_t."""

        _fields_ = [
            ("magic", natural), ("counts", natural * len(STATUSES)), ("status", whole), ("iterations", whole),
            ("qp_iterations", whole), ("touch", whole), ("prepared", whole), ("warm", whole), ("halting", whole),
            ("reserved", whole), ("cost", real), ("defect", real), ("step", real), ("gap", real), ("age", real),
            ("pending", real), ("z", real * nz * (n + 1)), ("w", real * nw * (n + 1)), ("pi", real * wide * (n + 1)),
            ("end", real * nz * n), ("s", real * len(ocp.s)), ("r", real * nr * n), ("ref", real * 4 * (n + 1)),
            ("obstacles", real * 3 * obstacles * (n + 1)), ("plan_steer", real * (n + 1)), ("plan_u", real * (n + 1)),
            ("plan_a", real * n), ("options", Options),
        ]  # fmt: skip

    return Options, Head


class Command(ctypes.Structure):
    """softsoil_nmpc_command_t."""

    _fields_ = [
        ("steer", ctypes.c_double), ("steer_rate", ctypes.c_double), ("speed", ctypes.c_double), ("a_x", ctypes.c_double),
        ("lost", ctypes.c_int32), ("halt", ctypes.c_int32),
    ]  # fmt: skip


class CController:
    """One controller: softsoil_nmpc_t in memory of Python's.

    ocp: the problem; texts: its files (`controller_files`); flags: of the compiler. `head` has the fields of
    softsoil_nmpc_t up to its options. Raises ValueError where there is no compiler, or it refuses, or where the structure
    has another size than its header says.
    """

    def __init__(self, ocp: Ocp, texts: Mapping[str, str], flags: Sequence[str] = FLAGS) -> None:
        if find_compiler() is None:
            raise ValueError("nmpc: expected a C compiler ($CC, cc, gcc or clang), found none")
        path = build_library("nmpc", sources(texts), flags)
        if path is None:
            raise ValueError(f"nmpc: expected a C compiler that takes the controller, found {find_compiler()}")
        self.c = ctypes.CDLL(str(path))
        self.c.softsoil_nmpc_size.restype = ctypes.c_size_t
        self.c.softsoil_nmpc_status_text.restype = ctypes.c_char_p
        self.Options, head = _head(ocp)
        size = int(self.c.softsoil_nmpc_size())
        if size < ctypes.sizeof(head):
            raise ValueError(f"nmpc: expected a structure of at least {ctypes.sizeof(head)} bytes, found {size}")
        self._memory = bytearray(size + ALIGNMENT)
        start = -ctypes.addressof(ctypes.c_char.from_buffer(self._memory)) % ALIGNMENT
        self.head: Any = head.from_buffer(self._memory, start)
        self.self = ctypes.byref(self.head)

    def copy(self, other: CController) -> None:
        """Take over the whole memory of a controller of the same problem; ValueError where it has another size."""
        size = int(self.c.softsoil_nmpc_size())
        if size != int(other.c.softsoil_nmpc_size()):
            raise ValueError(f"nmpc: expected a controller of {size} bytes, found {other.c.softsoil_nmpc_size()}")
        ctypes.memmove(self.self, other.self, size)

    def view(self, name: str) -> Array:
        """The array `name` of the structure, in its own memory."""
        return np.ctypeslib.as_array(getattr(self.head, name))

    def call(self, name: str, *arguments: Any) -> int:
        """softsoil_nmpc_<name> with arrays as pointers; returns the status. ValueError where the call was refused."""
        given = [_pointer(a) if isinstance(a, np.ndarray) else a for a in arguments]
        status = int(getattr(self.c, f"softsoil_nmpc_{name}")(self.self, *given))
        if status >= REFUSED:
            raise ValueError(f"softsoil_nmpc_{name}: {self.c.softsoil_nmpc_status_text(status).decode()}")
        return status


REFUSED = next(value for value, (name, _) in enumerate(STATUSES) if name == "BAD_ARGUMENT")
"""From this status on a call did nothing."""


def _pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    # data_as, unlike data, keeps the array alive for as long as the pointer.
    return array.ctypes.data_as(ctypes.c_void_p)
