"""Speed of whole things: the driver, the plant and the loop closed with data, the latter two against the time on the vehicle."""

from __future__ import annotations

import time
from collections.abc import Iterator

from softsoil.declaration.model_file import Declaration
from softsoil.estimator.horizons import START_UP
from softsoil.mpc_demo.bench_driver import driver_rows
from softsoil.mpc_demo.bench_rows import Row
from softsoil.plant.manoeuvres import MANOEUVRES
from softsoil.plant.simulate import drive as simulate
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.drive import Recording
from softsoil.refinement.refine import refine

SIMULATED, REPEATS = 10.0, 3


def whole_rows(declared: Declaration, drive: Recording) -> Iterator[Row]:
    """driver_tick_c: a tick of the driver in C (`driver_rows`); plant_realtime_factor: seconds of a multi-sine drive per
    second of one processor; refine_log: one drive traced (s)."""
    yield from driver_rows(declared)
    simulate(Plant(declared.soil, start=Start(u=5.0)), MANOEUVRES["multi"], 0.1)  # builds machine code
    spent = []
    for _ in range(REPEATS):
        plant = Plant(declared.soil, start=Start(u=5.0))
        began = time.process_time()
        simulate(plant, MANOEUVRES["multi"], SIMULATED)
        spent.append(time.process_time() - began)
    yield Row("plant_realtime_factor", SIMULATED / min(spent), "1", "real time is 1", None)
    began = time.perf_counter()
    refine([drive], declared, start=START_UP)
    spent_here = time.perf_counter() - began
    yield Row("refine_log", spent_here, "s", "the drive itself, start-up included", float(drive.t[-1] - drive.t[0]))
