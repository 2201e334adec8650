"""n on the reference drives with the declared vehicle: `python benchmarks/estimate_nominal.py ../shared/data/chrono_vehicle`.

Each nominal drive (`paper_*`, `multi_*`, `steps_*`) gets sensor noise, n is estimated from first guesses off by +0.2 and
-0.15 (one n for both axles), and the value at the end is held against the n in the drive's name. Nothing is fitted here.
"""

import argparse
import re
from pathlib import Path

import numpy as np

from estimator.consistency import inside_band
from estimator.terrain import estimate_terrain
from recording.noise import add_noise
from recording.read import read_drive
from symbolic.catalogue import declared_model
from symbolic.soil import CLAY, SAND, SANDY_LOAM
from symbolic.vehicle import load_vehicle

GUESSES = (0.2, -0.15)
SOILS = {"clay": CLAY, "sandyloam": SANDY_LOAM, "sand": SAND}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--vehicle", type=Path, default=Path(__file__).resolve().parents[1] / "vehicles" / "reference.toml"
    )
    parser.add_argument("--noise", default="good")
    parser.add_argument("--seeds", type=int, default=5)
    options = parser.parse_args()
    vehicle = load_vehicle(options.vehicle)
    every: list[np.ndarray] = []
    for log in sorted(options.folder.glob("*.csv.gz")):
        found = re.match(r"(paper|multi|steps)_(clay|sandyloam|sand)_n([\d.]+?)\.csv", log.name)
        if not found:
            continue
        n, model, clean = float(found[3]), declared_model(vehicle, SOILS[found[2]]), read_drive(log)
        rows = []
        for guess in GUESSES:
            for seed in range(options.seeds):
                noisy = add_noise(clean, options.noise, seed)
                e = estimate_terrain(noisy, model, n + guess, tied=True, start=2.0)
                error = e.n_front[-1] - n
                rows.append((error / n, (error / e.n_front_std[-1]) ** 2, e.converged_s, inside_band(e.nis, e.dof)))
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
        f"all, noise {options.noise}, {options.seeds} seeds, guesses {GUESSES}: |error| median {100 * np.median(size):.1f} %, "
        f"worst {100 * size.max():.1f} %, rms {100 * np.sqrt(np.mean(size**2)):.1f} %; "
        f"NEES of n {joined[:, 1].mean():.2f}; "
        f"within 10 % of the final value after {np.median(joined[:, 2]):.1f} s (median); NIS in band {100 * np.median(joined[:, 3]):.0f} %"
    )


if __name__ == "__main__":
    main()
