"""Speed of a whole tick of the driver, in C against Python: filter, histories, solve and following of plans."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.sampling import STEP
from softsoil.control.c_folder import controller_texts
from softsoil.control.courses import double_lane_change
from softsoil.control.declared import for_control
from softsoil.control.driver import Driver
from softsoil.control.driver_binding import CDriver
from softsoil.control.driver_types import DriverSettings
from softsoil.control.ocp import Ocp
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.bench_rows import Row
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.noise import TABLE5

Array = NDArray[np.float64]
TICKS, REPEATS, SPEED, N0 = 800, 3, 6.0, 0.7


def driver_rows(declared: Declaration) -> Iterator[Row]:
    """driver_tick_c: a tick with a plan (ms, median), its p99, and one between plans, each against Python's `Driver` on the same
    measurements; the vehicle is the declared model itself, its states with Table-5 noise."""
    declared = for_control(declared)
    ocp = Ocp(declared.build(), declared.vehicle)
    in_c, path = CDriver(controller_texts(declared), len(ocp.z)), double_lane_change()
    driver = Driver(ocp, path, SPEED, n0=N0)

    def python(k: int, measured: Mapping[str, float]) -> Array:
        command = driver.tick(k * STEP, measured)
        return np.array([command.steer, command.a_asked])

    measured, theirs = _drive(ocp, python)
    ours = np.full(TICKS, np.inf)
    for _ in range(REPEATS):
        in_c.start(path, SPEED, n0=N0)
        for k, row in enumerate(measured):
            in_c.take(row)
            began = time.perf_counter()
            in_c.tick_held(k * STEP)
            ours[k] = min(ours[k], time.perf_counter() - began)
    every = DriverSettings().plan_every
    solves = np.arange(TICKS) % every == 0
    solves[0] = False
    between = np.arange(TICKS) % every == every - 1
    against = "Python's Driver, the same ticks"
    for name, pick, share in (("", solves, 50), ("_p99", solves, 99), ("_between", between, 50)):
        values = [1e3 * float(np.percentile(seconds[pick], share)) for seconds in (ours, theirs)]
        yield Row(f"driver_tick_c{name}", values[0], "ms", against, values[1])


def _drive(ocp: Ocp, tick: Callable[[int, Mapping[str, float]], Array]) -> tuple[list[dict[str, float]], Array]:
    """Measurements of a drive of the model itself, and the seconds of each tick."""
    rates, z, rng = ocp.dynamics(), ocp.z.pack(u=SPEED), np.random.default_rng(0)
    std, none = np.array([TABLE5[name] for name in STATE_CHANNELS]), np.zeros(len(ocp.r))
    rows, spent = [], np.zeros(TICKS)
    for k in range(TICKS):
        rows.append(dict(zip(STATE_CHANNELS, (z[:6] + std * rng.standard_normal(6)).tolist(), strict=True)))
        began = time.perf_counter()
        steer, a_x = tick(k, rows[-1])
        spent[k] = time.perf_counter() - began
        w = np.array([(steer - z[-1]) / STEP, a_x])
        z = z + STEP * np.array(rates(z, w, none, ocp.s.nominal)[0]).ravel()
    return rows, spent
