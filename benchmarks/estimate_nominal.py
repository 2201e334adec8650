"""n on the reference drives with the declared vehicle: `python -m benchmarks.estimate_nominal ../shared/data/chrono_vehicle`.

Each nominal drive (`paper_*`, `multi_*`, `steps_*`) gets sensor noise, n is estimated from first guesses off by +0.2 and
-0.15 (one n for both axles), and the value at the end is held against the n in the drive's name. Nothing is fitted here.
`--judged` takes what `softsoil.estimate` says, its filter corrected by the windows, and prints how often that is identified;
else the estimator runs by itself. `--set run_in=0` runs the filter with another number of its tuning
(`estimator/tuning.py`), to see what that one is worth; `--low-pass 0.05 v` puts a low-pass of 0.05 s behind the noise of v, as a
robot's filter does, `--both-ways` runs it backwards as well.
"""

import argparse
import re
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.judges.low_passed import add_filter_options, filtered
from benchmarks.judges.true_soil import drive_name, nominal_logs, true_soil
from softsoil.estimator.consistency import inside_band
from softsoil.estimator.estimate import METHODS, estimate, run_method
from softsoil.estimator.tuning import Tuning
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

GUESSES = (0.2, -0.15)
RIGHT = 0.10
"""Error of n, as a share, beyond which it must not be called identified."""
BORDER = 90.0
"""m, world x where the soil of the `change_*` drives changes."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--vehicle", type=Path, default=Path(__file__).resolve().parents[1] / "vehicles" / "reference.toml"
    )
    parser.add_argument("--method", default="ukf", choices=METHODS)
    parser.add_argument("--noise", default="good")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--judged", action="store_true", help="as softsoil.estimate says, with its verdicts")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE[,VALUE]", help="another number of the filter")
    add_filter_options(parser)
    options = parser.parse_args()
    tuning = changed(options.set)
    vehicle = load_vehicle(options.vehicle)
    every: list[np.ndarray] = []
    identified: list[bool] = []
    for log in nominal_logs(options.folder):
        soil = true_soil(drive_name(log))
        n, model, clean = float(soil.n), bicycle(vehicle, soil), read_drive(log)
        rows = []
        for guess in GUESSES:
            for seed in range(options.seeds):
                noisy = filtered(add_noise(clean, options.noise, seed), options)
                one = estimate if options.judged else run_method
                e = one(noisy, model, n + guess, method=options.method, tuning=tuning)
                identified.append(e.verdict is not None and e.verdict.usable)
                error = e.n_front[-1] - n
                band = inside_band(e.nis, e.dof) if len(e.nis) else np.nan
                rows.append((error / n, (error / e.n_front_std[-1]) ** 2, e.converged_s, band))
        table = np.array(rows)
        every.append(table)
        worst = table[np.argmax(np.abs(table[:, 0])), 0]
        print(
            f"{log.name:30s} n {n:.2f}: error median {100 * np.median(table[:, 0]):+5.1f} %, worst {100 * worst:+5.1f} %",
            flush=True,
        )
    joined = np.concatenate(every)
    size = np.abs(joined[:, 0])
    print(
        f"all, {options.method}, noise {options.noise}, {options.seeds} seeds, guesses {GUESSES}: "
        f"|error| median {100 * np.median(size):.1f} %, "
        f"worst {100 * size.max():.1f} %, rms {100 * np.sqrt(np.mean(size**2)):.1f} %; "
        f"NEES of n {joined[:, 1].mean():.2f}; "
        f"within 10 % of the final value after {np.median(joined[:, 2]):.1f} s (median)"
        + ("" if np.isnan(joined[:, 3]).all() else f"; NIS in band {100 * np.median(joined[:, 3]):.0f} %")
    )
    if options.judged:
        wrong = int(np.sum(size[identified] > RIGHT))
        print(f"identified: {sum(identified)} of {len(size)}, more than {100 * RIGHT:.0f} % off of these: {wrong}")
    for log in sorted(options.folder.glob("change_clay_*.csv.gz")):
        follow_change(log, vehicle, options.noise, options.seeds, options.method, tuning)


def changed(settings: list[str]) -> Tuning:
    """The filter's tuning with the settings NAME=VALUE[,VALUE] in it; ValueError for a name that it lacks."""
    known = {field.name: getattr(Tuning(), field.name) for field in fields(Tuning)}
    found: dict[str, Any] = {}
    for setting in settings:
        name, _, text = setting.partition("=")
        if name not in known:
            raise ValueError(f"--set: expected one of {', '.join(known)}; found {name!r}")
        values = tuple(float(value) for value in text.split(","))
        found[name] = values if isinstance(known[name], tuple) else type(known[name])(values[0])
    return replace(Tuning(), **found)


def follow_change(log: Path, vehicle: Vehicle, noise: str, seeds: int, method: str, tuning: Tuning) -> None:
    """How soon after the border (world x = 90 m) the front estimate is within 10 % of the new soil."""
    before, after = (float(n) for n in re.findall(r"[\d.]+\d", log.name.removesuffix(".csv.gz")))
    model, clean = bicycle(vehicle, CLAY), read_drive(log)
    border = clean.t[np.argmax(clean["x"] > BORDER)]
    delays = []
    for seed in range(seeds):
        e = run_method(add_noise(clean, noise, seed), model, before + GUESSES[0], method, tuning=tuning)
        near = (e.t > border) & (np.abs(e.n_front - after) < 0.1 * after)
        delays.append(e.t[np.argmax(near)] - border if near.any() else np.inf)
    told = ", ".join(f"{delay:.1f}" for delay in delays)
    print(f"{log.name}: n_front within 10 % of the new {after} after {told} s (one per seed)")


if __name__ == "__main__":
    main()
