"""Whether a load can be separated from the errors of an identified vehicle: `python -m benchmarks.payload_windows --seeds 3`.

Vehicles of the plant as `python -m benchmarks.identify_plant` identifies them (their files in --vehicles are taken where they are
there), each on a multi-sine drive with a quarter of its mass near the rear axle and on one without a load, noise "good". Fitted
to windows of 1 s with free initial states, which use what is measured far better than the windows of the tracing: n and all
numbers of the vehicle, each within what its file states of it alone, without a load and with one. A tracing by such windows could
name a load only if the loads that it finds on clean drives were much smaller than those carried; `refine` takes
the joint error of the numbers for that (its second look). True values are printed beside it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.identify_plant import FIRST_EFFECT, identified
from benchmarks.judges.plant_vehicles import Case, Log, case_of, effects_of, log_of
from softsoil.codegen.predictor import substeps_for
from softsoil.declaration.model_file import Declaration
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.noise import add_noise
from softsoil.recording.states import sensor_std
from softsoil.refinement.doubts import doubts
from softsoil.refinement.ranking import starts_of
from softsoil.refinement.trace import open_effects, whole_model
from softsoil.refinement.unknown_ground import free_n
from softsoil.symbolic.vehicle import Vehicle, load_vehicle
from softsoil.windows.free_starts import FASTEST, HORIZON, MODEL_STD, NOISE_FLOOR
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive
from softsoil.windows.window_fit import WindowFit, fit_windows

SWITCH, EFFECT = "load_carried", "payload"
START = 2.0
"""s left out at the beginning of a drive."""


def main() -> None:
    """Identify or read each vehicle and print its loads."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3, help="how many vehicles")
    parser.add_argument("--first", type=int, default=100, help="seed of the first")
    parser.add_argument("--vehicles", type=Path, default=Path("runs/identify_plant"), help="folder of the identified files")
    asked = parser.parse_args()
    asked.vehicles.mkdir(parents=True, exist_ok=True)
    for seed in range(asked.first, asked.first + asked.seeds):
        case, file = case_of(seed), asked.vehicles / f"vehicle_{seed}.toml"
        vehicle = load_vehicle(file) if file.exists() else identified(case, file)
        print(f"seed {seed}: {case.drawn.measured['mass']:.0f} kg")
        _print(case, vehicle)


def _print(case: Case, vehicle: Vehicle) -> None:
    switches = [*effects_of(case), ""]
    for switch in (SWITCH, ""):
        settings, truth = effects_of(case).get(switch, ({}, {}))
        number = FIRST_EFFECT + switches.index(switch)
        before, after, less = with_load(vehicle, log_of(case, "multi", number, settings), 2000 * case.seed + number)
        (n, n_std), found = before.named()["n_0"], after.named()
        (load, std), (place, place_std) = found["payload_mass"], found["payload_x"]
        behind = f", {-settings['payload_at'][0]:.2f} m behind the front axle" if settings else ""
        sigmas = less.mean() / (less.std(ddof=1) / np.sqrt(len(less)))
        print(
            f"  carries {truth.get('size', 0.0):.0f} kg{behind}: found {load:.0f} ± {std:.0f} kg at "
            f"{place:.2f} ± {place_std:.2f} m; the windows' squares lose {less.sum():.0f} ({sigmas:.1f} standard errors); "
            f"n {n:.3f} ± {n_std:.3f} without it, {found['n_0'][0]:.3f} ± {found['n_0'][1]:.3f} with it",
            flush=True,
        )


def with_load(vehicle: Vehicle, log: Log, seed: int) -> tuple[WindowFit, WindowFit, np.ndarray]:
    """The fits without and with a load, and by how much it lowers the squared residuals (W,) of each window.

    seed: of the sensor noise.
    """
    declaration, recording = Declaration(vehicle, log.soil), add_noise(log.drive, "good", seed)
    model, load = whole_model(declaration, [EFFECT]), open_effects(declaration, [EFFECT])[EFFECT]
    drive = shooting_drive(recording, model, START)
    compiled = WindowModel(model, drive.dt, substeps_for(drive.dt))
    sigma = np.hypot(MODEL_STD, sensor_std(recording, NOISE_FLOOR))
    known = [*(doubt.free for doubt in doubts(vehicle).values()), *free_n(1)]

    def fitted(free: list[Free], start: list[float]) -> WindowFit:
        windows = FreeWindows(compiled, drive, HORIZON, sigma, FASTEST)
        return fit_windows([windows], free, np.array(start), model.p.nominal)

    before = fitted(known, [float(log.soil.n) if f.known is None else f.known[0] for f in known])
    mine = [Free(s.name, (s.name,), s.spread / 2, s.lower, s.upper, known=(s.nominal, s.spread)) for s in load.parameters]
    tries = [fitted([*mine, *known], [*(start[f.name] for f in mine), *before.value]) for start in starts_of(load)]
    after = min(tries, key=lambda one: one.cost)
    return before, after, (before.costs - after.costs) * len(STATE_CHANNELS) * (round(HORIZON / drive.dt) + 1)


if __name__ == "__main__":
    main()
