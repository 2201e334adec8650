"""Every hostile variant of a good log as a command opens it: refused, warned about, or what n comes out.

    python benchmarks/hostile_logs.py [--log data/multi_clay_n0.50.parquet] [--write docs/reference/any-log.md]
        [--vehicle runs/identify_suv.toml] [--noise good]

Another vehicle's log, with its file as `softsoil identify` wrote it, and with the noise of a sensor set. With --write the table
replaces what stands between the marks in that document.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from softsoil.cases.hostile import VARIANTS, Variant
from softsoil.checking.usable import checked
from softsoil.estimator.estimate import estimate
from softsoil.estimator.terrain import estimate_terrain
from softsoil.files.package_data import LOGS, REFERENCE_VEHICLE
from softsoil.recording.derive import completed
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import NOISES, add_noise
from softsoil.recording.read import read_drive, write_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import SOILS
from softsoil.symbolic.vehicle import load_vehicle

MARKS = ("<!-- hostile logs: begin -->", "<!-- hostile logs: end -->")
LONG = 100_000
"""Rows beyond which only the filter runs, and no verdict is asked for."""
RIGHT = 0.1
"""Share of the good log's n within which an estimate counts as right."""


def main() -> None:
    """Run all variants, print the table, write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--log", type=Path, default=LOGS / "multi_clay_n0.50.parquet")
    parser.add_argument("--vehicle", type=Path, default=REFERENCE_VEHICLE)
    parser.add_argument("--noise", default="none", choices=sorted(NOISES))
    parser.add_argument("--write", type=Path)
    parser.add_argument("--skip", nargs="*", default=[], help="names of variants to leave out")
    arguments = parser.parse_args()
    good = add_noise(read_drive(arguments.log), arguments.noise, 1)
    vehicle, soil = load_vehicle(arguments.vehicle), SOILS[named_soil(good.name) or "clay"]
    model = bicycle(vehicle, soil)

    def n_of(drive: Recording) -> tuple[float, str]:
        first = float(soil.n) + 0.2
        if len(drive) > LONG:
            return float(estimate_terrain(drive, model, first, tied=True, start=2.0).n_front[-1]), "not asked"
        found = estimate(drive, model, first)
        return float(found.n_front[-1]), found.verdict.word if found.verdict is not None else "none"

    reference, word = n_of(good)
    rows = [f"Good log: {good.name}, n = {reference:.3f} (true {named_n(good.name)}), verdict {word}.", "",
            "| variant | outcome | n | verdict | what is said |", "|---|---|---|---|---|"]  # fmt: skip
    counts = {"refused": 0, "warned": 0, "right": 0, "not identified": 0, "silently wrong": 0}
    with tempfile.TemporaryDirectory() as folder:
        for variant in (v for v in VARIANTS if v.name not in arguments.skip):
            outcome, n, word, said = judged(variant, good, Path(folder) / "log.parquet", vehicle, n_of, reference)
            counts[outcome.split(",")[0]] += 1
            rows.append(f"| {variant.name} | {outcome} | {n} | {word} | {said} |")
            print(rows[-1], flush=True)
    rows += [
        "",
        f"{sum(counts.values())} variants: " + ", ".join(f"{value} {key}" for key, value in counts.items()) + ".",
    ]
    print(rows[-1])
    if arguments.write:
        text = arguments.write.read_text(encoding="utf-8")
        before, rest = text.split(MARKS[0])
        after = rest.split(MARKS[1])[1]
        arguments.write.write_text(f"{before}{MARKS[0]}\n" + "\n".join(rows) + f"\n{MARKS[1]}{after}", encoding="utf-8")


def judged(
    variant: Variant, good: Recording, path: Path, vehicle, n_of, reference: float
) -> tuple[str, str, str, str]:
    """Outcome, n, verdict and what is said of one variant, read from a file at `path` as a command does."""
    write_drive(variant.of(good), path)
    try:
        drive = read_drive(path)
        drive, doubts = checked(drive, vehicle)
        n, word = n_of(completed(drive, vehicle))
    except ValueError as error:
        return "refused", "", "", short(str(error).replace(str(path), "log"))
    right = abs(n - reference) < RIGHT * reference
    if doubts:
        more = f" (and {len(doubts) - 1} more)" if len(doubts) > 1 else ""
        return ("warned, n right" if right else "warned, n wrong"), f"{n:.3f}", word, short(doubts[0]) + more
    outcome = "right" if right else "silently wrong" if word == "identified" else "not identified"
    return outcome, f"{n:.3f}", word, ""


def short(words: str) -> str:
    """Words as a cell of a table, cut where they are long."""
    words = words.replace("|", "/")
    return words if len(words) <= 150 else words[:147] + "..."


if __name__ == "__main__":
    main()
