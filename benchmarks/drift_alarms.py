"""Alarms of the drift monitor: `python -m benchmarks.drift_alarms ../shared/data/chrono_vehicle`.

Each drive runs through the terrain filter with the declared vehicle, the soil's class, an n that is 0.1 off at first and good
sensors' noise. Clean drives: every second one (FIT) sets allowances and limits, the others judge. Alarms are asked of the
`effect_*` drives, counted from the moment at which the monitor begins, and of clean judging drives whose recorded channels begin
to lie or whose steering begins to err at SPLICE seconds. Printed: what the fit drives give, each alarm with its delay and class,
and the false alarms per hour of the clean judging drives.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.judges.true_soil import drive_name, nominal_logs, true_soil
from softsoil.codegen.sampling import STEP
from softsoil.estimator.drift import CHANNELS, DriftRules
from softsoil.estimator.estimate import START_UP
from softsoil.estimator.terrain import terrain_model
from softsoil.estimator.terrain_filter import TerrainFilter, first_state
from softsoil.estimator.tuning import Tuning
from softsoil.recording.clock import on_even_clock
from softsoil.recording.drive import Array, Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.recording.states import known_states, measured_states, sensor_std
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, Soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle
from softsoil.windows.inputs import measured_inputs

SPLICE, WINDOW, WITHIN = 15.0, 2.5, 5.0
"""s after the start at which a fault begins; s of the allowance's mean; s within which an alarm is asked."""
UPDATES = STEP * Tuning().update_every
"""s between updates on the reference drives."""
ON_LOAM = ("bank", "steer_lag", "wind", "locked_axles", "backlash")
"""`effect_*` drives on sandy loam, by the data's README; the others are on clay."""
CLASSES = {
    "backlash": "steering", "bank": "vehicle", "locked_axles": "vehicle", "payload": "vehicle", "steer_lag": "steering",
    "steer_offset": "steering", "wind": "vehicle", "yaw_moment": "vehicle",
}  # fmt: skip
Fault = Callable[[dict[str, Array], int], None]


def adds(name: str, much: float) -> Fault:
    """A channel that gains an offset."""

    def fault(channels: dict[str, Array], k: int) -> None:
        channels[name][k:] += much

    return fault


def scales(name: str, factor: float) -> Fault:
    """A channel that gains a factor."""

    def fault(channels: dict[str, Array], k: int) -> None:
        channels[name][k:] *= factor

    return fault


def leads(name: str, rows: int) -> Fault:
    """A command that the vehicle follows late: the recorded one comes earlier by so many rows."""

    def fault(channels: dict[str, Array], k: int) -> None:
        values = channels[name]
        values[k : len(values) - rows] = values[k + rows :].copy()

    return fault


FAULTS: dict[str, tuple[str, Fault]] = {
    "steering offset 0.05 rad": ("steering", adds("steer", 0.05)),
    "steering gain 0.8": ("steering", scales("steer", 1.25)),
    "steering late by 0.14 s": ("steering", leads("steer", 12)),
    "gyro bias 0.05 rad/s": ("sensor", adds("omega_z", 0.05)),
    "speed 8 % too high": ("sensor", scales("u", 1.08)),
    "accelerometer bias 0.5 m/s^2": ("sensor", adds("a_x_imu", 0.5)),
}
"""What begins in mid-course: its class, and what it does to the recorded channels."""


def run(log: Path, soil: Soil, vehicle: Vehicle, seed: int, fault: Fault | None = None) -> tuple[TerrainFilter, Array]:
    """The filter at the end of a drive, and (K, 9) what each update added to each channel, from the monitor's beginning on."""
    drive = on_even_clock(add_noise(read_drive(log), "good", seed))
    drive = drive.between(drive.t[0] + START_UP, np.inf)
    if fault is not None:
        drive = spoiled(drive, fault)
    model, tuning = terrain_model(bicycle(vehicle, soil), True), Tuning()
    u, y = measured_inputs(drive, model.external)[0], measured_states(drive)
    std = sensor_std(drive, np.array(tuning.sensor_floor))
    own = TerrainFilter(model, drive.dt, std, tuning)
    motion = np.nanmedian(known_states(drive)[:5], axis=0)
    own.start(first_state(model, motion, float(soil.n) + 0.1), tuning.std0(model.x, std))
    added = []
    for k in range(len(u) - 1):
        own.predict(u[k])
        if (k + 1) % tuning.update_every == 0:
            own.update(y[k + 1])
            if own.t > DriftRules().after:
                added.append(own.drift.added)
    return own, np.array(added)


