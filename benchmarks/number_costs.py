"""Every number of a vehicle file: what it is, how one measures it, and what an error of it costs n on a log.

Run: python -m benchmarks.number_costs LOG [LOG ...] [--vehicle reference] [--soil clay ...]
n of each log is fitted with the file as it stands; then every number of the vehicle and of its effects is moved by its standard
deviation, all others as they are: as the file states it ([uncertainty]), else that of a plausible first guess. Printed: the
change of n (%) per log, and the deviation in brackets. Numbers that only commands use (limits of the steering) cost nothing.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from softsoil.codegen.predictor import substeps_for
from softsoil.identification.errors import n_costs
from softsoil.recording.log_names import named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.recording.states import sensor_std
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.unknown_ground import N_NAMES, N_SCALE
from softsoil.refinement.vehicle_numbers import by_name
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil, load_soil
from softsoil.symbolic.vehicle import NUMBERS, Vehicle, load_vehicle
from softsoil.windows.free_starts import FASTEST, HORIZON, MODEL_STD, NOISE_FLOOR, SUBSTEPS
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive
from softsoil.windows.window_fit import fit_windows

START = 2.0
"""s left out at the beginning of a log."""


def main() -> None:
    """Fit n, move every number and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("logs", type=Path, nargs="+", help="drives")
    parser.add_argument("--vehicle", default="reference", help="a built-in vehicle or its file")
    parser.add_argument("--soil", nargs="*", help="class of each log (default: as its name says)")
    parser.add_argument("--noise", default="none", help="added to the logs")
    asked = parser.parse_args()
    vehicle = load_vehicle(asked.vehicle)
    names = asked.soil or [str(named_soil(path.name)) for path in asked.logs]
    soils = [load_soil(name) for name in names]
    columns = [costs(vehicle, path, soil, asked.noise) for path, soil in zip(asked.logs, soils, strict=True)]
    stds = deviations(vehicle)
    logs = " | ".join(f"n, {path.name.removesuffix('.gz').rsplit('.', 1)[0]}" for path in asked.logs)
    print(f"| number | what it is | how it is measured | {logs} |")
    print("|---|---|---|" + "---|" * len(asked.logs))
    for name, unit, doc, how in rows(vehicle):
        cells = [f"{column[name]:+.1f} ({stds[name]:.2g})" if name in column else "-" for column in columns]
        print(f"| `{name}`{f' ({unit})' if unit not in ('', '1') else ''} | {doc} | {how} | {' | '.join(cells)} |")


def deviations(vehicle: Vehicle) -> dict[str, float]:
    """Number -> standard deviation: as the vehicle's file states it, else of a plausible first guess, where there is one."""
    table = {n.name: n.prior(getattr(vehicle, n.name)) for n in NUMBERS if n.modelled}
    general = by_name()
    known = Known(vehicle.name, {n.name: getattr(vehicle, n.name) for n in NUMBERS})
    for effect in vehicle.effects.values():
        table |= {name: general[name].prior(known)[1] for name in effect if name in general}
    table |= vehicle.uncertainty
    return {name: std for name, std in table.items() if std > 0.0}


def costs(vehicle: Vehicle, path: Path, soil: Soil, noise: str) -> dict[str, float]:
    """Number -> change of n (%) by one standard deviation of it on the log at `path`.

    soil: class of the log; noise: added to it.
    """
    recording = add_noise(read_drive(path), noise, 0)
    stds = deviations(vehicle)
    own = [n for n in NUMBERS if n.modelled and n.name in stds]
    layout = Layout(tuple(Signal(n.name, n.unit, n.doc, getattr(vehicle, n.name), n.lower, n.upper) for n in own))
    model = bicycle(vehicle, soil, "turn_slip", None, layout)
    drive = shooting_drive(recording, model, START)
    compiled = WindowModel(model, drive.dt, SUBSTEPS * substeps_for(drive.dt))
    windows = [FreeWindows(compiled, drive, HORIZON, np.hypot(MODEL_STD, sensor_std(recording, NOISE_FLOOR)), FASTEST)]
    bounds = SOIL_SIGNALS["n"]
    n = Free("n", N_NAMES, N_SCALE, bounds.lower, bounds.upper, drive=0)
    p = model.p.nominal[None]
    fits = [fit_windows(windows, [n], np.array([guess]), p) for guess in (float(soil.n), 0.9)]
    found = min(fits, key=lambda fit: fit.cost).value
    free = [Free(name, (name,), std / 2, -np.inf, np.inf) for name, std in stds.items() if name in model.p]
    start = np.array([*(model.p[f.name].nominal for f in free), *found])
    every = fit_windows(windows, [*free, n], start, p, iterations=0)
    return n_costs(every, stds)


def rows(vehicle: Vehicle) -> list[tuple[str, str, str, str]]:
    """(name, unit, what it is, how it is measured) of every number of a vehicle file and of its effects."""
    general, known = by_name(), catalogue(vehicle)
    table = [(n.name, n.unit, n.doc, n.measured) for n in NUMBERS]
    for effect, values in vehicle.effects.items():
        for name in values:
            signal = next((s for s in known[effect].parameters if s.name == name), None)
            unit, doc = (signal.unit, signal.doc) if signal is not None else ("", effect)
            table.append((name, unit, doc, general[name].how if name in general else f"effect {effect}"))
    return table


if __name__ == "__main__":
    main()
