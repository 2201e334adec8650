"""Force laws against single-wheel runs: what each law leaves of the measured force, and what a call costs."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.calibration.domain import check_contact
from softsoil.codegen.compiled import CompiledFunction, compile_function
from softsoil.recording.rig import MOTION, SOIL_KEYS, WheelRun
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.dallas import Dallas
from softsoil.symbolic.laws.dallas_refit import DallasRefit, soil_class
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.laws.turn_slip_calibrated import TurnSlipCalibrated
from softsoil.symbolic.soil import SOILS, Soil
from softsoil.symbolic.wheel import Contact, ForceLaw, Wheel

Array = NDArray[np.float64]

LAWS = ("bekker", "dallas", "dallas_refit", "turn_slip", "turn_slip_calibrated")
SLOWEST = 0.02
"""Speed floor of a law over the median speed of the runs, so that slow laboratory wheels are not floored."""
SLIP_RANGES = ((-1.0, -0.157), (-0.157, 0.0), (0.0, 0.16), (0.16, 1.0))
"""The paper's four ranges of longitudinal slip (appendix); what lies beyond belongs to the nearest."""
LEAST_PEAK = 0.01
"""Share of the load from which a lateral force can be judged by its peak: a wheel that runs straight has none."""
WORTH_COMPILING = 100
"""Runs from which on a law is compiled before it is evaluated."""
BATCH = 512
"""Calls per timing, in one compiled loop."""


def law_for(name: str, runs: Sequence[WheelRun]) -> ForceLaw:
    """The law called `name` with the options that the runs ask for: speed floor, contact step, the rig's factors.

    Raises ValueError for another name, and for runs of several contact steps or patch lengths.
    """
    kinds = sorted({(run.contact_step, run.patch_length) for run in runs})
    if len(kinds) > 1:
        raise ValueError(
            f"single-wheel runs: expected one contact_step (s) and patch_length, found {kinds[0]} and {kinds[1]}: "
            "one call for each"
        )
    floor = min(0.1, SLOWEST * float(np.median(np.concatenate([np.hypot(r.v_x, r.v_y) for r in runs]))))
    base = Bekker(speed_floor=floor)
    step, patch = kinds[0]
    turn_slip = TurnSlip(contact_step=step, patch_length=patch, speed_floor=floor)
    reference = all(run.reference_rig for run in runs)
    laws: Mapping[str, Callable[[], ForceLaw]] = {
        "bekker": lambda: base,
        "dallas": lambda: Dallas(base=base),
        "dallas_refit": lambda: DallasRefit(base=base),
        "turn_slip": lambda: turn_slip,
        "turn_slip_calibrated": lambda: TurnSlipCalibrated(turn_slip, on_reference_rig=reference),
    }
    if name not in laws:
        raise ValueError(f"force law: expected one of {', '.join(laws)}; found {name!r}")
    return laws[name]()


def force_function(law: ForceLaw, soil_name: str, wheel: Wheel) -> ca.Function:
    """CasADi function [motion (7), soil (6)] -> [f_x, f_y, m_y, sinkage] of a wheel on a soil class."""
    motion, soil = ca.SX.sym("motion", len(MOTION)), ca.SX.sym("soil", len(SOIL_KEYS))
    force = law(
        Soil(soil_name, *[soil[i] for i in range(len(SOIL_KEYS))]),
        wheel,
        Contact(**{key: motion[i] for i, key in enumerate(MOTION)}),
    )
    out = ca.vertcat(force.f_x, force.f_y, force.m_y, force.sinkage)
    return ca.Function("force", [motion, soil], [out], ["motion", "soil"], ["out"])


def class_of(run: WheelRun) -> str:
    """The run's soil class, or the built-in class nearest to its parameters where it has another name."""
    if soil_class(run.group) in {soil_class(name) for name in SOILS}:
        return run.group
    keys = [key for key in ("k_phi", "c", "phi", "k") if run.soil[key] > 0]

    def distance(soil: Soil) -> float:
        return sum(float(np.log(run.soil[key] / soil.parameters()[key])) ** 2 for key in keys)

    return min(SOILS.values(), key=distance).name


def soil_column(run: WheelRun) -> Array:
    """(6, 1) soil parameters of a run in the order of SOIL_KEYS."""
    return np.array([[run.soil[key]] for key in SOIL_KEYS])


def predict(law: ForceLaw, runs: Sequence[WheelRun], load: str = "moment") -> list[Array]:
    """(4, N) f_x, f_y, m_y, sinkage per run (N, N, N m, m), in the wheel frame.

    load: "moment" for the load measured at each sample, "mean" for its mean over the run; the rows of a steady table are runs of
    their own. ValueError for another word,
    or a run outside the domain of the laws.
    """
    if load not in ("moment", "mean"):
        raise ValueError(f"load: expected moment or mean, found {load!r}")
    functions: dict[tuple[str, float, float], ca.Function] = {}
    predicted = []
    for run in runs:
        soil = class_of(run) if law.name == "dallas_refit" else ""  # the only law that goes by the soil's name
        key = (soil, run.radius, run.width)
        if key not in functions:
            function = force_function(law, soil, Wheel(run.radius, run.width))
            functions[key] = compile_function(function) if len(runs) >= WORTH_COMPILING else function
        _check_domain(run)
        given = run if load == "moment" or run.dt is None else replace(run, load=np.full(len(run), run.load.mean()))
        predicted.append(np.array(functions[key](given.motion(), soil_column(run))))
    return predicted


