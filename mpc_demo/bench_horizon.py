"""Speed of the moving horizon in C: one update, with one parameter and with four, against the filter's step."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.c_library.binding import CFilter, CLibrary
from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.codegen.c_library.vehicle_binding import CVehicle, looks_at_vehicle
from softsoil.codegen.text_cache import asked_for, texts_from_cache
from softsoil.control.c_estimator import c_library_texts
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.mpc_demo.bench_rows import Row, seconds
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.noise import add_noise
from softsoil.recording.states import measured_states
from softsoil.windows.inputs import measured_inputs

Array = NDArray[np.float64]

DT = 0.012
MORE = 3
"""Parameters of the declared effects that are estimated beside n: the last ones."""
CALLS = 400
UPDATES = 8
"""Updates before the one that is timed: n still moves, so that a second window is linearised anew too."""


def horizon_rows(declared: Declaration, library: CLibrary) -> Iterator[Row]:
    """The rows for a declaration with effects; library: its own, with n alone.

    The look at the vehicle has a row where the library has one: the longest call of those that take a window in.
    """
    one, step = _least(horizon_update(declared, library), filter_step(library))
    against = "prediction and update of the filter, in the same library"
    yield Row("horizon_update_1", one, "us", against, step)
    if looks_at_vehicle(library):
        yield Row("vehicle_look", longest_look(declared, library), "us", against, step)
    more = tuple(library.names["parameters"][-MORE:])
    asked = asked_for("horizon", declaration_toml(declared), DT, *more)
    texts = texts_from_cache(asked, lambda: c_library_texts(declared, DT, promote=more))
    with tempfile.TemporaryDirectory() as folder:
        write_library(folder, texts)
        four = CLibrary(folder)
    update, step = _least(horizon_update(declared, four), filter_step(four))
    yield Row("horizon_update_4", update, "us", against, step)


def _least(*calls: Callable[[], object]) -> list[float]:
    """Least time of one call of each function (us): an update is long enough to be timed alone."""
    return [1e6 * min(seconds(call) for _ in range(CALLS)) for call in calls]


def longest_look(declared: Declaration, library: CLibrary) -> float:
    """The longest of the calls that take one window in (us), each the least of its times over a drive."""
    horizon = CHorizon(library)
    horizon.options.dt = DT
    look = CVehicle(horizon)
    times: list[list[float]] = [[]]
    for t, u, y in _samples(declared, seconds=40.0):
        horizon.push(u, y, t)
        horizon.update()
        times[-1].append(1e6 * seconds(look.update))
        if look.head.next <= 0:
            times.append([])
    whole = max(map(len, times))
    return float(np.min([one for one in times if len(one) == whole], axis=0).max())


def _samples(declared: Declaration, seconds: float) -> Iterator[tuple[float, Array, Array]]:
    """Time, inputs and noisy states of a drive of the declared model."""
    model = declared.build()
    drive = add_noise(synthetic_drive(model, declared.vehicle.radius, seconds=seconds), "good", 1)
    inputs, states = measured_inputs(drive, model.external)[0], measured_states(drive)
    return zip(map(float, drive.t), inputs, states, strict=True)


def horizon_update(declared: Declaration, library: CLibrary) -> Callable[[], object]:
    """An update that takes in a window and linearises another one anew, from the same state each time."""
    horizon = CHorizon(library)
    horizon.options.dt = DT
    horizon.options.guess[0] += 0.2
    horizon.start(0.0)
    saved, updates = horizon.saved(), 0
    for t, u, y in _samples(declared, seconds=12.0):
        horizon.push(u, y, t)
        saved = horizon.saved()
        if horizon.update():
            updates += 1
            if updates > UPDATES:
                break

    def update() -> None:
        horizon.restore(saved)
        horizon.update()

    return update


def filter_step(library: CLibrary) -> Callable[[], object]:
    """A prediction and an update of the filter, called from Python."""
    own = CFilter(library)
    u, y = np.zeros(library.sizes["u"]), np.zeros(library.sizes["y"])
    u[library.names["inputs"].index("steer")] = 0.1
    y[library.names["measurements"].index("u")] = 6.0
    own.restart(y, 0.0)

    def step() -> None:
        own.predict(u, DT)
        own.update(y, own.state.t)

    return step
