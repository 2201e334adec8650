"""What `refine` names on a road, and how well it measures friction and tread: drives of the project's own bicycle.

`python -m benchmarks.hard_ground_refine --seed 11 12`: per seed one multi-sine drive of the reference vehicle without an effect
and one with each effect of the steering at its typical size, good sensors. The declaration has a fifth more friction and a
fifth less tread than there is, and no effect. Candidates are all effects of steering, tyre, slope and load. Printed for each
drive: what is named, its group, and the departures of friction and tread from the truth in standard errors. Model and world
share their equations here: this shows the method, not the model.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from softsoil.declaration.ground import HARD_GROUND
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.refinement.refine import refine
from softsoil.refinement.result import Refinement
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

KINDS = ("steering", "tyre", "slope", "load")
FRICTION, TREAD, OFF = 0.55, 0.003, 0.2
SECONDS, SPEED, AMPLITUDE, STEP = 40.0, 5.5, 0.35, 0.012
"""s, m/s, rad at the road wheels, s."""


def drive(vehicle: Vehicle, effects: dict[str, dict[str, float]], seed: int) -> Recording:
    """A noisy drive of the vehicle on the road with the effects; seed: of steering and noise."""
    model = bicycle(vehicle, HARD_GROUND.with_(phi=math.atan(FRICTION), k=TREAD), "hard_ground", effects)
    steer = MultiSine(AMPLITUDE, seed=seed)(np.arange(round(SECONDS / STEP) + 1, dtype=np.float64) * STEP)
    return add_noise(synthetic_drive(model, vehicle.radius, seconds=SECONDS, speed=SPEED, steer=steer), "good", seed)


def sentence(found: Refinement) -> str:
    """What is named, with what it cannot be separated from, and the departures of the ground's numbers."""
    named = [effect.name for effect in found.effects]
    groups = "".join(f" ({', '.join(group)})" for group in found.inseparable)
    sigmas = [(n.value - true) / n.std for n, true in zip(found.ground[0].numbers, (FRICTION, TREAD), strict=True)]
    said = f"{found.verdict}: {', '.join(named) or 'nothing'}{groups}"
    return f"{said:60s} friction {sigmas[0]:+.1f}, tread {sigmas[1]:+.1f} standard errors"


def main() -> None:
    """One line per drive, and how many are right."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, nargs="+", default=[11, 12])
    vehicle = load_vehicle("reference").with_(effects={})
    ground = HARD_GROUND.with_(name="road", phi=math.atan((1 + OFF) * FRICTION), k=(1 - OFF) * TREAD)
    declared, known = Declaration(vehicle, ground, "hard_ground"), catalogue(vehicle)
    tried = [name for name, effect in known.items() if effect.kind in KINDS]
    drives, right = 0, 0
    for seed in parser.parse_args().seed:
        for name in (None, *(name for name, effect in known.items() if effect.kind == KINDS[0])):
            effects = {} if name is None else {name: dict(known[name].typical)}
            found = refine([drive(vehicle, effects, seed)], declared, candidates=tried)
            drives, right = drives + 1, right + ([effect.name for effect in found.effects] == list(effects))
            print(f"seed {seed} {name or 'nothing':18s} {sentence(found)}", flush=True)
    print(f"{right} of {drives} right")


if __name__ == "__main__":
    main()