def _check_domain(run: WheelRun) -> None:
    """Raise ValueError, naming the run, where its motion or load leaves the domain of the force laws."""
    try:
        # v_x may be a rounding below zero at 90 deg of slip angle; a wheel that bounces may leave the soil for a moment.
        check_contact(Contact(max(float(run.v_x.min()), 0.0), 0.0, float(run.omega.min()), float(run.load.mean())))
    except ValueError as error:
        raise ValueError(f"{run.name}: {error}") from None


def lateral_scale(run: WheelRun) -> float:
    """Peak of a run's smoothed lateral force (N), at least LEAST_PEAK of its load."""
    peak = float(np.abs(run.smooth(run.lateral(run.f_x, run.f_y))).max())
    return max(peak, LEAST_PEAK * float(np.abs(run.load).mean()))


def check_lateral(runs: Sequence[WheelRun]) -> None:
    """Raise ValueError where no run has a lateral force: the column of one that was not measured."""
    if not any(np.abs(run.lateral(run.f_x, run.f_y)).max() > 0.0 for run in runs):
        raise ValueError(f"{runs[0].name}: expected lateral force, found zeros only, in {len(runs)} runs")


@dataclass(frozen=True)
class RunError:
    """What a law leaves of one run: rms errors of the smoothed lateral and longitudinal force over the peak lateral
    force (`lateral_scale`), the mean error of the sinkage (m) and the rms error of m_y over peak force times radius; NaN: not
    measured.
    """

    group: str
    slip: float
    lateral: float
    longitudinal: float
    sinkage: float
    m_y: float


def run_errors(law: ForceLaw, runs: Sequence[WheelRun], load: str = "moment") -> list[RunError]:
    """Errors of `law` on each run; `load` as in `predict`. Raises ValueError where no run has a lateral force."""
    check_lateral(runs)
    return [run_error(run, out) for run, out in zip(runs, predict(law, runs, load), strict=True)]


def run_error(run: WheelRun, out: Array) -> RunError:
    """Errors of predicted f_x, f_y, m_y, sinkage, out (4, N), on one run."""
    peak = lateral_scale(run)

    def rms(predicted: Array, reference: Array) -> float:
        return float(np.sqrt(np.mean((run.smooth(predicted) - run.smooth(reference)) ** 2)))

    return RunError(
        run.group,
        run.slip,
        rms(run.lateral(out[0], out[1]), run.lateral(run.f_x, run.f_y)) / peak,
        rms(run.longitudinal(out[0], out[1]), run.longitudinal(run.f_x, run.f_y)) / peak,
        float(np.mean(out[3] - run.sinkage)) if run.sinkage is not None else float("nan"),
        rms(out[2], run.m_y) / (peak * run.radius) if run.m_y is not None else float("nan"),
    )


def quantiles(values: Sequence[float]) -> dict[str, float | None]:
    """Median and 95th percentile of the finite values, None where there are none."""
    finite = [value for value in values if np.isfinite(value)]
    if not finite:
        return {"median": None, "p95": None}
    return {"median": float(np.median(finite)), "p95": float(np.percentile(finite, 95))}


def by_soil_and_slip(errors: Sequence[RunError]) -> list[dict[str, object]]:
    """One row per soil class and slip range: group, slip range, runs, median and p95 of the lateral error."""
    rows: list[dict[str, object]] = []
    for group in dict.fromkeys(error.group for error in errors):
        for low, high in SLIP_RANGES:
            first, last = low == SLIP_RANGES[0][0], high == SLIP_RANGES[-1][1]
            inside = [e.lateral for e in errors if e.group == group and (first or low <= e.slip) and (last or e.slip < high)]
            if inside:
                rows.append({"soil": group, "slip": [low, high], "runs": len(inside), **quantiles(inside)})
    return rows


def call_cost(law: ForceLaw, runs: Sequence[WheelRun], repeats: int = 20) -> float:
    """Microseconds per force in generated C, best of `repeats` loops over BATCH samples of the first run."""
    many = CompiledFunction(force_function(law, class_of(runs[0]), Wheel(runs[0].radius, runs[0].width)).map(BATCH))
    many.inputs[0][...] = np.tile(runs[0].motion(), -(-BATCH // len(runs[0])))[:, :BATCH]
    many.inputs[1][...] = np.tile(soil_column(runs[0]), BATCH)
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        many.run()
        best = min(best, time.perf_counter() - start)
    return float(best / BATCH * 1e6)
