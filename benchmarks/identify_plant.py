"""`softsoil identify` judged blindly on vehicles of the plant drawn by seed, from what an owner with scale and tape says of them.

Run: python -m benchmarks.identify_plant [--seeds 3] [--first 100] [--effects | --only-numbers] [--logs multi,lock]
    [--vehicles FOLDER] [--again --only-effects] [--switches load_carried,nothing] [--noise good] [--fit-noise good]
    [--absent v] [--judged-absent v] [--robots] [--lag 0.1] [--late 0.03] [--anew] [--rear-wheel 1.15,1.3] [--front-drive 0]
Per seed a vehicle (600 to 4000 kg, wheels of 0.25 to 0.6 m, wheelbase 1.8 to 3.6 m, either suspension at either axle),
measured with its errors; with --robots one of 180 to 350 kg; with --rear-wheel its rear wheels have so many times the radius
and the width of the front ones; with --front-drive, and with larger rear wheels, an open centre. Fitted: one lock and one
multi-sine drive with the noise "good" or --fit-noise, less --absent, on soils and n drawn by the seed, beside one that the
identification leaves out. Judged, on three other drives on other n with Table-5 noise (robots: "good", their lateral velocity
is less than Table 5's noise): n by windows and by the filter, verdicts, predictions over 2.5 s from clean states; the yaw
inertia against what the true wheel forces of the fitted logs balance with; with --effects, what `refine` names on drives with
a payload, a steering offset, a bank and a steering lag, on drives without one, and on ground of the other kind, and its
verdicts on n: right is what is named with a size at most 20 % off. Each is met on the drives of --logs, traced in one call,
each on a soil of its own; and what `estimate`, and the vehicle's generated library, say of n on each of these drives alone,
the library while driving, too. True values are read to judge only.
Looked at were seeds 0 to 2 while this command was made; 100, 101 and 104 while the rules of contradiction were; 100 to 102
while loads were looked at a second time; 200 to 202 while their sizes were; all of these, 105, 106, 110 to 118 while the
strain of the numbers was; many of these, 120 to 128 and 134 while the load was that a drive must show; 400 to 402, 500 and
501 while the body's roll_time was; the others were not.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.judges.library_look import by_library
from benchmarks.judges.plant_vehicles import FIT, JUDGE, ROBOTS, Case, Log, case_of, effects_of, inertia_of, log_of
from benchmarks.judges.vehicle_judge import TRUSTED, Judgement, joined, judge_drive, lines, without, words
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.estimate import METHODS, estimate
from softsoil.estimator.verdict import IDENTIFIED
from softsoil.identification.identify import identify
from softsoil.identification.vehicle_toml import vehicle_toml
from softsoil.mpc_demo.blind_test import as_the_catalogue_says, relative_error, score
from softsoil.plant.drawn_vehicle import DRAW
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.refinement.doubts import grounds
from softsoil.refinement.refine import refine
from softsoil.refinement.result import Refinement
from softsoil.refinement.trace import Candidate
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

FIRST_JUDGE, FIRST_EFFECT = 10, 20
"""Numbers of the drives that judge and of those with an effect."""
BETWEEN = 100
"""Between the numbers of drives with the same effect."""
NOTHING = "nothing"
"""What a drive without an effect is called."""
GROUND = "shears_anew"
"""Switch of a drive on the other kind of ground than that of the logs which the vehicle is identified from."""
SIZE = 0.2
"""Error of an effect's size, as a share, that is right at most."""
LOCKED = {"centre_lock": 1.0, "front_drive": 0.5}
"""The driveline of a vehicle whose axles turn alike, as its owner knows it."""


@dataclass(frozen=True)
class Traced:
    """What became of an effect: its switch or "nothing", whether it was named with its size; of the n of its drives, by `refine`
    and by `estimate` alone, how many were wrongly called identified, and of how many."""

    switch: str
    right: bool
    wrong: int
    drives: int
    wrong_alone: int
    alone: int


