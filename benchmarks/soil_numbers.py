"""n, friction and shear modulus of soils that are not quite their class, by `softsoil soil`, on drives of the plant.

Run: python -m benchmarks.soil_numbers --vehicles FOLDER --first 170 --seeds 4 [--noise good]
FOLDER holds what `benchmarks.identify_plant --vehicles FOLDER` identified. Per vehicle a soil is drawn round clay or sandy loam:
phi to 10 %, k, c and k_phi to 30 % (normal in the logarithm), as a table's value may be off; two multi-sine drives and one of
full lock are on it, each on its own n. Printed: how far n is off with the class as it stands and with what the drives say of
it, and the errors of the numbers, in shares and in stated standard deviations. Vehicles 150, 151 and 170 to 173 were looked at
while the command was made, no others.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from benchmarks.judges.plant_vehicles import Log, case_of, log_of
from softsoil.identification.soil_numbers import identify_soil
from softsoil.mpc_demo.blind_cases import N_RANGES
from softsoil.recording.noise import add_noise
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, Soil
from softsoil.symbolic.vehicle import load_vehicle

SPREAD: Mapping[str, float] = {"phi": 0.1, "k": 0.3, "c": 0.3, "k_phi": 0.3}
KINDS = ("multi", "lock", "multi")
FIRST_NUMBER = 80


def drawn_soil(seed: int) -> tuple[Soil, Soil]:
    """A class and the soil that is drawn round it."""
    rng = np.random.default_rng([seed, 77])
    declared = (CLAY, SANDY_LOAM)[int(rng.integers(2))]
    return declared, declared.with_(
        **{name: getattr(declared, name) * math.exp(std * rng.standard_normal()) for name, std in SPREAD.items()}
    )


def drives(seed: int, soil: Soil, noise: str) -> list[Log]:
    """Drives of the vehicle of that seed on the soil, each with an n of its own in the range of its class."""
    case, rng, logs = case_of(seed), np.random.default_rng([seed, 78]), []
    for i, kind in enumerate(KINDS):
        there = soil.with_(n=float(rng.uniform(*N_RANGES[soil.name])))
        log = log_of(case, kind, FIRST_NUMBER + i, on=there)
        logs.append(Log(add_noise(log.drive, noise, FIRST_NUMBER + i), log.soil, log.n, log.whole))
    return logs


def main() -> None:
    """One line per vehicle, and the figures of all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vehicles", type=Path, default=Path("runs/identify_plant"), help="folder of the identified files")
    parser.add_argument("--first", type=int, default=100, help="seed of the first")
    parser.add_argument("--seeds", type=int, default=3, help="how many vehicles")
    parser.add_argument("--noise", default="good", help="of the drives: good or table5")
    asked = parser.parse_args()
    before: list[float] = []
    after: list[float] = []
    in_std: list[float] = []
    numbers: dict[str, list[tuple[float, float]]] = {name: [] for name in SPREAD}
    for seed in range(asked.first, asked.first + asked.seeds):
        declared, true = drawn_soil(seed)
        logs = drives(seed, true, asked.noise)
        stated = tuple((name, share * getattr(declared, name)) for name, share in SPREAD.items())
        vehicle = load_vehicle(asked.vehicles / f"vehicle_{seed}.toml")
        found = identify_soil([log.drive for log in logs], declared.with_(uncertainty=stated), vehicle)
        n = {log.drive.name: log.n for log in logs}
        first = [100 * (found.n_before[name][0] / one - 1) for name, one in n.items()]
        last = [100 * (found.n[name][0] / one - 1) for name, one in n.items()]
        in_std += [(found.n[name][0] - one) / found.n[name][1] for name, one in n.items()]
        before, after = before + first, after + last
        words = []
        for name, one in found.numbers.items():
            off = one.value - getattr(true, name)
            numbers[name].append((off / getattr(true, name), off / one.std))
            words.append(f"{name} {100 * (getattr(true, name) / one.given - 1):+.0f} -> {100 * numbers[name][-1][0]:+.0f} %")
        ratio = "" if found.ratio is None else f"; mse at 2.5 s {found.ratio:.2f} times smaller"
        errors = ", ".join(f"{one:+.1f}" for one in first) + " -> " + ", ".join(f"{one:+.1f}" for one in last)
        print(f"{seed} {declared.name} {found.verdict}: n {errors} %; {', '.join(words)}{ratio}; {found.seconds:.0f} s",
              flush=True)  # fmt: skip
    for what, off_by in (("the class as it stands", before), ("what the drives say of it", after)):
        size = np.abs(off_by)
        print(f"n with {what}: median {np.median(size):.1f} %, worst {size.max():.1f} % off")
    print(f"n in stated standard deviations, rms {np.sqrt(np.mean(np.square(in_std))):.2f}")
    for name, rows in numbers.items():
        shares, sigmas = np.array(rows).T
        print(f"{name}: {100 * np.median(np.abs(shares)):.1f} % off in the median; rms in standard deviations "
              f"{np.sqrt(np.mean(sigmas**2)):.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
