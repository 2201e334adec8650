"""Picture of each effect's signature: `python -m benchmarks.guide.signatures [--out docs/pictures/effects] [EFFECT ...]`.

One drive of the reference vehicle's bicycle on clay, with the effects that the vehicle declares, steered by two sines at 5 to
7 m/s; the same commands with and without the effect at its typical size. Shown are the two channels that it changes most, and
below each by how much: a small effect hides behind two lines that look alike.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from benchmarks.guide.reference_effects import PICTURES
from softsoil.codegen.predictor import Predictor
from softsoil.codegen.sampling import STEP
from softsoil.figures.labels import quantity
from softsoil.figures.style import ESTIMATED, INITIAL, SOFT, TRUE, page
from softsoil.files.package_data import REFERENCE_VEHICLE
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

Array = NDArray[np.float64]
SECONDS, SPEED, SWING = 14.0, 6.0, 1.0
"""s, m/s, m/s."""
PLACE = 35.0
"""m along the drive: where an effect that begins at a place begins."""
COLOURS = 48
"""Colours of a picture's palette: a quarter of the bytes, and no difference to the eye."""
SHOWN = ("u", "v", "psi", "omega_z")
"""Channels that a picture may show."""


def inputs(vehicle: Vehicle, model: Model) -> tuple[Array, Array]:
    """Time (N,) in s and the inputs (N, n_u) of the drive that all pictures share."""
    t = np.asarray(STEP * np.arange(round(SECONDS / STEP) + 1))
    steer = 0.14 * np.sin(2 * np.pi * t / 5.0) + 0.07 * np.sin(2 * np.pi * t / 1.7)
    rate = 2 * np.pi / 11.0
    speed = SPEED + SWING * np.sin(rate * t)
    spin = speed / (vehicle.radius * 0.95)
    named = {"steer": steer, "steer_rate": np.gradient(steer, STEP), "a_x": SWING * rate * np.cos(rate * t)}
    named |= dict.fromkeys(WHEEL_CHANNELS, spin)
    return t, np.column_stack([named[name] for name in model.external.names])


def read(model: Model, u: Array) -> dict[str, Array]:
    """What the sensors read, channel -> (N,), on a drive of the model with inputs u (N, n_u)."""
    predictor, p = Predictor(model, STEP), model.p.nominal
    x = predictor.rollout(model.x.pack(u=SPEED), u[:-1], p)
    full = predictor.track_memory(x, u, p)[1]
    y = np.asarray(model.measurement().map(len(x))(x.T, full.T, np.tile(p[:, None], len(x)))).T
    return {name: y[:, i] for i, name in enumerate(STATE_CHANNELS)}


def both(effect: Effect, vehicle: Vehicle) -> tuple[Array, dict[str, Array], dict[str, Array]]:
    """Time (N,) and the channels without and with the effect; a declared effect is taken away, another one is added."""
    typical = dict(effect.typical)
    if effect.place:
        typical[effect.place[0]] = PLACE
    rest = {name: values for name, values in vehicle.effects.items() if name != effect.name}
    without = bicycle(vehicle, CLAY, effects=rest)
    present = bicycle(vehicle, CLAY, effects={**rest, effect.name: vehicle.effects.get(effect.name, typical)})
    t, u = inputs(vehicle, without)
    return t, read(without, u), read(present, u)


def draw(effect: Effect, vehicle: Vehicle, path: Path) -> Path:
    """Write the effect's picture to `path`."""
    t, without, present = both(effect, vehicle)
    size = {name: np.std(present[name] - without[name]) / max(float(np.std(without[name])), 1e-9) for name in SHOWN}
    chosen = sorted(sorted(SHOWN, key=lambda name: -size[name])[:2], key=SHOWN.index)
    with page(path, "", 7.2, 3.4, 2, 2, sharex=True, height_ratios=(1.7, 1.0)) as axes:
        for (upper, lower), name in zip(axes.T, chosen, strict=True):
            shown = quantity(name)
            upper.plot(t, shown.factor * without[name], color=TRUE, lw=1.1, label="without")
            upper.plot(t, shown.factor * present[name], color=ESTIMATED, lw=1.4, ls="--", label="with")
            upper.set_ylabel(shown.label)
            lower.plot(t, shown.factor * (present[name] - without[name]), color=INITIAL, lw=1.2)
            lower.axhline(0.0, color=SOFT, lw=0.8)
            lower.set(xlabel="time, s", ylabel=f"change, {shown.unit}")
        axes[0, 0].legend(loc="best")
    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(COLOURS)
    small.save(path, optimize=True)
    return path


def main() -> None:
    """Write the pictures of the effects named, or of all."""
    vehicle = load_vehicle(REFERENCE_VEHICLE)
    known = catalogue(vehicle)
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("effects", nargs="*", metavar="EFFECT", help=f"of {', '.join(known)}; default: all")
    options.add_argument("--out", type=Path, default=PICTURES)
    chosen = options.parse_args()
    unknown = set(chosen.effects) - set(known)
    if unknown:
        options.error(f"expected names of {', '.join(known)}; found {', '.join(sorted(unknown))}")
    chosen.out.mkdir(parents=True, exist_ok=True)
    for name in chosen.effects or known:
        print(f"wrote {draw(known[name], vehicle, chosen.out / f'{name}.png')}", flush=True)


if __name__ == "__main__":
    main()
