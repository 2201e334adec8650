"""Maps of simulated fields of four soils against the truth: how many cells hold it within two standard deviations.

`python -m benchmarks.soil_maps [--seeds 1] [--noise good] [--cell 10]`. Per field: n of each quarter is drawn from 0.40 to 0.75;
three drives east, three north and one across, weaving at 5 m/s. Judged by the n at the middle of each cell; cells whose middle is
within a cell's size of a border of soils are left out. Nothing is fitted here.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

import softsoil
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.plant.manoeuvres import PathFollower, Speed
from softsoil.plant.sensors import Sensors
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start

SIDE, SPEED = 150.0, 5.0
WAVES = ((1.3, 23.0), (0.8, 37.0), (0.45, 15.0))
"""Metres aside and along of the waves of a path."""


def quarters(seed: int) -> np.ndarray:
    """(2, 2) n of the quarters, south and west first."""
    return np.random.default_rng(seed).uniform(0.40, 0.75, (2, 2))


def at(n: np.ndarray, x: float, y: float) -> float:
    """n of a place."""
    return float(n[int(y >= SIDE / 2), int(x >= SIDE / 2)])


def course(x: float, y: float, heading: float, length: float, seed: int) -> np.ndarray:
    """(N, 2) a weaving path (m)."""
    rng, along = np.random.default_rng(seed), np.arange(0.0, length + 30.0, 0.5)
    aside = sum(size * np.sin(2 * np.pi * along / wave + rng.uniform(0.0, 2 * np.pi)) for size, wave in WAVES)
    aside = aside * np.minimum(1.0, along / 15.0)
    cos, sin = np.cos(heading), np.sin(heading)
    return np.column_stack([x + along * cos - aside * sin, y + along * sin + aside * cos])


def drives(seed: int, noise: str) -> list[softsoil.Recording]:
    """The drives over one field, without the truth."""
    n, clay, ground = quarters(seed), softsoil.load_soil("clay"), [float(place) for place in range(-30, int(SIDE) + 31)]
    field = SoilField.over(lambda x, y: clay.with_(n=at(n, x, y)), ground, ground)
    lines = [(0.0, y, 0.0, SIDE) for y in (20.0, 60.0, 120.0)] + [(x, 0.0, np.pi / 2, SIDE) for x in (30.0, 70.0, 135.0)]
    made = []
    for k, (x, y, heading, length) in enumerate([*lines, (0.0, 0.0, np.pi / 4, 1.4 * SIDE)]):
        follow = PathFollower(course(x, y, heading, length, 10 * seed + k), Speed(SPEED, 1.0, 11.0))
        start = Start(x=x, y=y, psi=heading, u=SPEED)
        made.append(softsoil.simulate(follow, field, length / SPEED, sensors=Sensors(noise), seed=10 * seed + k, start=start))
    return [replace(one, name=f"drive_{k}", truth={}) for k, one in enumerate(made)]


def main() -> None:
    """Print each field's cells by verdict, and those of all fields."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--noise", default="good")
    parser.add_argument("--cell", type=float, default=10.0)
    options = parser.parse_args()
    model = softsoil.bicycle(softsoil.load_vehicle(PLANT_VEHICLE), softsoil.load_soil("clay"))
    rows: list[tuple[str, float, float, int]] = []
    for seed in range(options.seeds):
        ground, n = softsoil.map_soil(drives(seed, options.noise), model, cell=options.cell), quarters(seed)
        for cell in ground.cells:
            x, y = (options.cell * (i + 0.5) for i in (cell.column, cell.row))
            if min(abs(x - SIDE / 2), abs(y - SIDE / 2)) > options.cell:
                true = at(n, x, y)
                rows.append((cell.verdict, (cell.n - true) / cell.std, cell.n / true - 1.0, cell.drives))
        print(f"field {seed}: n {np.round(n, 2).tolist()}, {len(ground.cells)} of {ground.driven} driven cells", flush=True)
    for word in ("identified", "not_excited", "inconsistent", "at_bound", "all"):
        mine = np.array([(z, error) for verdict, z, error, _ in rows if word in (verdict, "all")])
        if len(mine):
            z, error = mine.T
            held, rms, mean = (100 * value for value in (np.mean(abs(z) < 2), np.sqrt(np.mean(error**2)), error.mean()))
            print(f"{word:13s} {len(z):3d} cells: {held:3.0f} % hold n within two std; error rms {rms:.1f} %, mean {mean:+.1f} %")


if __name__ == "__main__":
    main()
