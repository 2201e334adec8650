"""Closed loop over seeds, soils, speeds and first guesses: `python -m benchmarks.nmpc_study --seeds 10` (about 30 minutes).

`--sensors all`: wheel speeds, accelerometer and steering angle are noisy too; `--vehicle heavy`: a vehicle of 3 t on courses of
its size; `--drawn SEED`: a vehicle of the plant by that seed, driven by what `identify` makes of its logs
(`benchmarks.identify_plant`); `--hessian exact`: of the real-time iterations; `--guess low`: only first guesses below the truth;
`--weave 135`: so many metres of weave before each manoeuvre in the place of 45.
Each combination has its own file in OUT, in which every drive is kept as a line as it ends: a study that was stopped goes on.
Seeds start at 100; the estimator's numbers in the loop were chosen on seeds 0 to 2 at other speeds.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from benchmarks.identify_plant import identified
from benchmarks.judges.plant_vehicles import case_of
from softsoil.commands.drive import loop_for
from softsoil.commands.output import console
from softsoil.control.c_controller import HESSIANS
from softsoil.control.courses import WARM_UP
from softsoil.control.declared import for_control
from softsoil.declaration.model_file import Declaration
from softsoil.figures.closed_loop_study import draw_study, say_study
from softsoil.mpc_demo.closed_loop import ClosedLoop
from softsoil.mpc_demo.closed_loop_parts import SENSORS
from softsoil.mpc_demo.closed_loop_study import STUDY, Case, Run
from softsoil.mpc_demo.scenarios import size_of
from softsoil.plant.drawn_vehicle import DrawnVehicle
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

FIRST_SEED = 100


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10, help="how many")
    parser.add_argument("--out", type=Path, default=Path("runs/nmpc_study"), help="folder")
    parser.add_argument("--hessian", default=HESSIANS[0], choices=HESSIANS, help="of the real-time iterations")
    parser.add_argument("--sensors", default="states", choices=SENSORS, help="which are noisy")
    parser.add_argument("--vehicle", default="plant", help="declared vehicle, of the model and of the plant")
    parser.add_argument("--drawn", type=int, metavar="SEED", help="a drawn vehicle, identified, in the place of --vehicle")
    parser.add_argument("--guess", default="both", choices=("both", "low"), help="sides of the truth of the first guess")
    parser.add_argument("--weave", type=float, default=WARM_UP, help="m of weave before the manoeuvre, for a vehicle of size 1")
    parser.add_argument("--report", action="store_true", help="only the table and figure of what has been driven")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    chosen = options.vehicle if options.drawn is None else f"drawn_{options.drawn}"
    name = f"{chosen}_{options.sensors}_{options.hessian}" + (f"_{options.weave:g}" if options.weave != WARM_UP else "")
    kept = options.out / f"{name}.jsonl"
    runs = [Run(**json.loads(line)) for line in kept.read_text(encoding="utf-8").splitlines()] if kept.is_file() else []
    if not options.report:
        vehicle, drawn = load_vehicle(options.vehicle), None
        if options.drawn is not None:
            case, file = case_of(options.drawn), options.out / f"vehicle_{options.drawn}.toml"
            vehicle, drawn = load_vehicle(file) if file.is_file() else identified(case, file), case.drawn
        cases = [case.enlarged(size_of(vehicle)).after(options.weave) for case in STUDY]
        loops = Loops(vehicle, options.hessian, options.sensors, drawn)
        drive_missing(runs, kept, options.seeds, cases, loops, ("low", "high") if options.guess == "both" else ("low",))
    say_study(runs)
    console.print(f"wrote {draw_study(runs, options.out / f'{name}.png')}", soft_wrap=True, highlight=False)


class Loops:
    """The closed loop of each soil class, made when it is first needed.

    vehicle: declared; hessian: of the solver; sensors: which are noisy; drawn: the plant's vehicle where it is a drawn one.
    """

    def __init__(self, vehicle: Vehicle, hessian: str, sensors: str, drawn: DrawnVehicle | None = None) -> None:
        self._vehicle, self._hessian, self._sensors, self._drawn = vehicle, hessian, sensors, drawn
        self._made: dict[str, ClosedLoop] = {}

    def of(self, believed: Soil) -> ClosedLoop:
        """The loop whose controllers believe in a soil class."""
        if believed.name not in self._made:
            declared = for_control(Declaration(self._vehicle, believed))
            self._made[believed.name] = loop_for(declared, hessian=self._hessian, noisy=self._sensors, drawn=self._drawn)
        return self._made[believed.name]


def drive_missing(
    runs: list[Run], kept: Path, seeds: int, cases: Sequence[Case], loops: Loops, sides: Sequence[str]
) -> None:  # fmt: skip
    """Drive what is not among `runs` yet, added to them and to the file; seeds outermost."""
    done = {(run.case, run.told, run.seed) for run in runs}
    with kept.open("a", encoding="utf-8") as file:
        for seed in range(FIRST_SEED, FIRST_SEED + seeds):
            for case in cases:
                for told, side, controller in drives(case, sides):
                    if (case.name, told, seed) in done:
                        continue
                    course = case.scenario(side)
                    run = Run.of(case.name, told, loops.of(course.believed).run(course, controller, seed, case.faults))
                    runs.append(run)
                    file.write(json.dumps(run.as_json()) + "\n")
                    file.flush()
            console.print(f"seed {seed} done", highlight=False)


def drives(case: Case, sides: Sequence[str]) -> list[tuple[str, str, str]]:
    """(told, side of the guess, controller) of each drive of a case."""
    found = [("true", case.sides[0], "n_true")]
    for side in (side for side in case.sides if side in sides):
        found += [(side, side, "n_guess"), (f"est_{side}", side, "n_estimated")]
    return found


if __name__ == "__main__":
    main()
