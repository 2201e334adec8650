"""n from drives of the plant without wheel speeds, for each driveline, and which driveline the logs say.

    python -m benchmarks.absent_wheels --vehicles FOLDER [--seeds 100 101] [--drivelines locked front] [--kinds multi lock]

Vehicles are those of `python -m benchmarks.identify_plant` by their seeds, identified from logs with wheel speeds, in files
vehicle_SEED.toml of FOLDER; none declares its driveline. Drives have the noise "good"; the first guess of n is 0.9. True values
are read to judge only. Seeds 0 to 2 were looked at while the method was made, the others were not.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.judges.plant_vehicles import case_of, log_of
from softsoil.estimator.driveline_choice import DRIVELINES
from softsoil.estimator.estimate import estimate
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.vehicle import load_vehicle

WORDS = dict(zip(("locked", "open", "front", "rear"), DRIVELINES, strict=True))
NUMBERS = {"multi": 10, "lock": 11, "steps": 12}
"""Kinds of drives and the numbers by which `log_of` draws them, those that judge in `identify_plant`."""
GUESS, TRUSTED = 0.9, 0.1
"""First guess of n; error, as a share, beyond which it must not be called identified."""


def main() -> None:
    """Print a line per drive and the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vehicles", type=Path, required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[100, 101, 103, 104, 200, 201, 300])
    parser.add_argument("--drivelines", nargs="+", choices=list(WORDS), default=["locked"])
    parser.add_argument("--kinds", nargs="+", choices=list(NUMBERS), default=["multi", "lock"])
    asked = parser.parse_args()
    results = []
    for seed in asked.seeds:
        for name in asked.drivelines:
            for kind in asked.kinds:
                results.append(_judged(seed, name, kind, asked.vehicles / f"vehicle_{seed}.toml"))
    judged = [found for found in results if found is not None]
    errors = np.array([abs(error) for _, error, _ in judged])
    named = [error for word, error, _ in judged if word == "identified"]
    print(
        f"{len(judged)} drives: driveline right on {sum(right for *_, right in judged)}; n of the filter within 10 % on "
        f"{int((errors <= TRUSTED).sum())}, median {100 * np.median(errors):.1f} %; identified {len(named)}, of these more than "
        f"10 % off {sum(abs(error) > TRUSTED for error in named)}"
    )


def _judged(seed: int, name: str, kind: str, file: Path) -> tuple[str, float, bool] | None:
    """Verdict, error of n as a share and whether the driveline is right; None for a drive that is refused."""
    case, numbers = case_of(seed), DRIVELINES[WORDS[name]]
    machine = case.drawn.vehicle.machine._replace(front_drive=numbers["front_drive"])
    driven = replace(case, drawn=replace(case.drawn, vehicle=replace(case.drawn.vehicle, machine=machine)))
    log = log_of(driven, kind, NUMBERS[kind], {"locked_centre": bool(numbers["centre_lock"])})
    noisy = add_noise(log.drive, "good", 1000 * seed + 7)
    bare = {channel: values for channel, values in noisy.channels.items() if channel not in WHEEL_CHANNELS}
    label = f"{seed} {kind} {name}, {log.soil.name} n {log.n:.2f}"
    try:
        found = estimate(Recording(noisy.name, bare), bicycle(load_vehicle(file), log.soil), GUESS)
    except ValueError as error:
        print(f"{label}: refused, {error}", flush=True)
        return None
    verdict, off = found.verdict, float(found.n_front[-1] / log.n - 1.0)
    if verdict is None or verdict.evidence is None:
        raise ValueError(f"{label}: expected a verdict with its evidence, found {verdict}")
    right, windows = f"; {WORDS[name]}, as the log" in verdict.reason, float(verdict.evidence.n[0] / log.n - 1.0)
    print(
        f"{label}: filter {100 * off:+.1f} %, windows {100 * windows:+.1f} %, {verdict.word}, driveline "
        f"{'right' if right else 'WRONG'}",
        flush=True,
    )
    return verdict.word, off, right


if __name__ == "__main__":
    main()
