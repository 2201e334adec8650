"""One task of a sweep over the plant's single-wheel rig: run it, and judge the force laws on it."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from softsoil.calibration.single_wheel import force_function, run_error, soil_column
from softsoil.plant.rig import CHANNELS, Rig, RigRun, run_rig
from softsoil.plant.rig_sweep import FIRST, INTERVAL, LAST, TABLE_4
from softsoil.recording.rig import RIG_PATCH, SOIL_KEYS, WheelRun, run_from_rig
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.soil import SOILS, Soil
from softsoil.symbolic.wheel import ForceLaw, Wheel

MOTIONS = {"amplitude": (0.14, 0.4), "frequency": (0.3, 1.5)}
"""Yaw amplitude (rad) and frequency (Hz)."""
WHEELS = {"radius": (0.2, 0.5), "width": (0.12, 0.35)}
"""Wheels of the sweep over any soil (m)."""
DURATION = LAST + INTERVAL
"""s: length of a run."""
LAWS = ("bekker", "turn_slip")


def draw_points(
    runs: int, seed: int, any_soil: bool, spacing: float = Rig().spacing, step: float = Rig().step
) -> list[dict[str, Any]]:
    """Points uniform over Table 4, the soil classes in turns; with any_soil, each soil parameter and the wheel's size
    are drawn on their own, log-uniformly over what the classes span (runs: how many; seed: of the generator; spacing: of
    the soil's grid, m; step: of the rig, s).
    """
    rng = np.random.default_rng(seed)
    points = []
    for k in range(runs):
        soil = list(SOILS.values())[k % len(SOILS)]
        point: dict[str, Any] = {"soil": soil.name, "radius": Rig().radius, "width": Rig().width}
        point |= {"spacing": spacing, "step": step}
        point |= {key: float(soil.parameters()[key]) for key in SOIL_KEYS}
        if any_soil:
            point["soil"] = "any"
            for key in ("k_phi", "k_c", "c", "phi", "k"):
                values = [float(s.parameters()[key]) for s in SOILS.values()]
                point[key] = float(np.exp(rng.uniform(np.log(min(values)), np.log(max(values)))))
            point |= {key: float(rng.uniform(*span)) for key, span in WHEELS.items()}
        point |= {key: float(rng.uniform(*span)) for key, span in {**TABLE_4, **MOTIONS}.items()}
        points.append(point)
    return points


def judge_point(point: Mapping[str, Any]) -> dict[str, Any]:
    """Error of each law on one run of the plant's rig, and the plant's own time per wheel and step (us)."""
    rig = Rig(radius=point["radius"], width=point["width"], spacing=point["spacing"], step=point["step"])
    soil = Soil(str(point["soil"]), **{key: float(point[key]) for key in SOIL_KEYS})
    told = RigRun(soil, *[float(point[k]) for k in ("load", "slip", "speed", "amplitude", "frequency")])
    began = time.perf_counter()
    t, series = run_rig(told, DURATION, rig, every=round(INTERVAL / rig.step))
    seconds = time.perf_counter() - began
    run = wheel_run(point, t, series, rig)
    result: dict[str, Any] = {"plant_us": 1e6 * seconds / (DURATION / rig.step), "slip": run.slip, "soil": run.group}
    motion, column = run.motion(), soil_column(run)
    for name in LAWS:
        error = run_error(run, np.array(_function(name, run.radius, run.width, rig.step)(motion, column)))
        result[name] = {"lateral": error.lateral, "longitudinal": error.longitudinal, "sinkage": error.sinkage}
    return result


def wheel_run(point: Mapping[str, Any], t: np.ndarray, series: np.ndarray, rig: Rig) -> WheelRun:
    """The plant's rows `series` (N, channels) at times t (N,) (s) as a WheelRun, the settling cut."""
    keep = t >= FIRST - 1e-9
    channels = dict(zip(CHANNELS, series[keep].T, strict=True))
    told = {key: float(point[key]) for key in (*SOIL_KEYS, "load", "slip", "speed")}
    return run_from_rig(str(point["soil"]), told, "plant", t[keep], channels, rig.radius, rig.width, False)


@lru_cache(maxsize=256)
def _function(name: str, radius: float, width: float, step: float) -> ca.Function:
    """Each process builds a law once per wheel."""
    law: ForceLaw = Bekker() if name == "bekker" else TurnSlip(contact_step=step, patch_length=RIG_PATCH)
    return force_function(law, "", Wheel(radius, width))


def summary(results: Sequence[Mapping[str, Any]], law: str, key: str = "lateral") -> dict[str, float]:
    """Median and 95th percentile of one error over results."""
    values = [float(result[law][key]) for result in results]
    return {"median": float(np.median(values)), "p95": float(np.percentile(values, 95))}
