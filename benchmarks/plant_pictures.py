"""The pictures of docs/concepts/plant.md: a drive with its ruts.

python -m benchmarks.plant_pictures [--out docs] [--animation runs/plant.gif]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from softsoil.figures.plant import animation, picture
from softsoil.plant.simulate import simulate
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.symbolic.soil import SANDY_LOAM


def main() -> None:
    """Drive and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("docs/pictures"))
    parser.add_argument("--animation", type=Path)
    arguments = parser.parse_args()
    plant = Plant(SANDY_LOAM, start=Start(u=5.0))
    recording = simulate("paper", SANDY_LOAM, 9.0, plant=plant)
    print(picture(recording, plant, arguments.out / "plant_drive.png"))
    if arguments.animation:
        arguments.animation.parent.mkdir(parents=True, exist_ok=True)
        print(animation(recording, arguments.animation))


if __name__ == "__main__":
    main()
