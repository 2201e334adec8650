"""Case study on measured data: a 1:10 car on hard floor, steered by commands, through the project's own loop.

The ground is declared, not the soil law: friction and tread stiffness of `hard_ground` are fitted together with every
candidate. The first two thirds of each stretch are fitted, the rest judges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.cases.dart_data import L_R, RADIUS, WHEELBASE, read_dart
from softsoil.estimator.inputs import sensor_std
from softsoil.estimator.shooting import shooting_drive, shootings
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.refinement.fit import Fit, Free, Weights, fit
from softsoil.refinement.ranking import rank
from softsoil.refinement.rules import RULES
from softsoil.refinement.selection import like, supported
from softsoil.refinement.trace import Bench, Candidate, gain_of, held_cost
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import Effect, neutral
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import Vehicle

Array = NDArray[np.float64]

MASS, CAR_WIDTH = 1.58, 0.08
CAR = Vehicle(
    "dart", mass=MASS, l_f=WHEELBASE - L_R, l_r=L_R, yaw_inertia=MASS / 12 * (WHEELBASE**2 + CAR_WIDTH**2),
    track=0.1, h_cg=0.03, radius=RADIUS, width=0.025, max_steer=0.52, max_steer_rate=10.0,
)  # fmt: skip
"""The laboratory's figures; track, height and wheel are nominal: the single track on hard ground does not look at them."""
FLOOR = Soil("floor", k_phi=1e6, k_c=0.0, n=0.5, c=0.0, phi=0.6, k=0.0015, R=0.0)
"""phi and k are where the fit starts; the rest has no meaning on hard ground."""
GROUND = (Free("phi", ("phi",), 0.1, 0.05, 0.95), Free("k", ("k",), 2e-4, 2e-4, 0.02))
"""Friction up to 1.4; a tread that shears by 0.2 to 20 mm."""
STARTS = ((0.35, 0.0003), (0.35, 0.0008), (0.6, 0.0015), (0.9, 0.0015), (0.9, 0.004))
KINDS = ("steering", "tyre", "slope", "sensor")
"""Kinds of effects whose plausible sizes fit a small car; forces and masses of a full-size vehicle do not."""
MEASURED = frozenset({*STATE_CHANNELS, "steer"})
"""What these logs have; there is no accelerometer and no wheel speed."""
SHOOTING, START, SMOOTHING = 1.0, 0.3, 0.07
"""s: windows, what is left out at the beginning of a stretch, and the polynomial that smooths the recorded states."""
SUBSTEPS = 6
"""Euler steps in 10 ms: this car's yaw rate settles within a few milliseconds when it creeps on a stiff tread."""
HORIZONS = (0.25, 0.5, 1.0)
"""s, of the errors before and after."""
MOST_EFFECTS = 2


@dataclass(frozen=True)
class DartLog:
    """Result of the loop on one log.

    name; seconds of driving used; ground: (phi, k) declared and at the end, with standard errors; ranking: first round;
    accepted: in order; groups: each with what explains the held-out windows as well; parameters: name -> (value, std, unit);
    before, after: horizon -> state -> held-out rms; yaw_rate (4, W, N): time, recorded, before and after over the held-out
    windows of the first stretch, for pictures.
    """

    name: str
    seconds: float
    ground: tuple[dict[str, tuple[float, float]], dict[str, tuple[float, float]]]
    ranking: tuple[Candidate, ...]
    accepted: tuple[Candidate, ...]
    groups: tuple[tuple[str, ...], ...]
    parameters: dict[str, tuple[float, float, str]]
    before: dict[str, dict[str, float]]
    after: dict[str, dict[str, float]]
    yaw_rate: Array

    def as_json(self) -> dict[str, Any]:
        """Its part of dart.json."""
        return {
            "log": self.name,
            "seconds": self.seconds,
            "ground": [{k: {"value": v, "std": s} for k, (v, s) in g.items()} for g in self.ground],
            "ranking": [{"name": c.name, "holdout_gain": c.gain, "std": c.std} for c in self.ranking],
            "effects": [c.name for c in self.accepted],
            "inseparable": [list(g) for g in self.groups if len(g) > 1],
            "parameters": {k: {"value": v, "std": s, "unit": u} for k, (v, s, u) in self.parameters.items()},
            "before": {"rms": self.before},
            "after": {"rms": self.after},
        }


