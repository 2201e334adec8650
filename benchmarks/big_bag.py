"""Memory and time of an import from a bag that is mostly images and point clouds.

    python -m benchmarks.big_bag [--megabytes 1000] [--kinds mcap sqlite3 rosbag1]

The bag of each kind is written into a temporary folder and removed after its import. The import is the command's own, in a
process of its own; the peak memory is that process's, with the interpreter and all libraries.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.judges.messy_bags import BALLAST_BYTES, edited, write_bag
from softsoil.files.package_data import LOGS
from softsoil.importing.bring_in import inspect_sources
from softsoil.importing.draft_map import draft
from softsoil.recording.read import read_drive

MOST_MEGABYTES = 500.0
"""MB: peak memory of an import, whatever the size of the bag."""
CHILD = """
import resource, sys
from softsoil.commands.start import main
sys.argv = ["softsoil", *sys.argv[1:]]
try:
    main()
finally:
    print("peak", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def main() -> int:
    """Print one row per kind of bag; 1 where an import takes more than MOST_MEGABYTES."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--megabytes", type=int, default=1000)
    parser.add_argument("--kinds", nargs="*", default=["mcap", "sqlite3"], choices=["mcap", "sqlite3", "rosbag1"])
    arguments = parser.parse_args()
    print("| bag | MB | rows | peak MB | import s | inspect s |\n|---|---|---|---|---|---|")
    worst = 0.0
    for kind in arguments.kinds:
        with tempfile.TemporaryDirectory() as folder:
            worst = max(worst, imported(kind, arguments.megabytes, Path(folder)))
    print(f"peak {worst:.0f} MB, limit {MOST_MEGABYTES:.0f} MB")
    return 0 if worst <= MOST_MEGABYTES else 1


def imported(kind: str, megabytes: int, folder: Path) -> float:
    """Peak memory (MB) of the import of a bag of a kind and size (MB) in a folder, its row printed."""
    bag = folder / ("big.bag" if kind == "rosbag1" else "big")
    write_bag(read_drive(LOGS / "multi_clay_n0.50.parquet"), bag, kind, ballast=megabytes * 1_000_000 // BALLAST_BYTES)
    size = sum(path.stat().st_size for path in ([bag] if bag.is_file() else bag.iterdir())) / 1e6
    began = time.perf_counter()
    text = edited(draft(inspect_sources([bag])))
    looked = time.perf_counter() - began
    plan = folder / "map.toml"
    plan.write_text(text, encoding="utf-8")
    began = time.perf_counter()
    peak = peak_of("import", str(bag), "--map", str(plan), "--align", "--out", str(folder / "out"))
    seconds = time.perf_counter() - began
    rows = len(read_drive(folder / "out" / "drive.parquet"))
    print(f"| {kind} | {size:.0f} | {rows} | {peak:.0f} | {seconds:.1f} | {looked:.1f} |", flush=True)
    return peak


def peak_of(*words: str) -> float:
    """Peak memory (MB) of a command of softsoil in a process of its own. Raises ValueError where the command fails."""
    done = subprocess.run([sys.executable, "-c", CHILD, *words], capture_output=True, text=True, check=False)
    if done.returncode:
        raise ValueError(f"softsoil {' '.join(words)}: expected exit code 0, found {done.returncode}: {done.stderr[-500:]}")
    kilobytes = float(next(line for line in done.stdout.splitlines() if line.startswith("peak ")).split()[1])
    return kilobytes / (1e3 if sys.platform != "darwin" else 1e6)


if __name__ == "__main__":
    sys.exit(main())
