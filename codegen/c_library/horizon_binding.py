"""The moving horizon of a generated library called from Python."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.c_library.binding import CFilter, CLibrary
from softsoil.codegen.c_library.statuses import STATUSES

Array = NDArray[np.float64]


class CHorizon:
    """One moving horizon: softsoil_horizon_t in memory of Python's.

    library: a generated one; t: time of the first sample (s). `options` holds the declared numbers, to be changed before
    `start`; `head` has the fields of softsoil_horizon_t up to its options. Raises ValueError for options out of their range.
    """

    def __init__(self, library: CLibrary, t: float = 0.0) -> None:
        self.library, self.c = library, library.c
        self.names: list[str] = library.formulation["promoted"]
        self.words: list[str] = library.formulation["verdicts"]
        self.Options, Head = _structures(library.sizes, len(self.names))
        self.c.softsoil_horizon_size.restype = ctypes.c_size_t
        size = int(self.c.softsoil_horizon_size())
        if size < ctypes.sizeof(Head):
            raise ValueError(f"C library: expected a horizon of at least {ctypes.sizeof(Head)} bytes, found {size}")
        self._memory = bytearray(size)
        self.head: Any = Head.from_buffer(self._memory)
        self.options: Any = self.Options()
        self._self = ctypes.byref(self.head)
        self.c.softsoil_horizon_defaults(ctypes.byref(self.options))
        self.start(t)

    def start(self, t: float) -> None:
        """Start, or start again, at time t (s) with `options`."""
        status = int(self.c.softsoil_horizon_init(self._self, ctypes.byref(self.options), ctypes.c_double(t)))
        if status:
            raise ValueError(f"C library: horizon: {self.c.softsoil_status_text(status).decode()}")

    def push(self, u: ArrayLike, y: ArrayLike, t: float) -> int:
        """One sample: inputs u (n_u,) and measurements y (n_y,), NaN where missing, at t (s); returns the status."""
        u, y = (np.ascontiguousarray(a, dtype=float) for a in (u, y))
        return int(self.c.softsoil_horizon_push(self._self, _pointer(u), _pointer(y), None, ctypes.c_double(t)))

    def update(self) -> bool:
        """Take in the next window where one is complete; returns whether there was one."""
        self.c.softsoil_horizon_update(self._self)
        return bool(self.head.updated)

    def saved(self) -> bytes:
        """The whole structure, for `restore`."""
        return bytes(self._memory)

    def restore(self, saved: bytes) -> None:
        """Go on from where it was `saved`."""
        self._memory[:] = saved

    @property
    def n(self) -> Array:
        """(A,) estimate."""
        return np.array(self.head.n)

    @property
    def std(self) -> Array:
        """(A,) its standard deviation."""
        return np.array(self.head.std)

    def correct(self, own: CFilter) -> bool:
        """Put the estimate in the place of a filter's where the verdict allows it and they differ; returns whether they did."""
        return bool(self.c.softsoil_horizon_correct(self._self, ctypes.byref(own.state)))

    @property
    def verdict(self) -> str:
        """Whether the estimate may be used: "identified", or why not."""
        return self.words[self.head.verdict]

    @property
    def counts(self) -> dict[str, int]:
        """How often each status has been met, where it has."""
        return {name: n for (name, _), n in zip(STATUSES, self.head.counts, strict=True) if n}


def _structures(sizes: dict[str, int], k: int) -> tuple[type[ctypes.Structure], type[ctypes.Structure]]:
    """softsoil_horizon_options_t, and softsoil_horizon_t up to its options, field by field as in softsoil_horizon.h."""
    p, y = sizes["p"], sizes["y"]
    real, natural, whole = ctypes.c_double, ctypes.c_uint32, ctypes.c_int32

    class Options(ctypes.Structure):
        """softsoil_horizon_options_t."""

        _fields_ = [
            ("p", real * p), ("r_std", real * y), ("model_error", real * y), ("guess", real * k), ("guess_std", real * k),
            ("dt", real), ("start_up", real), ("look", whole),
        ]  # fmt: skip

    class Head(ctypes.Structure):
        """softsoil_horizon_t up to its options."""

        _fields_ = [
            ("magic", natural), ("counts", natural * len(STATUSES)), ("verdict", whole), ("changes", whole), ("windows", whole),
            ("updated", whole), ("vehicle", whole), ("t", real), ("changed_at", real), ("n", real * k), ("std", real * k),
            ("information_std", real * k), ("law_std", real * k), ("free_n", real * k), ("unexplained", real * 2),
            ("unexplained_std", real * 2), ("inertia", real), ("inertia_std", real), ("parts", real * 2), ("parts_sigmas", real),
            ("motion", real), ("cost", real), ("options", Options),
        ]  # fmt: skip

    return Options, Head


def _pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)
