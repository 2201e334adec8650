"""`softsoil identify` judged on a vehicle of the independent simulator: n, yaw inertia, predictions and traced effects.

Fitted: the drives of the case with the noise named "good". Judged, on all its other drives (`vehicle_judge.py`): n by the filter
and by the horizon with Table-5 noise from two initial guesses, predictions over 2.5 s from clean states; the yaw inertia against
what the true wheel forces balance with (read to judge only); what `refine` names on drives with an effect and on the others.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.judges.true_inertia import balanced_inertia
from benchmarks.judges.true_soil import drive_name
from benchmarks.judges.vehicle_judge import GUESSES, joined, judge_drive, lines, words
from softsoil.declaration.model_file import Declaration
from softsoil.identification.identify import identify
from softsoil.identification.result import Identification
from softsoil.identification.vehicle_toml import vehicle_toml
from softsoil.mpc_demo.blind_test import score
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.refine import refine
from softsoil.symbolic.soil import load_soil
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

CONTACT_SEARCH = 0.0018
"""m below a wheel where the reference simulator's contact search finds it (`python -m benchmarks.plant_axles`: rolls as if)."""


@dataclass(frozen=True)
class Case:
    """A vehicle to be identified.

    known: its numbers as an owner knows them; fitted: drives of the fit; held: the drive that `identify` judges itself on;
    nominal: its drives without an effect; tracks: front and rear (m), of the true forces; effects: name of a drive with an
    effect -> effect, soil class, true parameters.
    """

    known: Known
    fitted: tuple[str, ...]
    held: str
    nominal: tuple[Path, ...]
    tracks: tuple[float, float]
    effects: Mapping[str, tuple[str, str, Mapping[str, float]]]

    @property
    def folder(self) -> Path:
        """Folder of the drives."""
        return self.nominal[0].parent

    @property
    def judged(self) -> list[Path]:
        """Nominal drives that no fit has seen."""
        return [path for path in self.nominal if drive_name(path) not in self.fitted]


def add_options(parser: argparse.ArgumentParser, out: str) -> None:
    """Options of such a benchmark; out: where the identified vehicle file is written by default."""
    parser.add_argument("--effects", action="store_true", help="trace the drives with an effect, and the nominal ones, too")
    parser.add_argument("--only-effects", action="store_true", help="trace only")
    parser.add_argument("--vehicle", type=Path, help="judge this vehicle file in the place of a new identification")
    parser.add_argument("--out", type=Path, default=Path(out), help="where the vehicle file is written")


def run(case: Case, asked: argparse.Namespace) -> None:
    """Identify, judge and print, as the options say."""
    if asked.vehicle is None:
        found = identified(case)
        asked.out.parent.mkdir(parents=True, exist_ok=True)
        asked.out.write_text(vehicle_toml(found), encoding="utf-8")
        print(f"wrote {asked.out}")
        vehicle = found.vehicle
    else:
        vehicle = load_vehicle(asked.vehicle)
    print_inertia(case, vehicle)
    if not asked.only_effects:
        judge(case, vehicle)
    if asked.effects or asked.only_effects:
        trace(case, vehicle)


def identified(case: Case) -> Identification:
    """The case's vehicle by `identify` from its fitted drives, printed."""
    began = time.perf_counter()
    names = (*case.fitted, case.held)
    drives = [add_noise(read_drive(case.folder / f"{name}.csv.gz"), "good", 10 * i) for i, name in enumerate(names)]
    found = identify(drives, [load_soil(str(named_soil(name))) for name in names], case.known)
    print(f"{found.verdict}: {found.reason} ({time.perf_counter() - began:.0f} s)")
    for name, number in found.numbers.items():
        print(
            f"  {name:22s} {number.value:10.4f} ± {number.std:.4f} {number.unit:10s} {number.state:17s} "
            f"n {number.n_percent_per_std:+.1f} %"
        )
    print("asks:", *found.asks, sep="\n  ")
    return found


def print_inertia(case: Case, vehicle: Vehicle) -> None:
    """Print the yaw inertia beside the one that the true wheel forces balance with."""
    drives = [read_drive(path) for path in case.nominal if "steps" not in path.name]
    true = balanced_inertia(drives, (case.known["l_f"], case.known["l_r"]), case.tracks)
    off = 100 * (vehicle.yaw_inertia / true - 1)
    print(f"yaw inertia {vehicle.yaw_inertia:.0f}, the true forces balance with {true:.0f}: {off:+.1f} %")


def judge(case: Case, vehicle: Vehicle) -> None:
    """Print n and predictions of the drives that no fit has seen."""
    parts = []
    for i, path in enumerate(case.judged):
        name = drive_name(path)
        soil, n = load_soil(str(named_soil(path.name))), float(named_n(name) or np.nan)
        parts.append(judge_drive(vehicle, case.known, read_drive(path), soil, n, 100 + i, GUESSES))
        print(f"{name:28s} n {n:.2f}: {words(parts[-1])}", flush=True)
    print(*lines(joined(parts)), sep="\n")


def trace(case: Case, vehicle: Vehicle) -> None:
    """Print what `refine` names on the drives with an effect and on the nominal ones that no fit has seen."""
    paths: Sequence[Path] = [*(case.folder / f"{name}.csv.gz" for name in case.effects), *case.judged]
    right = 0
    for path in paths:
        name = drive_name(path)
        effect, soil, truth = case.effects.get(name, ("", str(named_soil(name)), {}))
        found = refine([read_drive(path)], Declaration(vehicle, load_soil(soil)), workers=1)
        good, why = score({"kind": "effect" if effect else "clean", "name": effect, "truth": truth}, found)
        right += good
        best = ", ".join(f"{c.name} {100 * c.gain:.0f} %" for c in found.ranking[:3])
        print(f"{name:28s} {'right' if good else 'WRONG'} {found.verdict} {why}; best {best}; {found.seconds:.0f} s", flush=True)
    print(f"{right} of {len(paths)} right")
