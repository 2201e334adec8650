"""Clocks that are off by 0.03 s, and what else makes a drive inconsistent: whether `softsoil.late_clocks` names the right one.

Run: python -m benchmarks.late_clocks [../shared/data/chrono_vehicle] [--seed 2] [--shift 0.03]
Drives of the reference vehicle with good sensors. Their steering, steering and wheels, or inertial sensor are recorded late and
early; and with right clocks the vehicle's yaw inertia or mass, or the soil class, is wrong: then no clock is to be named.
Fit and judgement: nothing is fitted; n by name judges.
"""

from __future__ import annotations

import argparse
import warnings
from pathlib import Path

import numpy as np

import softsoil
from softsoil.estimator.late_clocks import CLOCKS, shifted
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import add_noise

DRIVES = ("multi_clay_n0.65", "multi_sandyloam_n0.70", "paper_sandyloam_n0.90", "paper_clay_n0.70", "multi_sandyloam_n0.55")
WRONG = {"inertia x 1.4": {"yaw_inertia": 1.4}, "inertia x 0.65": {"yaw_inertia": 0.65}, "mass x 1.2": {"mass": 1.2}}
"""What is wrong -> factors of numbers of the vehicle."""


def main() -> None:
    """Print each case and the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, nargs="?", default=Path("../shared/data/chrono_vehicle"))
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--shift", type=float, default=0.03, help="s")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    reference = softsoil.load_vehicle("reference")
    right = named = silent = shifts = false = others = 0
    off: list[float] = []
    for name in DRIVES:
        log = add_noise(softsoil.read_drive(asked.data / f"{name}.csv.gz"), "good", asked.seed)
        soil, true = softsoil.load_soil(named_soil(name) or "clay"), named_n(name) or np.nan
        model = softsoil.bicycle(reference, soil)
        for what, names in CLOCKS.items():
            for side in (1, -1):
                drive = shifted(log, names, -side * round(asked.shift / log.dt))
                found = softsoil.estimate(drive, model, 0.7)
                clocks = softsoil.late_clocks(drive, model, found)
                word = found.verdict.word if found.verdict is not None else "none"
                first = clocks[0] if clocks else None
                shifts += 1
                silent += word == "identified"
                right += first is not None and first.what == what and first.late * side > 0
                named += any(clock.what == what and clock.late * side > 0 for clock in clocks)
                if first is not None:
                    off.append(100 * abs(first.n / true - 1.0))
                print(f"{name:24s} {what} {side * asked.shift:+.3f} s: {word}, n {found.n_front[-1] / true - 1.0:+.1%}; "
                      f"{_words(clocks, true)}", flush=True)  # fmt: skip
        other = softsoil.load_soil("sandy_loam" if soil.name == "clay" else "clay")
        cases = {what: softsoil.bicycle(_wrong(reference, factors), soil) for what, factors in WRONG.items()}
        for what, wrong in {**cases, "another class": softsoil.bicycle(reference, other)}.items():
            found = softsoil.estimate(log, wrong, 0.7)
            clocks = softsoil.late_clocks(log, wrong, found)
            others, false = others + 1, false + bool(clocks)
            word = found.verdict.word if found.verdict is not None else "none"
            print(f"{name:24s} {what}: {word}, n {found.n_front[-1] / true - 1.0:+.1%}; {_words(clocks, true)}", flush=True)
    print(
        f"{named} of {shifts} clocks named, {right} first, {silent} passed as identified; n with the first one named "
        f"{np.median(off):.1f} % off in the median, {np.max(off):.1f} at worst; of {others} other faults {false} called a clock"
    )


def _wrong(vehicle: softsoil.Vehicle, factors: dict[str, float]) -> softsoil.Vehicle:
    return vehicle.with_(**{name: factor * getattr(vehicle, name) for name, factor in factors.items()})


def _words(clocks: tuple, true: float) -> str:
    return ", ".join(f"{c.what} {c.late:+.3f} s (n {c.n / true - 1.0:+.1%})" for c in clocks) or "no clock"


if __name__ == "__main__":
    main()
