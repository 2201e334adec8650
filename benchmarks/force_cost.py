"""What a force costs, all in one run on one core: `python -m benchmarks.force_cost`.

One call after the other in generated C for every law; many forces at once in vector registers (`codegen/lanes.py`), with one
soil for all wheels and with a soil per wheel; and the soil contact model of the plant, per wheel and step. The paper
reports 200-400 us per force for its surrogate. Each figure is the best of many short loops, taking turns.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import casadi as ca
import numpy as np

from softsoil.codegen.compiled import CompiledFunction, at_points
from softsoil.plant.rig import Rig, RigRun, run_rig
from softsoil.recording.rig import MOTION, SOIL_KEYS
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.dallas import Dallas
from softsoil.symbolic.laws.dallas_refit import DallasRefit
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.laws.turn_slip_calibrated import TurnSlipCalibrated
from softsoil.symbolic.soil import CLAY, Soil
from softsoil.symbolic.wheel import Contact, ForceLaw, Wheel

WHEEL = Wheel(0.330229, 0.2121)
COUNT = 1024
ROUNDS = 60
LAWS: tuple[ForceLaw, ...] = (Bekker(), Dallas(), DallasRefit(), TurnSlip(), TurnSlipCalibrated(on_reference_rig=True))


def force(law: ForceLaw, soil_per_wheel: bool) -> ca.Function:
    """[motion, soil] -> [f_x, f_y], or [motion and soil] -> [f_x, f_y]."""
    motion, soil = ca.SX.sym("motion", len(MOTION)), ca.SX.sym("soil", len(SOIL_KEYS))
    out = law(
        Soil("clay", *[soil[i] for i in range(len(SOIL_KEYS))]),
        WHEEL,
        Contact(**{key: motion[i] for i, key in enumerate(MOTION)}),
    )
    inputs = [ca.vertcat(motion, soil)] if soil_per_wheel else [motion, soil]
    return ca.Function(f"force_{law.name}_{int(soil_per_wheel)}", inputs, [ca.vertcat(out.f_x, out.f_y)])


def states() -> np.ndarray:
    """(7, COUNT) contacts over the paper's Table 4."""
    rng = np.random.default_rng(0)
    v, angle, slip = rng.uniform(2.5, 8.5, COUNT), rng.uniform(-0.35, 0.35, COUNT), rng.uniform(0, 0.9, COUNT)
    v_x, rate = v * np.cos(angle), rng.uniform(-2, 2, COUNT)
    omega = v_x / WHEEL.radius / (1 - slip)
    return np.array([v_x, -v * np.sin(angle), omega, rng.uniform(1000, 4000, COUNT), rate, rate, 0 * rate])


def calls() -> dict[str, Callable[[], object]]:
    """Name -> a call that computes COUNT forces."""
    motion, soil = states(), np.array([getattr(CLAY, key) for key in SOIL_KEYS])
    each = np.vstack([motion, np.tile(soil[:, None], COUNT)])
    found: dict[str, Callable[[], object]] = {}
    for law in LAWS:
        scalar = CompiledFunction(force(law, True).map(COUNT))
        scalar.inputs[0][...] = each
        found[f"{law.name}, one by one"] = scalar.run
    for shared, name in ((True, "one soil"), (False, "a soil per wheel")):
        many, parts = at_points(force(TurnSlip(), not shared), COUNT)
        lanes = CompiledFunction(many, compiled=False) if parts else CompiledFunction(many)
        lanes.inputs[0][...] = motion if shared else each
        if shared:
            lanes.inputs[1][...] = soil[:, None]
        found[f"turn_slip, lanes, {name}"] = lanes.run
    return found


def main() -> None:
    loops = calls()
    best = dict.fromkeys(loops, np.inf)
    for _ in range(ROUNDS):
        for name, loop in loops.items():
            start = time.perf_counter()
            loop()
            best[name] = min(best[name], (time.perf_counter() - start) / COUNT * 1e6)
    run, rig = RigRun(CLAY, 2500.0, 0.2, 5.5, 0.35, 1.0), Rig()
    run_rig(run, 0.1, rig)
    scm = np.inf
    for _ in range(3):
        start = time.perf_counter()
        run_rig(run, 1.0, rig)
        scm = min(scm, (time.perf_counter() - start) / (1.0 / rig.step) * 1e6)
    print(f"{'':36s}{'us per force':>14s}{'soil contact model takes':>28s}")
    for name, cost in best.items():
        print(f"{name:36s}{cost:14.3f}{scm / cost:22.0f} times")
    print(f"{'soil contact model, wheel and step':36s}{scm:14.3f}")


if __name__ == "__main__":
    main()
