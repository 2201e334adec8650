"""One call for a drive: manoeuvre, soil and effects in, a Recording with sensor channels and truth out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.plant.effects import Effects
from softsoil.plant.machine import PlantVehicle
from softsoil.plant.manoeuvres import MANOEUVRES, Driver, PathFollower, lane_change, names
from softsoil.plant.observe import COLUMNS
from softsoil.plant.sensors import Sensors
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.drive import Recording
from softsoil.symbolic.soil import CLAY, Soil

SAMPLE = 0.012
"""Interval of the recorded rows (s), as in the shared drives."""


def simulate(
    manoeuvre: str | Driver = "multi",
    soil: Soil | SoilField = CLAY,
    duration: float = 30.0,
    *,
    effects: Effects | None = None,
    sensors: Sensors | None = None,
    seed: int = 0,
    start: Start | None = None,
    vehicle: PlantVehicle | None = None,
    sample: float = SAMPLE,
    plant: Plant | None = None,
) -> Recording:
    """Drive a manoeuvre on the plant and record it every `sample` s.

    manoeuvre: one of `names()` or a Driver; soil: a Soil or a SoilField; duration: s; effects: what is switched on;
    sensors: what is done to the channels (default: clean); seed: of all that is random; start: default 5 m/s at the
    origin; vehicle: default the one whose bicycle is `softsoil.load_vehicle("plant")`; "reference" is that of the shared drives,
    with which n comes out too high here; sample: s, a multiple of the plant's step; plant: drive on with
    this one (its soil, effects and vehicle hold; the others are ignored). Raises ValueError for an unknown manoeuvre
    or duration <= 0.

    Example:
        >>> import softsoil
        >>> drive = softsoil.simulate("multi", softsoil.load_soil("clay"), duration=0.6, seed=1)
        >>> len(drive), "true_fz_fl" in drive.truth
        (50, True)
    """
    if not duration > 0:
        raise ValueError(f"simulate: expected a duration > 0 s, found {duration}")
    driver = _driver(manoeuvre)
    if plant is None:
        plant = Plant(soil, vehicle=vehicle, effects=effects, start=start or Start(u=5.0))
    clean = drive(plant, driver, duration, sample)
    return sensors.apply(clean, seed) if sensors else clean


def drive(plant: Plant, driver: Driver, duration: float, sample: float = SAMPLE) -> Recording:
    """Let a driver drive a plant; the clean recording. ValueError where `sample` is no multiple of the plant's step."""
    steps = round(sample / plant.dt)
    if steps < 1 or abs(steps * plant.dt - sample) > 1e-9:
        raise ValueError(f"drive: expected a sample interval that is a multiple of {plant.dt} s, found {sample}")
    rows = round(duration / sample)
    within = np.arange(steps, dtype=np.float64) * plant.dt
    table = np.zeros((rows, len(COLUMNS)))
    seen = plant.sample()
    for k in range(rows):
        plant.advance(np.ascontiguousarray(driver(plant.time + within, seen), dtype=np.float64))
        seen = plant.sample()
        table[k] = seen.row
    return recording_of(table, driver.name, plant.soil.name)


def recording_of(table: NDArray[np.float64], name: str, soil_name: str = "") -> Recording:
    """A Recording from rows of COLUMNS (N, len(COLUMNS))."""
    columns = dict(zip(COLUMNS, table.T.copy(), strict=True))
    truth = {key: values for key, values in columns.items() if key.startswith("true_")}
    channels = {key: values for key, values in columns.items() if key not in truth}
    return Recording(name, channels, truth, meta={"soil": soil_name, "source": "plant"})


def _driver(manoeuvre: str | Driver) -> Driver:
    if not isinstance(manoeuvre, str):
        return manoeuvre
    if manoeuvre == "path":
        return PathFollower(lane_change())
    if manoeuvre not in MANOEUVRES:
        raise ValueError(f"manoeuvre: expected one of {', '.join(names())}; found {manoeuvre!r}")
    return MANOEUVRES[manoeuvre]
