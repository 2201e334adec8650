"""Numbers of a vehicle given wrong to `softsoil identify`: whether it names them, and whether it leaves right ones alone.

Run: python -m benchmarks.identify_contradictions [../shared/data] [--seeds 2] [--vehicles suv reference plant0] [--errors ...]
The reference simulator's two vehicles and vehicles of the plant (plant0: seed 0 of benchmarks.identify_plant), each with its
numbers as measured, and with one of them wrong: wheelbase +2 % and -2 % (l_f and l_r alike), axle loads (l_f +5 %, wheelbase
kept), radius +1 % and -1 %, yaw inertia given 38 % too large.
One lock and one multi-sine drive are fitted, with the noise "good" of each seed. With --classes the numbers are right
and the soil class of one log after the other is a wrong one, clay for sandy loam or the other way. With --place N only
l_f by position against course is judged, which needs no fit: right and 2 % wrong to either side, on N vehicles of the
plant, four noises each. A wrong number counts as said where the verdict is `contradicts_given` and names it; every
other number named is a false one.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.identify_reference import KNOWN as REFERENCE
from benchmarks.identify_suv import FITTED, HELD
from benchmarks.identify_suv import KNOWN as SUV
from benchmarks.judges.plant_vehicles import FIT, case_of, log_of
from softsoil.checking.geometry_check import front_axle
from softsoil.identification.identify import identify
from softsoil.identification.result import Identification
from softsoil.identification.unexplained import LIMITS
from softsoil.recording.drive import Recording
from softsoil.recording.log_names import named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.known_vehicle import Known
from softsoil.symbolic.soil import Soil, load_soil

REFERENCE_DRIVES = ("paper_clay_n0.50", "multi_sandyloam_n0.70", "multi_clay_n0.50")
"""Of the shared drives, the last left out."""
SUV_INERTIA, REFERENCE_INERTIA = 3920.0, 1820.0
"""kg m^2: what the true wheel forces balance with (benchmarks.identify_suv; the drives' README)."""
PLANT = "plant"
PLACE_NOISES = 4


@dataclass(frozen=True)
class Subject:
    """A vehicle to be given wrong numbers of: name, its right ones, yaw inertia (kg m^2), clean drives and their soil classes."""

    name: str
    known: Known
    inertia: float
    drives: Sequence[Recording]
    soils: Sequence[Soil]


def _wheelbase(s: Subject, share: float) -> Known:
    return s.known.with_numbers(l_f=share * s.known["l_f"], l_r=share * s.known["l_r"])


ERRORS: Mapping[str, tuple[str, Callable[[Subject], Known]]] = {
    "right": ("", lambda s: s.known),
    "wheelbase+2%": ("l_f", lambda s: _wheelbase(s, 1.02)),
    "wheelbase-2%": ("l_f", lambda s: _wheelbase(s, 0.98)),
    "loads+5%": ("l_f", lambda s: s.known.with_numbers(l_f=1.05 * s.known["l_f"], l_r=s.known["l_r"] - 0.05 * s.known["l_f"])),
    "radius+1%": ("radius", lambda s: s.known.with_numbers(radius=1.01 * s.known["radius"])),
    "radius-1%": ("radius", lambda s: s.known.with_numbers(radius=0.99 * s.known["radius"])),
    "inertia+38%": ("yaw_inertia", lambda s: s.known.with_numbers(yaw_inertia=1.38 * s.inertia)),
    "inertia right": ("", lambda s: s.known.with_numbers(yaw_inertia=s.inertia)),
}
"""What is wrong -> the number that has to be named, and the known numbers with it."""


def main() -> None:
    """Identify with each error and print what is said."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path, nargs="?", default=Path("../shared/data"), help="folder of the shared data")
    parser.add_argument("--seeds", type=int, default=2, help="how many seeds of the noise")
    parser.add_argument("--vehicles", nargs="+", default=["suv", "reference", "plant0", "plant1"], help="or plantSEED")
    parser.add_argument("--errors", nargs="+", default=list(ERRORS), choices=list(ERRORS), help="which errors")
    parser.add_argument("--classes", action="store_true", help="wrong soil classes in the place of wrong numbers")
    parser.add_argument("--place", type=int, default=0, metavar="N", help="l_f by motion alone, on N vehicles of the plant")
    parser.add_argument("--first", type=int, default=500, help="seed of the first of them")
    asked = parser.parse_args()
    if asked.place:
        print_place(range(asked.first, asked.first + asked.place))
        return
    if asked.classes:
        print_classes([_subject(vehicle, asked.data) for vehicle in asked.vehicles], asked.seeds)
        return
    said = wrong = false = runs = 0
    for vehicle in asked.vehicles:
        subject = _subject(vehicle, asked.data)
        for error in asked.errors:
            named, known = ERRORS[error][0], ERRORS[error][1](subject)
            for seed in range(asked.seeds):
                drives = [add_noise(drive, "good", 10 * i + 1000 * seed) for i, drive in enumerate(subject.drives)]
                found = identify(drives, subject.soils, known)
                names = [c.name for c in found.contradictions]
                hit = bool(named) and named in names and found.verdict == "contradicts_given"
                more = [name for name in names if name != named]
                runs, said, wrong, false = runs + 1, said + hit, wrong + bool(named), false + len(more)
                words = ", ".join(f"{c.name} {c.given:.5g} -> {c.value:.5g} ({c.sigmas:.1f})" for c in found.contradictions)
                value = found.vehicle.yaw_inertia / subject.inertia - 1.0
                print(
                    f"{subject.name:10s} {error:14s} seed {seed}: {'said' if hit else 'NOT said' if named else 'right numbers'}"
                    f"; {found.verdict} {words or 'nothing'}; yaw inertia {100 * value:+.1f} %; {_tracks(found)}; "
                    f"{found.seconds:.0f} s",
                    *(note for note in found.notes if note.startswith(("l_f:", "radius:"))),
                    sep="\n  ",
                    flush=True,
                )
    print(f"{said} of {wrong} wrong numbers said; {false} right numbers contradicted in {runs} identifications")


def print_classes(subjects: Sequence[Subject], seeds: int) -> None:
    """Print what is said where the soil class of one log is a wrong one, and where none is; seeds: of the noise."""
    others = {"clay": load_soil("sandy_loam"), "sandy_loam": load_soil("clay")}
    outcomes: dict[bool, list[bool]] = {False: [], True: []}
    for subject in subjects:
        for changed in (None, *range(len(subject.soils))):
            soils = [others.get(soil.name, soil) if i == changed else soil for i, soil in enumerate(subject.soils)]
            for seed in range(seeds):
                drives = [add_noise(drive, "good", 10 * i + 1000 * seed) for i, drive in enumerate(subject.drives)]
                found = identify(drives, soils, subject.known)
                wrong = changed is not None
                outcomes[wrong].append(found.verdict == "identified")
                n = ", ".join(f"{value:.3f}" for value, _ in found.n.values())
                case = "right classes" if changed is None else f"wrong class of {drives[changed].name}"
                print(
                    f"{subject.name:10s} {case:40s} "
                    f"seed {seed}: {found.verdict}; n {n}; n_error {100 * found.vehicle.n_error:.1f} %; most left "
                    f"{max(one.over(dict(LIMITS.unexplained))[0] for one in found.unexplained):.2f} of a right model's",
                    flush=True,
                )
    print(f"identified: {sum(outcomes[False])} of {len(outcomes[False])} with right classes, "
          f"{sum(outcomes[True])} of {len(outcomes[True])} with a wrong one")  # fmt: skip


def print_place(seeds: Sequence[int]) -> None:
    """Print how often l_f by position against course contradicts a right one and one that is 2 % wrong, by limit; seeds: of plant
    vehicles."""
    estimates: list[tuple[float, float]] = []
    right: list[float] = []
    wrong: list[float] = []
    for seed in seeds:
        subject, true = _subject(f"{PLANT}{seed}", Path()), case_of(seed).drawn.measured["l_f"]
        std, given = 0.001 * subject.known.wheelbase, subject.known["l_f"]
        for noise in range(PLACE_NOISES):
            drives = [add_noise(d, "good", 100 * seed + i + 1000 * noise) for i, d in enumerate(subject.drives)]
            place = front_axle(drives)
            if place is None:
                continue
            sigmas = [float(abs(place.value - share * given) / np.hypot(place.std, share * std)) for share in (1.0, 1.02, 0.98)]
            right.append(sigmas[0])
            wrong += sigmas[1:]
            estimates.append((place.value - true, place.std))
    off, error = 1e3 * np.array(estimates).T
    size = float(np.sqrt(np.mean(off**2)))
    print(f"l_f by motion, {len(off)} estimates: {size:.1f} mm off (rms), standard error {np.median(error):.1f} mm (median)")
    for limit in (2.5, 3.0, 4.0):
        false, named = (int(np.sum(np.array(sigmas) >= limit)) for sigmas in (right, wrong))
        print(f"limit {limit:g}: {named} of {len(wrong)} that are 2 % wrong contradicted, {false} of {len(right)} right ones")


def _tracks(found: Identification) -> str:
    """Where the given tracks and the rear axle come out, priors and all, against what is given."""
    given = [(name, one) for name in ("l_r", "track", "track_rear") if (one := found.numbers[name]).given is not None]
    return ", ".join(f"{name} {100 * (one.value / one.given - 1.0):+.1f} %" for name, one in given if one.given)


def _subject(name: str, data: Path) -> Subject:
    """The vehicle called `name` with its drives; ValueError for another name."""
    if name.startswith(PLANT) and name.removeprefix(PLANT).isdigit():
        case = case_of(int(name.removeprefix(PLANT)))
        logs = [log_of(case, kind, number) for number, kind in enumerate(FIT)]
        inertia = case.drawn.vehicle.yaw_inertia
        return Subject(name, case.known, inertia, [log.drive for log in logs], [log.soil for log in logs])
    if name == "suv":
        names, folder, known, inertia = (*FITTED, HELD), "chrono_suv", SUV, SUV_INERTIA
    elif name == "reference":
        names, folder, known, inertia = REFERENCE_DRIVES, "chrono_vehicle", REFERENCE, REFERENCE_INERTIA
    else:
        raise ValueError(f"--vehicles: expected suv, reference or plantSEED; found {name!r}")
    drives = [read_drive(data / folder / f"{one}.csv.gz") for one in names]
    return Subject(name, known, inertia, drives, [load_soil(str(named_soil(one))) for one in names])


if __name__ == "__main__":
    main()
