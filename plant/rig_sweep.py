"""Many runs of the single-wheel rig over the paper's Table 4, for a force law to be judged on.

    python -m softsoil.plant.rig_sweep --out runs/rig_sweep [--runs 1600] [--seed 1] [--jobs 2] [--cast]

Writes one npz per soil class with the arrays of the shared single-wheel runs: conditions, t, series, channels
(load with allow_pickle=False). `--experiment table3` writes the paper's Table 3 experiment instead; with `--cast` the wheel is
located as the reference simulator locates it (`softsoil.plant.reference.raycast`).
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from softsoil.plant.rig import CHANNELS, RigRun, run_rig
from softsoil.symbolic.soil import SOILS, Soil

Array = NDArray[np.float64]

CONDITIONS = np.dtype(
    [("name", "<U24")]
    + [
        (name, "<f8")
        for name in ("k_phi", "k_c", "n", "c", "phi", "k", "load", "slip", "speed", "amplitude_deg", "frequency")
    ]
)
"""Settings of a run, as in the shared runs."""
TABLE_4 = {"load": (1000.0, 4000.0), "slip": (-0.9, 0.9), "speed": (2.5, 8.5), "n": (0.4, 1.3)}
"""Table 4 of the paper: N, 1, m/s, 1."""
AMPLITUDES, FREQUENCIES = (12.0, 22.0), (0.35, 1.5)
"""Yaw amplitude (deg) and frequency (Hz) are drawn from these."""
FIRST, LAST, INTERVAL = 1.0, 2.595, 0.005
"""Rows kept of each run (s): a second of settling is cut."""
TABLE_3 = {"load": 2500.0, "slip": 0.2, "speed": 5.5, "amplitude_deg": 20.0, "frequency": 1.0}
"""The paper's Table 3 with its 1 Hz sweep."""


def draw(soil: Soil, runs: int, seed: int) -> NDArray[np.void]:
    """(runs,) CONDITIONS drawn uniformly from Table 4 for one soil class."""
    rng = np.random.default_rng([seed, *soil.name.encode()])
    rows = np.zeros(runs, CONDITIONS)
    for name, (low, high) in {**TABLE_4, "amplitude_deg": AMPLITUDES, "frequency": FREQUENCIES}.items():
        rows[name] = rng.uniform(low, high, runs)
    for name in ("k_phi", "k_c", "c", "phi", "k"):
        rows[name] = soil.parameters()[name]
    rows["name"] = [f"{soil.name}_plant_{k:04d}" for k in range(runs)]
    return rows


def run_of(row: np.void, soil: str = "soil") -> RigRun:
    """What a row of CONDITIONS tells the rig."""
    parameters = {name: float(row[name]) for name in ("k_phi", "k_c", "n", "c", "phi", "k")}
    return RigRun(
        Soil(soil, **parameters),
        load=float(row["load"]),
        slip=float(row["slip"]),
        speed=float(row["speed"]),
        amplitude=float(np.deg2rad(row["amplitude_deg"])),
        frequency=float(row["frequency"]),
    )


def series_of(row: np.void, cast: bool = False) -> NDArray[np.float32]:
    """(rows, 7) CHANNELS of one run over the rows kept."""
    times, values = run_rig(run_of(row), LAST + INTERVAL, cast=cast)
    keep = (times > FIRST - 1e-9) & (times < LAST + 1e-9)
    return values[keep].astype(np.float32)


def sweep(conditions: NDArray[np.void], jobs: int, cast: bool = False) -> dict[str, NDArray]:
    """The arrays of a file of runs, computed by so many processes."""
    series = Parallel(n_jobs=jobs, batch_size=8)(delayed(series_of)(row, cast) for row in conditions)
    times = FIRST + INTERVAL * np.arange(len(series[0]))
    return {"conditions": conditions, "t": times, "series": np.stack(series), "channels": np.array(CHANNELS)}


def main() -> None:
    """Run and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/rig_sweep"))
    parser.add_argument("--runs", type=int, default=1600, help="over all soil classes together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--experiment", choices=("table3", "table4"), default="table4")
    parser.add_argument("--cast", action="store_true", help="find the wheel by the reference's ray cast")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    begin, total = time.perf_counter(), 0
    for soil in SOILS.values():
        runs = -(-arguments.runs // len(SOILS))
        conditions = draw(soil, 1 if arguments.experiment == "table3" else runs, arguments.seed)
        if arguments.experiment == "table3":
            for name, value in {**TABLE_3, "n": soil.n}.items():
                conditions[name] = value
        path = arguments.out / f"{soil.name.replace('_', '')}_{arguments.experiment}.npz"
        arrays = sweep(conditions, arguments.jobs, arguments.cast)
        np.savez_compressed(
            path, conditions=arrays["conditions"], t=arrays["t"], series=arrays["series"], channels=arrays["channels"]
        )
        total += len(conditions)
        print(f"{path}: {len(conditions)} runs, {time.perf_counter() - begin:.0f} s so far", flush=True)
    print(f"{total} runs in {time.perf_counter() - begin:.0f} s with {arguments.jobs} processes")


if __name__ == "__main__":
    main()
