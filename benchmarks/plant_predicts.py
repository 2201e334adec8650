"""How far better states can be predicted with the right n at all: the plant itself as the predictor of another simulator.

    python -m benchmarks.plant_predicts ../shared/data/chrono_vehicle [--drives paper] [--horizon 2.5]

`softsoil study` predicts with the bicycle; here the whole plant does, soil and eleven degrees of freedom: window after window
from the log's state, with the log's steering, speed and wheel speeds, its wheels located as the independent simulator locates
its own. Once with n of the drive's name and once 0.2 above it, as a first guess is. Mean squared errors of y, psi, v and omega_z,
those with the wrong n over those with the right one. Nothing is fitted.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from benchmarks.judges.drive_windows import SETTLE, conditions, with_the_others_steering
from softsoil.mpc_demo.study import GUESS_OFF, LATERAL
from softsoil.plant.replay import LEAD, replay
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive
from softsoil.symbolic.soil import Soil


def errors(log: Recording, begin: float, horizon: float, off: float) -> NDArray[np.float64]:
    """(4,) mean squared errors of LATERAL over one window, the plant on a soil whose n is `off` from the drive's."""
    soil, effects = conditions(log.name)
    if not isinstance(soil, Soil):
        raise ValueError(f"{log.name}: expected a drive on one soil, found a border")
    ours, theirs = replay(
        log,
        soil.with_(n=soil.n + off),
        begin,
        begin + horizon,
        effects=effects,
        vehicle=with_the_others_steering(),
        hold_speed=True,
        cast=True,
    )
    apart = {name: ours[name] - theirs[name] for name in LATERAL}
    apart["psi"] = np.angle(np.exp(1j * apart["psi"]))
    return np.array([np.mean(np.square(apart[name])) for name in LATERAL])


def main() -> None:
    """Print a line per drive and the geometric mean."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--drives", nargs="+", default=["paper"], help="beginnings of the names")
    parser.add_argument("--horizon", type=float, default=2.5, help="s")
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    gains = []
    print(f"{'drive':<24}" + "".join(f"{name:>9}" for name in LATERAL))
    for path in sorted(path for d in options.drives for path in options.folder.glob(f"{d}_*.csv.gz")):
        log = read_drive(path)
        begins = np.arange(SETTLE + LEAD, log.t[-1] - options.horizon, options.horizon)
        tasks = [(float(begin), off) for off in (GUESS_OFF, 0.0) for begin in begins]
        found = Parallel(n_jobs=options.workers)(
            delayed(errors)(log, begin, options.horizon, off) for begin, off in tasks
        )
        wrong, right = np.array(found).reshape(2, len(begins), len(LATERAL)).mean(axis=1)
        gains.append(wrong / right)
        print(f"{log.name:<24}" + "".join(f"{gain:>9.2f}" for gain in gains[-1]), flush=True)
    mean = float(np.exp(np.mean(np.log(gains))))
    print(f"error with n {GUESS_OFF} too high over that with n, {options.horizon:g} s, geometric mean: {mean:.2f}")


if __name__ == "__main__":
    main()
