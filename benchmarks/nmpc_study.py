"""Closed loop over seeds, soils, speeds and first guesses: `python -m benchmarks.nmpc_study --seeds 10` (about 30 minutes).

Every drive is kept as a line of OUT/runs.jsonl as it ends: a study that was stopped goes on where it stood. Seeds start
at 100; the estimator's numbers in the loop were chosen on seeds 0 to 2 at other speeds.
"""

import argparse
import json
from pathlib import Path

from softsoil.commands.drive import loop_for
from softsoil.commands.options_model import REFERENCE_VEHICLE
from softsoil.commands.output import console
from softsoil.control.c_controller import HESSIANS
from softsoil.figures.closed_loop_study import draw_study, say_study
from softsoil.mpc_demo.closed_loop import ClosedLoop
from softsoil.mpc_demo.closed_loop_study import STUDY, Case, Run
from softsoil.symbolic.declaration import Declaration
from softsoil.symbolic.vehicle import load_vehicle

FIRST_SEED = 100


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10, help="how many")
    parser.add_argument("--out", type=Path, default=Path("runs/nmpc_study"), help="folder")
    parser.add_argument("--hessian", default="exact", choices=HESSIANS, help="of the real-time iterations")
    parser.add_argument("--report", action="store_true", help="only the table and figure of what has been driven")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    kept = options.out / "runs.jsonl"
    runs = [Run(**json.loads(line)) for line in kept.read_text(encoding="utf-8").splitlines()] if kept.is_file() else []
    if not options.report:
        runs = drive_missing(runs, kept, options.seeds, options.hessian)
    say_study(runs)
    console.print(f"wrote {draw_study(runs, options.out / 'nmpc_study.png')}", soft_wrap=True, highlight=False)


def drive_missing(runs: list[Run], kept: Path, seeds: int, hessian: str) -> list[Run]:
    """The drives of the study that are not among `runs` yet, added to them and to the file; seeds outermost."""
    done = {(run.case, run.told, run.seed) for run in runs}
    loops: dict[str, ClosedLoop] = {}
    with kept.open("a", encoding="utf-8") as file:
        for seed in range(FIRST_SEED, FIRST_SEED + seeds):
            for case in STUDY:
                for told, side, controller in drives(case):
                    if (case.name, told, seed) in done:
                        continue
                    course = case.scenario(side)
                    soil = course.believed.name
                    if soil not in loops:
                        loops[soil] = loop_for(Declaration(load_vehicle(REFERENCE_VEHICLE), course.believed), hessian=hessian)
                    run = Run.of(case.name, told, loops[soil].run(course, controller, seed, case.faults))
                    runs.append(run)
                    file.write(json.dumps(run.as_json()) + "\n")
                    file.flush()
            console.print(f"seed {seed} done", highlight=False)
    return runs


def drives(case: Case) -> list[tuple[str, str, str]]:
    """(told, side of the guess, controller) of each drive of a case."""
    found = [("true", case.sides[0], "n_true")]
    for side in case.sides:
        found += [(side, side, "n_guess"), (f"est_{side}", side, "n_estimated")]
    return found


if __name__ == "__main__":
    main()
