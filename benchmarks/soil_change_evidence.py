"""How sure a change of soil looks where there is none, and where there is one, on drives of the plant.

`python -m benchmarks.soil_change_evidence clean|outside|ground_change SEED [SEED ...]`: the blind test's drives of that kind, or
with that effect. For each, the best place of a change, its size by all windows, the standard errors that it stands from absence
(against `place_sigmas` of `refinement/rules.py`) and its held-out gain. The true change is printed and not used.
"""

from __future__ import annotations

import argparse

from softsoil.mpc_demo.blind_cases import BORDER, INSIDE, draw_cases, drive_case
from softsoil.mpc_demo.blind_test import plant_on
from softsoil.refinement.doubts import loosened
from softsoil.refinement.folds import cross_validated
from softsoil.refinement.ranking import try_places
from softsoil.refinement.selection import strength
from softsoil.refinement.trace import make_bench
from softsoil.symbolic.catalogue import catalogue

START_UP = 2.0
DRIVES = 40


def main() -> None:
    """Print one line a drive, and the largest evidence last."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=("clean", "outside", *INSIDE))
    parser.add_argument("seeds", type=int, nargs="+")
    told = parser.parse_args()
    most = 0.0
    for case in (case for seed in told.seeds for case in draw_cases(DRIVES, seed)):
        if told.kind not in (case["kind"], case["name"]):
            continue
        declared = plant_on(case["soil"])
        bench, _ = loosened(make_bench([drive_case(case)], declared, START_UP), declared.vehicle)
        effect = catalogue(declared.vehicle)["soil_change"]
        (found,) = cross_validated(bench, [try_places(bench, effect)])
        assert found.overall is not None
        sigmas, (size, _) = strength(found.overall, effect), found.overall.named()["n_change"]
        most, true = max(most, sigmas), case["truth"] if case["name"] == BORDER else 0.0
        print(
            f"{case['seed']:3d} {case['index']:2d} {case['name'] or 'clean':12s} {case['soil']:10s} n {case['n']:.2f}: "
            f"n_change {size:+.3f}, {sigmas:.1f} standard errors, "
            f"held-out gain {100 * found.gain:.0f} ± {100 * found.std:.0f} %; true {true:+.3f}",
            flush=True,
        )
    print(f"at most {most:.1f} standard errors")


if __name__ == "__main__":
    main()
