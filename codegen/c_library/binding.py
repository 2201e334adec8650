"""The functions of a generated library called from Python, with as little between as there can be."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.c_library.build import FLAGS, build_c_library
from softsoil.codegen.c_library.statuses import STATUSES

Array = NDArray[np.float64]


def _structures(sizes: Mapping[str, int]) -> tuple[type[ctypes.Structure], type[ctypes.Structure]]:
    """softsoil_options_t and softsoil_t, field by field as in softsoil.h."""
    x, u, p, y, m, full, n = (sizes[name] for name in ("x", "u", "p", "y", "m", "u_full", "soil"))
    real, natural, whole = ctypes.c_double, ctypes.c_uint32, ctypes.c_int32

    class Options(ctypes.Structure):
        """softsoil_options_t."""

        _fields_ = [
            ("p", real * p), ("q_std", real * x), ("r_std", real * y), ("gate", real), ("standstill_speed", real),
            ("max_std", real * x), ("gate_patience", whole), ("gate_patience_rates", whole), ("miss_std", real * y),
            ("kick_std", real * x), ("fastest", real), ("run_in", real), ("common_error", real), ("change_after", real),
            ("change_sigmas", real), ("change_std", real), ("change_error", real),
        ]  # fmt: skip

    class Filter(ctypes.Structure):
        """softsoil_t."""

        _fields_ = [
            ("magic", natural), ("counts", natural * len(STATUSES)), ("predictions", natural), ("updates", natural),
            ("standstill", whole), ("reversing", whole), ("started", whole), ("flags", natural), ("n_past", whole),
            ("next_past", whole), ("gated_run", whole * y), ("t", real),
            ("last_dt", real), ("x", real * x), ("std", real * x), ("innovation", real * y), ("innovation_std", real * y),
            ("nis", real), ("consistency", real), ("soil_consistency", real), ("used", whole * y), ("dof", whole),
            ("since", whole), ("root", real * (x * x)), ("m", real * max(m, 1)), ("u", real * u), ("u_full", real * full),
            ("t_y", real * y), ("keep_at", real), ("past_score", real * sizes["past"] * n),
            ("past_information", real * sizes["past"] * n),
            ("trial_t", real), ("trial_n", real * n), ("trial_variance", real * n), ("missing", real),
            ("drift", real), ("drift_channel", whole), ("unused", whole), ("run_in_to", real), ("drift_t", real),
            ("drift_from", real), ("drift_sum", real * 2 * sizes["drift"]), ("options", Options),
        ]  # fmt: skip

    return Options, Filter


class CLibrary:
    """The functions of one generated folder.

    folder: as written by `softsoil generate`; flags, compiler: of the build. Raises ValueError where it cannot be built,
    or where the structure has another size than its header says.
    """

    def __init__(self, folder: str | Path, flags: Sequence[str] = FLAGS, compiler: str | None = None) -> None:
        self.formulation: dict[str, Any] = json.loads((Path(folder) / "formulation.json").read_text(encoding="utf-8"))
        self.path = build_c_library(folder, flags, compiler)
        self.c = ctypes.CDLL(str(self.path))
        self.names = {key: [s["name"] for s in self.formulation[key]] for key in _LISTS}
        sizes = {short: len(self.names[key]) for key, short in _LISTS.items()}
        sizes["m"] = int(self.formulation["memory_cells"])
        sizes["soil"], sizes["past"] = len(self.formulation["soil_states"]), int(self.formulation["past_values"])
        sizes["drift"] = len(self.formulation["drift_channels"])
        sizes["u_full"] = sizes["u"] + int(self.formulation["provided_inputs"])
        self.sizes = sizes
        self.Options, self.Filter = _structures(sizes)
        self.c.softsoil_size.restype = ctypes.c_size_t
        if self.c.softsoil_size() != ctypes.sizeof(self.Filter):
            raise ValueError(
                f"C library: expected a structure of {ctypes.sizeof(self.Filter)} bytes, found {self.c.softsoil_size()}"
            )
        self.c.softsoil_status_text.restype = ctypes.c_char_p

    def defaults(self) -> Any:
        """The declared options, to be changed and passed to `CFilter`."""
        options = self.Options()
        self.c.softsoil_defaults(ctypes.byref(options))
        return options

    def force(self, soil: ArrayLike, contact: ArrayLike) -> Array:
        """(6,) forces of one wheel for soil (8,) and contact (9,)."""
        out = np.empty(6)
        _check(self, self.c.softsoil_force(_pointer(_array(soil)), _pointer(_array(contact)), _pointer(out)))
        return out

    def history(self, p: ArrayLike, x: ArrayLike, u: ArrayLike) -> Array:
        """(n_m,) histories of a straight start."""
        m = np.zeros(max(self.sizes["m"], 1))
        _check(
            self, self.c.softsoil_history(_pointer(_array(p)), _pointer(_array(x)), _pointer(_array(u)), _pointer(m))
        )
        return m

    def step(self, p: ArrayLike, dt: float, x: ArrayLike, m: ArrayLike, u: ArrayLike) -> tuple[Array, Array]:
        """State x (n_x,) and histories m (n_m,) one step of dt (s) later, with parameters p (n_p,) and inputs u (n_u,)."""
        after, cells = _array(x).copy(), _array(m).copy()
        arguments = (_pointer(_array(p)), ctypes.c_double(dt), _pointer(after), _pointer(cells), _pointer(_array(u)))
        _check(self, self.c.softsoil_step(*arguments))
        return after, cells

    def rollout(self, p: ArrayLike, dt: float, x0: ArrayLike, u: ArrayLike, m0: ArrayLike | None = None) -> Array:
        """(steps, n_x, count) states for x0 (n_x, count), u (steps, n_u, count) and histories m0 (n_m,)."""
        x0, u = _array(x0), _array(u)
        steps, _, count = u.shape
        out = np.empty((steps, x0.shape[0], count))
        start = None if m0 is None else _pointer(_array(m0))
        size = ctypes.c_size_t
        arguments = (_pointer(_array(p)), ctypes.c_double(dt), size(count), size(steps), _pointer(x0), start)
        _check(self, self.c.softsoil_rollout(*arguments, _pointer(u), _pointer(out)))
        return out


_LISTS = {"states": "x", "inputs": "u", "parameters": "p", "measurements": "y"}


class CFilter:
    """One filter: softsoil_t in memory of Python's.

    x0, std0: first state and its standard deviations, default the library's; t: time of the first
    state (s); options: from `CLibrary.defaults`.
    `u`, `y` are the arrays that the C code reads: fill them and call `predict_held`, `update_held` for the thinnest call.
    """

    def __init__(
        self,
        library: CLibrary,
        x0: ArrayLike | None = None,
        std0: ArrayLike | None = None,
        options: Any = None,
        t: float = 0.0,
    ) -> None:
        self.library, self.state = library, library.Filter()
        self.u, self.y = np.zeros(library.sizes["u"]), np.zeros(library.sizes["y"])
        reference = ctypes.byref(self.state)
        chosen = ctypes.byref(options) if options is not None else None
        first = [None if value is None else _pointer(_array(value)) for value in (x0, std0)]
        _check(library, library.c.softsoil_init(reference, chosen, *first, ctypes.c_double(t)))
        self._self, self._u, self._y = reference, _pointer(self.u), _pointer(self.y)
        self._predict, self._update = library.c.softsoil_predict, library.c.softsoil_update
        self.x = np.ctypeslib.as_array(self.state.x)
        self.std = np.ctypeslib.as_array(self.state.std)

    def predict_held(self, dt: ctypes.c_double) -> int:
        """Time update with the inputs in `u`; returns the status."""
        return self._predict(self._self, self._u, dt)

    def update_held(self, t: ctypes.c_double) -> int:
        """Measurement update with `y` at time t; returns the status."""
        return self._update(self._self, self._y, None, t)

    def predict(self, u: ArrayLike, dt: float) -> int:
        """Time update over dt (s) with inputs u (n_u,); returns the status."""
        self.u[:] = u
        return self.predict_held(ctypes.c_double(dt))

    def update(self, y: ArrayLike, t: float, valid: ArrayLike | None = None) -> int:
        """Measurement update with y (n_y,), taken at t (s); valid (n_y,) bool; returns the status."""
        self.y[:] = y
        flags = None
        if valid is not None:
            flags = np.ascontiguousarray(valid, dtype=np.uint8)
        where = None if flags is None else _pointer(flags)
        return self._update(self._self, self._y, where, ctypes.c_double(t))

    def restart(self, y: ArrayLike, t: float) -> int:
        """Motion again from y (n_y,) at t (s), what is known of the soil kept; returns the status."""
        self.y[:] = y
        return self.library.c.softsoil_restart(self._self, self._y, None, ctypes.c_double(t))

    def replay(self, t: ArrayLike, u: ArrayLike, y: ArrayLike, every: int) -> dict[str, Array]:
        """A whole log: t (N,), u (N, n_u), y (N, n_y); results after each row, and the gravest status; every: predictions per
        update."""
        t, u, y = _array(t), _array(u), _array(y)
        rows, n_x = len(t), self.library.sizes["x"]
        x, std, nis, dof = np.empty((rows, n_x)), np.empty((rows, n_x)), np.empty(rows), np.empty(rows, dtype=np.int32)
        size = ctypes.c_size_t
        inputs = (size(rows), _pointer(t), _pointer(u), _pointer(y), size(every))
        status = self.library.c.softsoil_replay(self._self, *inputs, *[_pointer(a) for a in (x, std, nis, dof)])
        return {"x": x, "std": std, "nis": nis, "dof": dof, "status": status}

    @property
    def P(self) -> Array:
        """(n_x, n_x) covariance."""
        n = self.library.sizes["x"]
        out = np.empty((n, n))
        self.library.c.softsoil_covariance(self._self, _pointer(out))
        return out

    @property
    def counts(self) -> dict[str, int]:
        """How often each status has been met, where it has."""
        return {name: n for (name, _), n in zip(STATUSES, self.state.counts, strict=True) if n}


def _array(value: ArrayLike) -> Array:
    return np.ascontiguousarray(value, dtype=float)


def _pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    # data_as, unlike data, keeps the array alive for as long as the pointer.
    return array.ctypes.data_as(ctypes.c_void_p)


def _check(library: CLibrary, status: int) -> None:
    if status != 0:
        raise ValueError(f"C library: {library.c.softsoil_status_text(status).decode()}")
