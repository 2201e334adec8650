"""How soon the filter follows a new soil, and how often it sees one where there is none.

`python -m benchmarks.soil_changes --drives 36 --seed 2 [--data ../shared/data/chrono_vehicle]`: drives of the plant with
multi-sine steering, each with soil, n, speed and heading of its own; half of them cross a border, where n goes up or down by
0.15, 0.2 or 0.25, the others have one soil. With --data the shared nominal drives and the shared drive with a change, under the
seeds of noise `--noise-seeds 0 10`, come with them. The initial guess is off by +0.2 or -0.15 in turns. Printed for each noise:
time from the border (front axle) to 10 % of the new n, median and 9th of 10, and from which it stays there for 2 s; and, where
the soil stays the same, changes that stand and those that were revoked, the former per hour, the error at the end and NEES of
n. `--set change_sigmas=4` runs the filter with another number of its tuning.
Nothing is fitted here; the filter's numbers were chosen on other drives of the plant and on every second shared nominal drive
(`--half 0`); `--half 1` are the others.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.estimate_nominal import BORDER, GUESSES, changed
from benchmarks.judges.true_soil import drive_name, nominal_logs, true_soil
from softsoil.estimator.estimate import run_method
from softsoil.estimator.tuning import Tuning
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.mpc_demo.blind_cases import N_RANGES
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Speed
from softsoil.plant.simulate import simulate
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SOILS, Soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

SIZES = (0.25, -0.25, 0.2, -0.2, 0.15, -0.15)
"""Changes of n, in turns."""
LEAST, NEAR, STAYS = 0.35, 0.1, 2.0
"""n that no change goes below; share of n that counts as followed; s for which it has to stay so."""
SECONDS = 45.0


@dataclass(frozen=True)
class Case:
    """drive; vehicle; soil: declared, with its n at first; after: n behind the border; border: world x (m), inf without one."""

    drive: Recording
    vehicle: Vehicle
    soil: Soil
    after: float
    border: float = np.inf


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", type=int, default=36, help="of the plant")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--slower", type=float, default=1.0, metavar="TIMES", help="the plant's drives so many times as slow")
    parser.add_argument("--data", type=Path, help="folder of the shared drives")
    parser.add_argument("--half", type=int, choices=(0, 1), help="every second shared drive, from this one on")
    parser.add_argument("--noise-seeds", type=int, nargs=2, default=(0, 10), metavar=("FIRST", "END"), help="shared change")
    parser.add_argument("--noise", nargs="+", default=["good", "table5"])
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="another number of the filter")
    options = parser.parse_args()
    tuning = changed(options.set)
    cases = [drawn(index, options.seed, options.slower) for index in range(options.drives)]
    groups = {"plant": [(case, index) for index, case in enumerate(cases)]} if cases else {}
    if options.data is not None:
        groups["shared"] = shared(
            options.data, slice(options.half, None, None if options.half is None else 2), range(*options.noise_seeds)
        )
    for noise in options.noise:
        for name, group in groups.items():
            report(f"{name}, {noise}", group, noise, tuning)


def drawn(index: int, seed: int, slower: float) -> Case:
    """Drive `index` of a seed from the plant, so many times as slow: with a change of soil where the index is even."""
    rng = np.random.default_rng([seed, index, 5])
    name, change = str(rng.choice(list(N_RANGES))), SIZES[index // 2 % len(SIZES)] if index % 2 == 0 else 0.0
    n = max(float(rng.uniform(*N_RANGES[name])), LEAST - change)
    mean, wave, period = (float(rng.uniform(*limits)) for limits in ((4.5, 6.5), (0.8, 1.8), (9.0, 13.0)))
    speed = Speed(mean / slower, wave / slower, period)
    soil, border, heading = SOILS[name].with_(n=n), float(rng.uniform(60.0, 95.0)) / slower, float(rng.uniform(-0.3, 0.3))
    ground = SoilField.change_at(soil, soil.with_(n=n + change), border)
    manoeuvre = Manoeuvre("change", MultiSine(seed=1000 * seed + index), speed)
    drive = simulate(manoeuvre, ground, SECONDS, seed=1000 * seed + index, start=Start(u=5.0 / slower, psi=heading))
    return Case(drive, load_vehicle(PLANT_VEHICLE), soil, n + change, border if change else np.inf)


def shared(folder: Path, part: slice, seeds: range) -> list[tuple[Case, int]]:
    """Shared nominal drives, and the one with a change under these seeds of noise."""
    vehicle = load_vehicle("reference")
    cases = []
    for index, log in enumerate(nominal_logs(folder)[part]):
        soil = true_soil(drive_name(log))
        cases += [(Case(read_drive(log), vehicle, soil, float(soil.n)), 2 * index + seed) for seed in range(2)]
    change = read_drive(folder / "change_clay_n0.50_to_0.75.csv.gz")
    return cases + [(Case(change, vehicle, CLAY.with_(n=0.5), 0.75, BORDER), seed) for seed in seeds]


def report(name: str, group: list[tuple[Case, int]], noise: str, tuning: Tuning) -> None:
    """Print both lines of a group of cases, each with its seed."""
    delays, ends, seconds, changes, revoked = [], [], 0.0, 0, 0
    for case, seed in group:
        n0 = float(np.clip(case.soil.n + GUESSES[seed % 2], 0.25, 1.5))
        found = run_method(add_noise(case.drive, noise, seed), bicycle(case.vehicle, case.soil), n0, "ukf", tuning=tuning)
        if np.isfinite(case.border):
            since = found.t - case.drive.t[np.argmax(case.drive["x"] > case.border)]
            delays.append(followed(since, np.abs(found.n_front / case.after - 1) < NEAR))
            continue
        error = found.n_front[-1] - case.after
        ends.append((abs(error) / case.after, (error / found.n_front_std[-1]) ** 2))
        seconds += float(found.t[-1] - found.t[0])
        changes += len(found.changes)
        revoked += len(found.revoked)
    first, stays = np.array(delays).T
    print(
        f"{name}: {len(delays)} changes of n, within {100 * NEAR:.0f} % after {ranks(first)}, to stay after {ranks(stays)}; "
        f"within 3 s on {np.sum(first <= 3.0)}"
    )
    error, nees = np.array(ends).T
    print(
        f"{name}: {len(ends)} drives on one soil, {changes} changes that stand in {seconds / 60:.0f} min, "
        f"{revoked} revoked, {3600 * changes / seconds:.0f} per hour; error at the end "
        f"{100 * np.median(error):.1f} %, at most {100 * error.max():.1f} %; NEES {nees.mean():.2f}",
        flush=True,
    )


def followed(since: np.ndarray, near: np.ndarray) -> tuple[float, float]:
    """Time since the border (N,) at which n is first near (N,) the new one, and from which it stays so for STAYS seconds (s)."""
    later = np.flatnonzero((since > 0) & near)
    stays = [k for k in later if near[(since >= since[k]) & (since < since[k] + STAYS)].all()]
    return float(since[later[0]]) if len(later) else np.inf, float(since[stays[0]]) if stays else np.inf


def ranks(delays: np.ndarray) -> str:
    """Median and 9th of 10."""
    median, ninth = (np.quantile(delays, q, method="higher") for q in (0.5, 0.9))
    return f"{median:.1f} s (9th of 10: {ninth:.1f} s)"


if __name__ == "__main__":
    main()