def spoiled(drive: Recording, fault: Fault) -> Recording:
    """The drive with a fault that begins SPLICE seconds after its start."""
    channels = {name: values.copy() for name, values in drive.channels.items()}
    fault(channels, int(np.searchsorted(drive.t, drive.t[0] + SPLICE)))
    return replace(drive, channels=channels)


def fitted(added: list[Array], dt: float) -> tuple[Array, Array]:
    """(9,) allowances and limits that drives without drift give; added: of each, from `run`; dt: s between updates."""
    mean = np.full(round(WINDOW / dt), 1.0 / WINDOW)
    means = [np.abs(np.array([np.convolve(column, mean, "valid") for column in a.T])) for a in added]
    allowance = np.max([np.quantile(m, 0.95, axis=1) for m in means], axis=0)
    largest = np.zeros_like(allowance)
    for a in added:
        sums = np.zeros((2, len(allowance)))
        for step in a:
            sums = np.maximum(0.0, sums + np.array([step, -step]) - allowance * dt)
            largest = np.maximum(largest, sums.max(axis=0))
    return allowance, 2.0 * largest


def say(name: str, own: TerrainFilter, begins: float, asked: str, effects) -> tuple[bool, bool, bool]:
    """Print an alarm; whether it came in time, and whether its class is named first, and at all."""
    found = own.drift.first_alarm(effects)
    if found is None:
        print(f"{name:55s} no alarm (largest level {own.drift.highest:.2f})", flush=True)
        return False, False, False
    delay = found.t - begins
    print(f"{name:55s} alarm after {delay:5.1f} s, {found.channel}: {found.likely}, or {found.also} ({asked})", flush=True)
    return 0.0 <= delay <= WITHIN, asked == found.likely, asked in (found.likely, *found.also)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
    vehicle = load_vehicle("reference")
    effects = list(catalogue(vehicle).values())
    clean = nominal_logs(options.folder)
    fit, judge = clean[::2], clean[1::2]
    parts = [run(log, true_soil(drive_name(log)), vehicle, seed)[1] for log in fit for seed in range(options.seeds)]
    allowance, limit = fitted(parts, UPDATES)
    print(f"fit drives: {', '.join(log.name.removesuffix('.csv.gz') for log in fit)}")
    for i, channel in enumerate(CHANNELS):
        stated = f"{channel.name:14s} allowance {channel.allowance:.4f} (fit {allowance[i]:.4f})"
        print(f"{stated}, limit {channel.limit:.3f} (fit {limit[i]:.3f})")
    hours, false = 0.0, 0
    for log in judge:
        for seed in range(options.seeds):
            own, added = run(log, true_soil(drive_name(log)), vehicle, seed)
            hours += len(added) * UPDATES / 3600
            false += own.drift.alarm is not None
    print(f"clean judging drives: {false} false alarms in {60 * hours:.0f} min, {false / hours:.1f} per hour (95 %: below "
          f"{(false + 3 if false == 0 else false + 1.64 * np.sqrt(false) + 1.4) / hours:.1f})")
    results = []
    for log in sorted(options.folder.glob("effect_*.csv.gz")):
        kind = log.name.removesuffix(".csv.gz").removeprefix("effect_")
        own, _ = run(log, SANDY_LOAM if kind in ON_LOAM else CLAY, vehicle, 0)
        results.append(say(log.name.removesuffix(".csv.gz"), own, DriftRules().after, CLASSES[kind], effects))
    for log in judge:
        for kind, (asked, fault) in FAULTS.items():
            own, _ = run(log, true_soil(drive_name(log)), vehicle, 0, fault)
            name = f"{log.name.removesuffix('.csv.gz')}, {kind}"
            results.append(say(name, own, SPLICE, asked, effects))
    for log in sorted(options.folder.glob("change_clay_*.csv.gz")):
        own, _ = run(log, CLAY, vehicle, 0)
        drive = read_drive(log)
        border = float(drive.t[np.argmax(drive["x"] > 90.0)] - drive.t[0]) - START_UP
        results.append(say(log.name.removesuffix(".csv.gz"), own, border, "soil", effects))
    table = np.array(results)
    print(
        f"{len(table)} drives with drift: alarm within {WITHIN:g} s on {table[:, 0].sum()}, the class named first on "
        f"{table[:, 1].sum()}, at all on {table[:, 2].sum()}"
    )


if __name__ == "__main__":
    main()