def main() -> None:
    """Identify, judge and print, vehicle by vehicle."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3, help="how many vehicles")
    parser.add_argument("--first", type=int, default=100, help="seed of the first")
    parser.add_argument("--effects", action="store_true", help="trace drives with an effect, too")
    parser.add_argument("--logs", default="multi,lock", help="manoeuvres of the drives traced together")
    parser.add_argument("--switches", default="", help="effects that are met, or \"nothing\"; default all")
    parser.add_argument("--noise", default="good", help="of the drives with an effect and of those without one")
    parser.add_argument("--fit-noise", default="good", help="of the logs that the vehicle is identified from")
    parser.add_argument("--absent", default="", help="channels that those logs lack, as v,x,y,psi")
    parser.add_argument("--judged-absent", default="", help="channels that those lack on which n is judged")
    parser.add_argument("--lag", type=float, default=0.0, help="time constant (s) of a late steering, but in traced logs")
    parser.add_argument("--late", type=float, default=0.0, help="s by which the steering is recorded late, but in traced logs")
    parser.add_argument("--anew", action="store_true", help="soil that shears anew in ruts, but in traced logs")
    parser.add_argument("--only-effects", action="store_true", help="trace only, with --again")
    parser.add_argument("--only-numbers", action="store_true", help="identify only: no other drives")
    parser.add_argument("--vehicles", type=Path, default=Path("runs/identify_plant"), help="folder of the identified files")
    parser.add_argument("--robots", action="store_true", help="light robots in the place of cars and trucks")
    parser.add_argument("--rear-wheel", default="1,1", help="radius and width of rear wheels over those of front ones")
    parser.add_argument("--front-drive", type=float, help="share of the torque at the front axle behind an open centre")
    parser.add_argument("--again", action="store_true", help="judge the files in the folder in the place of new ones")
    asked = parser.parse_args()
    asked.vehicles.mkdir(parents=True, exist_ok=True)
    inertias, departures, judged, named = [], [], [], []
    radius, width = map(float, asked.rear_wheel.split(","))
    drawn = replace(ROBOTS if asked.robots else DRAW, rear_wheel=(radius, width), front_drive=asked.front_drive)
    for seed in range(asked.first, asked.first + asked.seeds):
        case, file = case_of(seed, drawn), asked.vehicles / f"vehicle_{seed}.toml"
        print(_words(case), flush=True)
        steering = Steering(asked.lag, asked.late, asked.anew)
        try:
            vehicle = load_vehicle(file) if asked.again else identified(case, file, asked.fit_noise, asked.absent, steering)
        except ValueError as refusal:  # as of a log on which the wheels dug themselves in
            print(f"  refused: {refusal}", flush=True)
            continue
        true, bodies = inertia_of(case, fitted_logs(case, steering)), case.drawn.vehicle.yaw_inertia
        off = 100 * (vehicle.yaw_inertia / true - 1)
        inertias.append(off)
        joint = vehicle.joint_error
        std = 100 * joint.std[joint.names.index("yaw_inertia")] / vehicle.yaw_inertia if joint else np.nan
        departures.append(off / std)
        rolls = 100 * (vehicle.radius / case.drawn.measured["radius"] - 1)
        print(
            f"  yaw inertia {vehicle.yaw_inertia:.0f}, the true forces balance with {true:.0f}: {off:+.1f} % "
            f"({off / std:+.1f} standard deviations of the joint error; its bodies have {bodies:.0f}); "
            f"radius {rolls:+.2f} % of {case.drawn.measured['radius']:.4f} m"
        )
        if not (asked.only_effects or asked.only_numbers):
            noise = "good" if asked.robots else "table5"
            judged.append(_judged(case, vehicle, asked.judged_absent.split(","), noise, steering))
        if asked.effects or asked.only_effects:
            switches = asked.switches.split(",") if asked.switches else []
            named += _traced(case, vehicle, asked.logs.split(","), switches, asked.noise)
    print(f"{len(inertias)} vehicles of the seeds {asked.first} to {asked.first + asked.seeds - 1}")
    if not inertias:
        return
    size = np.abs(inertias)
    print(f"yaw inertia: median {np.median(size):.1f} %, worst {size.max():.1f} % off what balances; in standard "
          f"deviations of the joint error {np.sqrt(np.mean(np.square(departures))):.1f} (rms)")
    if judged:
        print(*lines(joined(judged)), sep="\n")
    if named:
        counts = ("wrong", "drives", "wrong_alone", "alone")
        wrong, drives, wrong_alone, alone = (sum(getattr(one, count) for one in named) for count in counts)
        print(f"{sum(one.right for one in named)} of {len(named)} pairs of drives traced rightly; "
              f"{wrong} of {drives} n called identified and more than 10 % off; by `estimate` alone {wrong_alone} of {alone}")
        kinds = {kind: [one.right for one in named if one.switch == kind] for kind in sorted({one.switch for one in named})}
        print(*(f"{kind} {sum(right)} of {len(right)}" for kind, right in kinds.items()), sep="; ")


def _words(case: Case) -> str:
    m = case.drawn.measured
    return (
        f"seed {case.seed}: {m['mass']:.0f} kg, wheelbase {m['l_f'] + m['l_r']:.2f} m, wheels {m['radius']:.2f} x "
        f"{m['width']:.2f} m, front {case.drawn.layouts[0]}, rear {case.drawn.layouts[1]}"
    )


@dataclass(frozen=True)
class Steering:
    """A steering that follows its angle with a first-order lag (s), and an angle that is recorded late (s); anew: on soil that
    shears anew in ruts."""

    lag: float = 0.0
    late: float = 0.0
    anew: bool = False

    def log_of(self, case: Case, kind: str, number: int) -> Log:
        """A clean log of a case."""
        log = log_of(case, kind, number, {"steer_lag": self.lag, "shears_anew": self.anew})
        drive = log.drive
        return replace(log, drive=drive.with_channels(steer=np.interp(drive.t - self.late, drive.t, drive["steer"])))


def fitted_logs(case: Case, steering: Steering) -> list[Log]:
    """Clean logs for the identification of a case."""
    return [steering.log_of(case, kind, number) for number, kind in enumerate(FIT)]


def identified(
    case: Case, file: Path, noise: str = "good", absent: str = "", steering: Steering = Steering()
) -> Vehicle:
    """What `identify` makes of a case's logs by sensors with a `noise`, the channels `absent` left out, written to a file; n of
    the logs is printed."""
    began = time.perf_counter()
    logs = fitted_logs(case, steering)
    drives = [add_noise(log.drive, noise, 100 * case.seed + i) for i, log in enumerate(logs)]
    drives = [without(drive, absent.split(",")) for drive in drives]
    front = case.drawn.vehicle.machine.front_drive
    driveline = {"centre_lock": 0.0, "front_drive": front} if case.drawn.open_centre else LOCKED
    known = replace(case.known, driveline=driveline) if {*WHEEL_CHANNELS} & {*absent.split(",")} else case.known
    found = identify(drives, [log.soil for log in logs], known)
    file.write_text(vehicle_toml(found), encoding="utf-8")
    errors = ", ".join(f"{100 * (found.n[log.drive.name][0] / log.n - 1):+.1f}" for log in logs)
    print(f"  {found.verdict}: {found.reason} ({time.perf_counter() - began:.0f} s); n of its own logs {errors} %", flush=True)
    shown = ("l_f:", "radius:", "steering_lag:", "ground:")
    print(*(f"  {note}" for note in found.notes if note.startswith(shown)), sep="\n", flush=True)
    return found.vehicle


def _judged(case: Case, vehicle: Vehicle, absent: Sequence[str], noise: str, steering: Steering) -> Judgement:
    parts = []
    for number, kind in enumerate(JUDGE, FIRST_JUDGE):
        log = steering.log_of(case, kind, number)
        seed = 1000 * case.seed + number
        part = judge_drive(vehicle, case.known, log.drive, log.soil, log.n, seed, absent=absent, noise=noise)
        print(f"  {kind} {log.soil.name} n {log.n:.2f}: {words(part)}", flush=True)
        parts.append(part)
    return joined(parts)


def _traced(case: Case, vehicle: Vehicle, kinds: Sequence[str], asked: Sequence[str], noise: str) -> list[Traced]:
    """What is traced with each effect, and without one, or with those that are `asked` for, by sensors with a `noise`."""
    results: list[Traced] = []
    met = {**effects_of(case), "": ({}, {}), GROUND: ({GROUND: True}, {})}
    known = {*met, NOTHING}
    if not {*asked} <= known:
        raise SystemExit(f"--switches: expected some of {', '.join(sorted(known))}, found {', '.join(asked)}")
    for number, (switch, (settings, truth)) in enumerate(met.items(), FIRST_EFFECT):
        if asked and (switch or NOTHING) not in asked:
            continue
        numbers = [number + BETWEEN * i for i in range(len(kinds))]
        logs = [log_of(case, kind, one, settings) for kind, one in zip(kinds, numbers, strict=True)]
        drives = [add_noise(log.drive, noise, 2000 * case.seed + one) for log, one in zip(logs, numbers, strict=True)]
        declared = Declaration(vehicle, logs[0].soil)
        found = refine(drives, declared, soils=[log.soil for log in logs], workers=1)
        wanted = {"kind": "effect" if truth else "clean", "name": switch, "truth": truth.get("size")}
        called = as_the_catalogue_says(wanted, declared)
        right, why = score(called, found)
        if switch == GROUND:
            right, why = [one.name for one in found.contradicted] == [*grounds(vehicle)], _contradicted(found)
        if right and found.effects:
            sizes = [relative_error(name, value, str(called["name"]), found) for name, value in called["truth"].items()]
            right = max(map(abs, sizes)) <= SIZE
        best = ", ".join(f"{c.name} {100 * c.gain:.0f} ± {100 * c.std:.0f} %" for c in found.ranking[:3])
        if not right and switch and found.ranking:
            best += f"; with {found.ranking[0].name} {_fitted(found.ranking[0])}"
        off = [n / log.n - 1 for n, log in zip(found.n_after, logs, strict=True)]
        said = ", ".join(f"{100 * e:+.1f} % {v.word}" for e, v in zip(off, found.judged, strict=True))
        said += "" if found.strain is None else f", strain {found.strain:.1f}"
        word = "right" if right else "WRONG"
        why += _in_errors(found, called["truth"])
        print(f"  {switch or NOTHING}: {word}, {found.verdict} {why}; n {said}; best {best}", flush=True)
        wrong = sum(v.usable and abs(e) > TRUSTED for e, v in zip(off, found.judged, strict=True))
        results.append(Traced(switch or NOTHING, right, wrong, len(off), *_alone(vehicle, drives, logs)))
    return results


def _contradicted(found: Refinement) -> str:
    """Numbers that are contradicted, with what the drives make of them, and effects that are named."""
    numbers = [f"{one.name} {one.value:.2f} ± {one.std:.2f}" for one in found.contradicted]
    return " ".join([*numbers, *(effect.name for effect in found.effects)])


def _in_errors(found: Refinement, truth: Mapping[str, float]) -> str:
    """By how many of their standard errors named effects' parameters are off."""
    named = {name: entry for effect in found.effects for name, entry in effect.parameters.items()}
    off = (f"{abs(named[name][0] - true) / named[name][1]:.1f}" for name, true in truth.items() if name in named)
    return "".join(f" ({one} standard errors)" for one in off)


