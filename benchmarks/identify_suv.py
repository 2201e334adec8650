"""`softsoil identify` judged on the second vehicle of the shared drives, from what its README says that an owner knows.

Run: python -m benchmarks.identify_suv [--data ../shared/data] [--effects] [--vehicle FILE]
Fitted: one lock and one multi-sine drive. How it is judged: `benchmarks/judges/identified.py`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.judges.identified import CONTACT_SEARCH, Case, add_options, run
from benchmarks.judges.true_soil import drive_name
from softsoil.recording.log_names import named_n
from softsoil.recording.read import read_drive
from softsoil.refinement.known_vehicle import Known
from softsoil.symbolic.vehicle import load_vehicle

KNOWN = Known(
    "suv",
    {
        "mass": 1943.0, "l_f": 1.466, "l_r": 1.805, "track": 1.83, "track_rear": 1.935, "radius": 0.405, "width": 0.235,
        "h_cg": 0.7,
    },
    file="data/chrono_suv/README.md",
    simulator=load_vehicle("reference").simulator,
    search=CONTACT_SEARCH,
)  # fmt: skip
FITTED = ("suv_lock_clay_n0.55", "suv_multi_sandyloam_n0.65")
HELD = "suv_multi_clay_n0.50"
EFFECTS = {
    "suv_effect_bank": ("bank", "sandy_loam", {"bank": 0.0698}),
    "suv_effect_steer_lag": ("steering_lag", "clay", {"steering_lag": 0.2}),
    "suv_effect_payload": ("payload", "clay", {"payload_mass": 350.0}),
    "suv_effect_yaw_moment": ("yaw_moment", "sandy_loam", {"yaw_moment": 1000.0}),
    "suv_effect_steer_offset": ("steering_offset", "clay", {"steering_offset": 0.0469}),
}
"""Drive -> effect, soil class, parameters (README of the drives; the offset as the road wheels have it, `_offset`)."""


def main() -> None:
    """Identify, judge and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data"), help="folder of the shared data")
    add_options(parser, "runs/identify_suv.toml")
    asked = parser.parse_args()
    drives = sorted((asked.data / "chrono_suv").glob("suv_*.csv.gz"))
    case = Case(
        known=KNOWN,
        fitted=FITTED,
        held=HELD,
        nominal=tuple(path for path in drives if named_n(drive_name(path)) is not None),
        tracks=(1.90, 1.935),
        effects=EFFECTS,
    )
    if asked.effects or asked.only_effects:
        _offset(asked.data / "chrono_suv")
    run(case, asked)


def _offset(folder: Path) -> None:
    """The steering offset as the road wheels have it: mean of their true angles over `steer`, which its README rounds."""
    for name in ("suv_effect_steer_offset", HELD):
        drive = read_drive(folder / f"{name}.csv.gz")
        rows = drive.t > 2.0
        wheels = 0.5 * (drive.truth["true_delta_fl"] + drive.truth["true_delta_fr"])
        print(f"{name}: road wheels beyond steer {float(np.mean((wheels - drive['steer'])[rows])):+.4f} rad in the mean")


if __name__ == "__main__":
    main()
