"""`softsoil identify` judged on the reference vehicle of the shared drives, from what an owner knows of it.

Run: python -m benchmarks.identify_reference ../shared/data/chrono_vehicle [--effects] [--vehicle FILE]
Known: mass, axle loads, design track, wheels and height of the centre of gravity (README of the drives, the given numbers of
vehicles/paper.toml) and `[simulator]`; no effect and no number that logs have identified. Fitted: of each kind that excites (full
lock and multi-sine) and each soil class with both, the drive that comes first by name. Everything else is judged, sand and the
step drives among it; how: `benchmarks/judges/identified.py`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.judges.identified import Case, add_options, run
from benchmarks.judges.true_soil import nominal_logs
from benchmarks.refine_drives import EFFECTS
from softsoil.refinement.known_vehicle import Known
from softsoil.symbolic.vehicle import load_vehicle

KNOWN = Known(
    "reference",
    {
        "mass": 1378.33, "l_f": 1.546, "l_r": 1.175, "track": 1.232, "radius": 0.330229, "width": 0.2121, "h_cg": 0.63,
        "max_steer": 0.47, "max_steer_rate": 1.0,
    },
    file="vehicles/paper.toml",
    simulator=load_vehicle("reference").simulator,
)  # fmt: skip

FITTED = ("multi_clay_n0.50", "multi_sandyloam_n0.55", "paper_clay_n0.50", "paper_sandyloam_n0.70")
HELD = "multi_clay_n0.65"


def main() -> None:
    """Identify, judge and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder of the reference drives")
    add_options(parser, "runs/identify_reference.toml")
    asked = parser.parse_args()
    case = Case(
        known=KNOWN,
        fitted=FITTED,
        held=HELD,
        nominal=tuple(nominal_logs(asked.folder)),
        tracks=(1.232, 1.232),
        effects=EFFECTS,
    )
    run(case, asked)


if __name__ == "__main__":
    main()