def _alone(vehicle: Vehicle, drives: Sequence[Recording], logs: Sequence[Log]) -> tuple[int, int]:
    """How many n of single drives, by `estimate` and by the generated library, are wrong and called identified, and of how many;
    each is printed."""
    wrong, count = 0, 0
    for drive, log in zip(drives, logs, strict=True):
        parts, change = [], None
        for method in METHODS:
            found = estimate(drive, Declaration(vehicle, log.soil).build(), method=method)
            off, said = found.n_front[-1] / log.n - 1, found.verdict
            assert said is not None, "estimate judges what it finds"
            wrong, count = wrong + (said.usable and abs(off) > TRUSTED), count + 1
            parts.append(f"{method} {100 * off:+.1f} % {said.word}")
            change = said.evidence.change if said.evidence else None
        if change is not None:
            parts.append(f"strain {change.strain:.1f}, load {100 * change.load:+.0f} ± {100 * change.load_std:.0f} % of its mass")
            c = by_library(Declaration(vehicle, log.soil), drive, log.n)
            off = c.n / log.n - 1
            wrong, count = wrong + (c.verdict == IDENTIFIED and abs(off) > TRUSTED), count + 1
            parts.append(f"in C {100 * off:+.1f} % {c.verdict}, load {100 * c.load:+.0f} %, changed at {c.changed_at:.0f} s")
            parts.append(f"identified for {c.identified_for:.0f} s, {c.wrong_for:.1f} of them {100 * TRUSTED:.0f} % off or more")
        print(f"    {drive.name} alone: {', '.join(parts)}", flush=True)
    return wrong, count


def _fitted(candidate: Candidate) -> str:
    """What the fit with a candidate, to the whole drive where there is one, makes of all that it frees."""
    fit = candidate.overall or candidate.fit
    return ", ".join(f"{name} {value:.4g} ± {std:.2g}" for name, (value, std) in fit.named().items())


if __name__ == "__main__":
    main()
