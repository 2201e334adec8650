"""The moving horizon of the C library beside a driver's filter: a second estimate of n, and the verdict on it while driving."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.codegen.c_library.binding import CLibrary
from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.codegen.c_library.vehicle_binding import CVehicle, looks_at_vehicle
from softsoil.codegen.sampling import STEP
from softsoil.codegen.text_cache import asked_for, texts_from_cache
from softsoil.control.c_estimator import c_library_texts
from softsoil.control.declared import for_control
from softsoil.declaration.model_file import Declaration, declaration_toml

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LiveEvidence:
    """Numbers that the verdict rests on.

    information_std: of n by noise and model error alone; unexplained, unexplained_std: share of the variance of v and of omega_z
    that the model leaves beyond sensor noise, and its standard error; inertia, inertia_std: share by which the windows would have
    the yaw inertia larger than declared, and its standard deviation; parts, parts_sigmas: n of the earlier and the later windows
    where these differ most, and by how many standard deviations; motion: root mean square lateral specific force (m/s^2);
    windows: that the estimate rests on; changes: how often the soil has changed; strain, load, load_std: how the windows would
    have the vehicle other than its file (`softsoil.estimator.strain`), NaN where that states no errors of its numbers, and
    before a window has been looked at.
    """

    information_std: float
    unexplained: tuple[float, float]
    unexplained_std: tuple[float, float]
    inertia: float
    inertia_std: float
    parts: tuple[float, float]
    parts_sigmas: float
    motion: float
    windows: int
    changes: int
    strain: float = math.nan
    load: float = math.nan
    load_std: float = math.nan


class LiveHorizon:
    """A `Judge`: windows of the last two minutes, in C; a tick that completes a window takes about a millisecond.

    Where the vehicle's file states errors of its numbers, each tick looks at the vehicle, too: less than a millisecond.
    declared: vehicle, soil, law and effects; std (6,): of the sensors of x, y, psi, u, v, omega_z (SI); tick: s between samples.
    The effects are those of a driver's model. Raises ValueError where there is no C compiler, or more than one n.
    """

    def __init__(self, declared: Declaration, std: ArrayLike, tick: float = STEP) -> None:
        whole = for_control(declared)
        asked = asked_for("live_horizon", declaration_toml(whole), tick)
        texts = texts_from_cache(asked, lambda: c_library_texts(whole, tick))
        with tempfile.TemporaryDirectory() as folder:
            write_library(folder, texts)
            self._c = CHorizon(CLibrary(folder))
        if self._c.names != ["n"]:
            raise ValueError(f"live horizon: expected one n for both axles, found {', '.join(self._c.names)}")
        self._look = CVehicle(self._c) if looks_at_vehicle(self._c.library) else None
        self._c.options.dt = tick
        self._c.options.r_std[:] = np.asarray(std, dtype=float)
        self._inputs = self._c.library.names["inputs"]

    def start(self, t: float, n0: float) -> None:
        """Begin a drive at t (s) with the initial guess n0."""
        self._c.options.guess[0] = n0
        self._c.start(t)
        if self._look is not None:
            self._look.start()

    def tick(self, t: float, inputs: Mapping[str, float], y: Array) -> None:
        """One sample at t (s): inputs by name, measurements y (6,), NaN where none was made."""
        self._c.push([inputs[name] for name in self._inputs], y, t)
        self._c.update()
        if self._look is not None:
            self._look.update()

    @property
    def verdict(self) -> str:
        """Whether n may be used: "identified", or why not (`softsoil.estimator.verdict.WORDS`)."""
        return self._c.verdict

    @property
    def n(self) -> float:
        """Estimate of n."""
        return float(self._c.head.n[0])

    @property
    def n_std(self) -> float:
        """Its standard deviation."""
        return float(self._c.head.std[0])

    @property
    def evidence(self) -> LiveEvidence:
        """What the verdict rests on."""
        head = self._c.head
        look: tuple[float, ...] = ()
        if self._look is not None and self._look.head.windows:
            look = self._look.head.strain, self._look.head.load, self._look.head.load_std
        (v, omega_z), (v_std, omega_z_std) = head.unexplained, head.unexplained_std
        earlier, later = head.parts
        return LiveEvidence(
            float(head.information_std[0]), (v, omega_z), (v_std, omega_z_std), head.inertia, head.inertia_std, (earlier, later),
            head.parts_sigmas, head.motion, head.windows, head.changes, *look,
        )  # fmt: skip