def candidate_names(vehicle: Vehicle = CAR, measured: frozenset[str] = MEASURED) -> tuple[str, ...]:
    """Effects of the vehicle's catalogue of KINDS that rest on `measured` channels only."""
    return tuple(n for n, e in catalogue(vehicle).items() if e.kind in KINDS and set(e.rests_on) <= measured)


def candidate_model(names: Sequence[str] | None = None, vehicle: Vehicle = CAR) -> Model:
    """The bicycle of a vehicle on hard ground with the candidates called `names` added, absent; default `candidate_names`."""
    model = nominal_bicycle(vehicle, FLOOR, "hard_ground")
    known = catalogue(vehicle)
    for name in candidate_names() if names is None else names:
        model = neutral(model, known[name])
    return model


def dart_bench(drives: Sequence[Recording], model: Model) -> Bench:
    """The tracing's bench on a log's stretches, friction and tread stiffness fitted, each channel weighted by what is left."""
    ready = [shooting_drive(drive, model, START, SMOOTHING) for drive in drives]
    windows = shootings(model, ready, SHOOTING, SUBSTEPS)
    counts = [len(shooting.rows) for shooting in windows]
    fitted = tuple(np.arange(max(round(count * RULES.fit_share), 1)) for count in counts)
    held = tuple(np.arange(len(part), count) for part, count in zip(fitted, counts, strict=True))
    sensor = np.max([sensor_std(r, np.array([1e-3, 1e-3, 1e-3, 5e-3, 5e-3, 1e-2])) for r in drives], axis=0)
    p = np.tile(model.p.nominal, (len(drives), 1))
    bench = Bench(model, p, windows, fitted, held, Weights(np.array([0.05, 0.05, 0.1, 0.1, 0.1, 0.5])), sensor, GROUND)
    for _ in range(2):
        p = fit_ground(bench).p
        left = np.concatenate([s.residual(row)[part] for s, row, part in zip(windows, p, fitted, strict=True)])
        sigma = np.maximum(_rms(left.reshape(-1, left.shape[-1]), 1.0), RULES.least_sigma * sensor)
        bench = replace(bench, absent=p, weights=Weights(sigma))
    return bench


def _rms(values: Array, unknown: float) -> Array:
    """(n,) root mean square of the finite values (N, n); `unknown` for a channel without any."""
    seen = np.isfinite(values)
    count = seen.sum(axis=0)
    mean = (np.where(seen, values, 0.0) ** 2).sum(axis=0) / np.maximum(count, 1)
    return np.where(count > 0, np.sqrt(mean), unknown)


def fit_ground(bench: Bench) -> Fit:
    """Friction and tread stiffness (and what was accepted) on the fit windows, from several starts."""
    known = [bench.absent[0, bench.model.p.index(f.name)] for f in bench.accepted]
    starts = [[*start, *known[len(GROUND) :]] for start in (*STARTS, known[: len(GROUND)])]
    return fit(bench.shootings, bench.fitted, bench.weights, bench.accepted, np.array(starts), bench.absent)


def trace_log(
    path: Path,
    model: Model,
    progress: Callable[[float], None] = lambda share: None,
    names: Sequence[str] | None = None,
) -> DartLog:
    """The loop on one log: ground fitted, candidates ranked, accepted one after the other while held-out windows support them.

    model: of `candidate_model`; progress: called with the share of the first round; names: of the candidates,
    default all in the model.
    Raises ValueError as `read_dart` does.
    """
    known = {name: effect for name, effect in catalogue(CAR).items() if name in (names or model.effects)}
    return trace_drives("_".join(path.name.split("_")[:2]), read_dart(path), model, known, progress)


