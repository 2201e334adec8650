"""Case study on measured data: a 1:10 car on hard floor, steered by commands, through the project's own `refine`.

The ground is declared hard: friction and tread are fitted together with every candidate, one of each for a log. What refine
finds on one log is then judged on the others, where the ground alone is fitted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from softsoil.cases.dart_data import L_R, RADIUS, WHEELBASE, read_dart
from softsoil.checking.usable import checked
from softsoil.declaration.ground import HARD_GROUND
from softsoil.declaration.model_file import Declaration
from softsoil.recording.drive import Recording
from softsoil.refinement.refine import held_mse, refine
from softsoil.refinement.result import Refinement, TracedEffect
from softsoil.refinement.trace import fit_base, gain_of, held_cost
from softsoil.refinement.windowing import Windowing
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.vehicle import Vehicle

MASS, CAR_WIDTH = 1.58, 0.08
CAR = Vehicle(
    "dart", mass=MASS, l_f=WHEELBASE - L_R, l_r=L_R, yaw_inertia=MASS / 12 * (WHEELBASE**2 + CAR_WIDTH**2),
    track=0.1, h_cg=0.03, radius=RADIUS, width=0.025, max_steer=0.52, max_steer_rate=10.0,
)  # fmt: skip
"""The laboratory's figures; track, height and wheel are nominal: the single track on hard ground does not look at them."""
KINDS = ("steering", "tyre", "slope")
"""Kinds of effects that are tried. The plausible forces and masses of the catalogue are a full-size vehicle's; and one motion
capture gives every state, so that no channel can be late or offset against another."""
WINDOWING = Windowing(horizon=1.0, horizons=(0.5, 1.0))
"""Shorter than of a full-size vehicle: this one's motions are as much quicker."""
START = 0.3
"""s that are left out at the beginning of a stretch."""


def candidates_of(vehicle: Vehicle, kinds: Sequence[str]) -> list[str]:
    """Names of the effects of the vehicle's catalogue that are of one of the kinds."""
    return [name for name, effect in catalogue(vehicle).items() if effect.kind in kinds]


def hard_road(vehicle: Vehicle, name: str) -> Declaration:
    """A vehicle on hard ground called `name`, of which nothing else is known."""
    return Declaration(vehicle, HARD_GROUND.with_(name=name), "hard_ground")


def log_name(path: Path) -> str:
    """What a log is called: 83_16."""
    return "_".join(path.name.split("_")[:2])


def drives_of(path: Path) -> list[Recording]:
    """The stretches of a log as `read_dart` gives them, their channels checked against each other."""
    return [checked(drive, CAR)[0] for drive in read_dart(path)]


def trace_log(
    path: Path, progress: Callable[[float], None] = lambda share: None, names: Sequence[str] | None = None
) -> Refinement:
    """What the declared car lacks in one log.

    progress: called with the share of the first round; names: of the candidates, default all of KINDS.
    Raises ValueError as `read_dart` does.
    """
    tried = candidates_of(CAR, KINDS) if names is None else names
    declared = hard_road(CAR, log_name(path))
    return refine(drives_of(path), declared, start=START, candidates=tried, windowing=WINDOWING, progress=progress)


def transferred(log: Refinement, effect: TracedEffect, values: dict[str, float]) -> tuple[float, float, float]:
    """Share of a log's held-out cost that an effect of other logs removes, its standard error, and how many times smaller the
    held-out mean squared error of the heading at 0.5 s becomes; the ground alone is fitted, on the log's own fit windows.

    log: its refinement, with the declared model's bench; values: the effect's parameters by the other logs.
    """
    bench = log.bench
    there = bench.absent.copy()
    for name in catalogue(CAR)[effect.name].parameters.names:
        there[:, bench.model.p.index(name)] = values[name]
    after = fit_base(replace(bench, absent=there)).p
    gain, std = gain_of(held_cost(bench, bench.absent), held_cost(bench, after), bench.floor)
    horizon = f"{WINDOWING.horizons[0]:.1f}"
    return gain, std, log.before[horizon]["psi"] / held_mse(bench, after, WINDOWING.horizons)[horizon]["psi"]
