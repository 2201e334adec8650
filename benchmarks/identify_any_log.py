"""`softsoil identify` on logs that lack channels, are slow, or are wrong: what it says, and what its file then makes of n.

    python -m benchmarks.identify_any_log ../shared/data/chrono_vehicle [--only NAME ...]

The reference vehicle from what an owner knows of it, on two drives with the noise "good" and a third on which `identify` judges
itself; each change is made to all three. Judged on other drives, unchanged but for Table-5 noise: n by the horizon from one
initial guess with its verdict.
"""

from __future__ import annotations

import argparse
import tempfile
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.absent_channels import WITHOUT
from benchmarks.hostile_logs import short
from benchmarks.identify_reference import KNOWN
from benchmarks.judges.vehicle_judge import without
from softsoil.cases.hostile import VARIANTS, variant
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.estimate import estimate
from softsoil.identification.identify import identify
from softsoil.identification.result import Identification
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive, write_drive
from softsoil.symbolic.soil import load_soil
from softsoil.symbolic.vehicle import Vehicle

DRIVES = ("multi_sandyloam_n0.55", "paper_clay_n0.50", "multi_clay_n0.65")
"""Drives that `identify` is given; the last judges."""
JUDGED = ("multi_clay_n0.50", "paper_clay_n0.70", "multi_sandyloam_n0.70", "paper_sandyloam_n0.90")
OWNED = replace(KNOWN, driveline={"centre_lock": 1.0, "front_drive": 0.5})
"""Its owner knows which wheels are driven, too: logs without wheel speeds need it."""
GUESS = 0.9
RIGHT = 0.1
"""Share of n beyond which an estimate must not be called identified."""
TABLE5 = "noise of Table 5"
SLOW = ("10 Hz", 8)
LONG = "a million rows"

Change = Callable[[Recording], Recording]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", help="names of changes")
    arguments = parser.parse_args()
    changes = {name: change for name, change in all_changes().items() if not arguments.only or name in arguments.only}
    for row in table(arguments.folder, changes):
        print(row, flush=True)


def all_changes() -> dict[str, Change]:
    """Name -> what is done to every log that `identify` is given, noise included."""
    changes: dict[str, Change] = {"nothing": lambda drive: drive}
    changes |= {f"without {name}": partial(without, absent=channels) for name, channels in WITHOUT.items() if channels}
    changes[SLOW[0]] = lambda drive: replace(drive, channels={k: v[:: SLOW[1]] for k, v in drive.channels.items()}, truth={})
    changes[TABLE5] = lambda drive: drive
    return changes | {v.name: variant(v.name).of for v in VARIANTS if v.name != LONG}


def table(folder: Path, changes: dict[str, Change]) -> Iterator[str]:
    """Rows of the table, as text."""
    yield "| change | `identify` | yaw inertia | n of other drives: median, worst | identified, wrongly | what is said |"
    yield "|---|---|---|---|---|---|"
    for name, change in changes.items():
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always", UserWarning)
            try:
                found = identified(folder, name, change)
            except ValueError as error:
                yield f"| {name} | refused | | | | {short(str(error))} |"
                continue
        words = [str(w.message) for w in said if w.category is UserWarning]
        words = [found.reason, *words] if found.verdict != "identified" else words or list(found.notes)
        inertia = found.numbers["yaw_inertia"]
        n = judged(folder, found.vehicle)
        errors, sure = np.abs([error for error, _ in n]), np.array([usable for _, usable in n])
        yield (
            f"| {name} | {found.verdict} | {inertia.value:.0f} ± {inertia.std:.0f} {inertia.state} "
            f"| {100 * np.median(errors):.1f} %, {100 * errors.max():.1f} % | {sure.sum()} of {len(n)}, "
            f"{int(np.sum(errors[sure] > RIGHT))} | {short(words[0]) if words else ''} |"
        )


def identified(folder: Path, name: str, change: Change) -> Identification:
    """The vehicle by `identify` from the changed drives."""
    noise = "table5" if name == TABLE5 else "good"
    drives = [change(add_noise(read_drive(folder / f"{log}.csv.gz"), noise, 10 * i)) for i, log in enumerate(DRIVES)]
    with tempfile.TemporaryDirectory() as place:
        files = [write_drive(drive, Path(place) / f"{log}.parquet") for log, drive in zip(DRIVES, drives, strict=True)]
        try:
            return identify(files, [load_soil(str(named_soil(log))) for log in DRIVES], OWNED)
        except ValueError as error:
            raise ValueError(str(error).replace(f"{place}/", "")) from None


def judged(folder: Path, vehicle: Vehicle) -> list[tuple[float, bool]]:
    """Error of n as a share, and whether it is called identified, on each drive of JUDGED."""
    out = []
    for i, name in enumerate(JUDGED):
        model = Declaration(vehicle, load_soil(str(named_soil(name)))).build()
        drive = add_noise(read_drive(folder / f"{name}.csv.gz"), "table5", 100 + i)
        found = estimate(drive, model, GUESS, method="horizon", start=2.0)
        error = float(found.n_front[-1]) / float(named_n(name) or np.nan) - 1.0
        out.append((error, found.verdict is not None and found.verdict.usable))
    return out


if __name__ == "__main__":
    main()