def trace_drives(
    name: str,
    drives: Sequence[Recording],
    model: Model,
    known: dict[str, Effect],
    progress: Callable[[float], None] = lambda share: None,
) -> DartLog:
    """The loop on the drives of one log on hard ground, called `name`; channels that are not measured count nowhere.

    model: of `candidate_model`; known: the candidates; progress: called with the share of the first round.
    """
    bench = dart_bench(drives, model)
    first_ground, first_p = fit_ground(bench).named(), bench.absent
    ranking = first = _ranked(bench, known, progress)
    accepted: list[Candidate] = []
    groups: list[tuple[str, ...]] = []
    while len(accepted) < MOST_EFFECTS:
        best = next((c for c in ranking if supported(c, known[c.name])), None)
        if best is None:
            break
        grown = _accept(bench, best, known[best.name])
        if grown is None:
            break
        groups.append((best.name, *like(best, ranking, bench)))
        accepted.append(best)
        bench = grown
        ranking = _ranked(bench, {k: e for k, e in known.items() if k not in {a.name for a in accepted}})
    last = fit(bench.shootings, bench.fitted, bench.weights, bench.accepted, _at(bench), bench.absent)
    found = last.named()
    return DartLog(
        name=name,
        seconds=float(sum(len(d) * d.dt for d in drives)),
        ground=(first_ground, {f.name: found[f.name] for f in GROUND}),
        ranking=tuple(first),
        accepted=tuple(accepted),
        groups=tuple(groups),
        parameters={k: (*found[k], _unit(known, k)) for k in found if k not in {f.name for f in GROUND}},
        before=held_rms(bench, first_p),
        after=held_rms(bench, last.p),
        yaw_rate=_yaw_rate(bench, first_p[0], last.p[0]),
    )


def transferred(path: Path, model: Model, values: dict[str, float]) -> tuple[float, float, dict[str, dict[str, float]]]:
    """Share of the held-out cost of a log that effects identified on other logs remove, its standard error, and the held-out rms.

    path: of the log; model: of `candidate_model`; values: parameters by name, from other logs; here only the ground is fitted,
    on the log's own fit windows.
    """
    bench = dart_bench(read_dart(path), model)
    there = bench.absent.copy()
    for name, value in values.items():
        there[:, model.p.index(name)] = value
    after = fit_ground(replace(bench, absent=there)).p
    return *gain_of(held_cost(bench, bench.absent), held_cost(bench, after)), held_rms(bench, after)


def _yaw_rate(bench: Bench, before: Array, after: Array) -> Array:
    shooting, held, state = bench.shootings[0], bench.held[0], STATE_CHANNELS.index("omega_z")
    rows = shooting.rows[held][:, None] + np.arange(1, shooting.steps + 1)
    recorded = shooting.drive.measured[rows, state]
    predicted = [shooting.predict(p)[held, :, state] for p in (before, after)]
    return np.stack([shooting.drive.t[rows], recorded, *predicted])


def _ranked(
    bench: Bench, effects: dict[str, Effect], progress: Callable[[float], None] = lambda share: None
) -> list[Candidate]:
    """Effects ranked; a friction that the drive never reaches may end at its bound without speaking against an effect."""
    ground = {f.name for f in GROUND}
    found = rank(bench, effects, 1, progress)
    return [
        replace(c, fit=replace(c.fit, at_bound=tuple(name for name in c.fit.at_bound if name not in ground)))
        for c in found
    ]


def _accept(bench: Bench, candidate: Candidate, effect: Effect) -> Bench | None:
    """The bench with the effect at its fitted parameters, which stay free from now on; None where the fit of all that was
    accepted drives one of them to its bound: it is not identified then.
    """
    free = [f for f in candidate.fit.free if f.name in effect.parameters.names]
    grown = replace(bench, absent=candidate.fit.p, accepted=(*bench.accepted, *free))
    found = fit_ground(grown)
    if any(name not in {f.name for f in GROUND} for name in found.at_bound):
        return None
    return replace(grown, absent=found.p)


def _at(bench: Bench) -> Array:
    return np.array([bench.absent[0, bench.model.p.index(f.name)] for f in bench.accepted])


def _unit(known: dict[str, Effect], parameter: str) -> str:
    return next(e.parameters[parameter].unit for e in known.values() if parameter in e.parameters.names)


def held_rms(bench: Bench, p: Array) -> dict[str, dict[str, float]]:
    """Horizon -> state -> rms error at the end of held-out windows of that length, for parameters p (D, n_p) on the bench."""
    table = {}
    for horizon in HORIZONS:
        ends = []
        for shooting, held, row in zip(bench.shootings, bench.held, p, strict=True):
            windows = shooting.ahead(horizon)
            ends.append(windows.residual(row)[windows.rows >= shooting.rows[held[0]], -1])
        rms = _rms(np.concatenate(ends), float("nan"))
        table[f"{horizon:g}"] = dict(zip(STATE_CHANNELS, map(float, rms), strict=True))
    return table
