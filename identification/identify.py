"""The numbers of a vehicle from its own logs: fitted jointly, each drive with its own n, and judged on a log left out."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from softsoil.checking.usable import usable
from softsoil.declaration.late_steering import late_steering
from softsoil.identification.asks import asks, excitation
from softsoil.identification.axle_places import AxlePlaces, axle_places
from softsoil.identification.bench import Bench, first_n, fit_numbers, free_numbers, make_bench
from softsoil.identification.errors import Errors, departures, errors_of, joint_error, n_costs
from softsoil.identification.fit_verdict import FitState, Values, fit_verdict, odd_numbers
from softsoil.identification.judge import judge
from softsoil.identification.late_channels import recorded_late, with_late_channels
from softsoil.identification.n_errors import model_error, n_error, n_stds, unmeasured
from softsoil.identification.result import Contradiction, Found, Identification
from softsoil.identification.rules import RULES, Rules
from softsoil.identification.steering_ratio import steering_ratio
from softsoil.identification.unexplained import doubt, more_than_right, own_logs, own_unexplained
from softsoil.recording.copies import refuse_copies
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.log_names import distinct
from softsoil.refinement.known_vehicle import Known, as_known
from softsoil.refinement.vehicle_numbers import (
    NUMBERS,
    OTHER_GROUND,
    by_name,
    declared_vehicle,
    expected,
    says_ground,
    vehicle_of,
)
from softsoil.refinement.words import with_error
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import SIMULATOR
from softsoil.windows.absent_wheels import absent_wheels
from softsoil.windows.parameters import Free
from softsoil.windows.window_fit import WindowFit

Progress = Callable[[float], None]
ROLLING_ERROR = 0.0015
"""What the force law's longitudinal error makes of the radius, as a share (`python -m benchmarks.identify_plant` prints it)."""


def identify(
    logs: Sequence[Recording | str | Path],
    soils: Soil | Sequence[Soil],
    known: Known | Mapping[str, Any] | str | Path,
    judged: int = -1,
    *,
    start: float = 2.0,
    rules: Rules = RULES,
    progress: Callable[[float], None] = lambda share: None,
) -> Identification:
    """The numbers of the vehicle and of its effects that predict its logs, with their standard errors, from sensor channels only.

    logs: two drives or more, or their files, checked and completed as by `softsoil.estimate`; soils: class of all or of each, n
    unknown; errors that a class states are in the standard deviations of n; known: what the owner has measured, as a table of
    numbers or its file; judged: index of the log that is left out of every fit and judges; start: seconds left out at the
    beginning of each; rules: thresholds; progress: called with the share that is done.
    Raises ValueError for fewer than two logs, logs that cannot be used, known numbers that are too few or out of bounds, or
    logs without wheel speeds where `known` does not say which wheels are driven.

    Example:
        >>> import softsoil
        >>> known = {"mass": 1378.3, "l_f": 1.546, "l_r": 1.175, "track": 1.232, "radius": 0.3302, "width": 0.212}
        >>> known["simulator"] = {**softsoil.load_vehicle("reference").simulator, "contact_search": 0.0018}
        >>> multi, lock, _ = (softsoil.read_drive(log).between(0.0, 15.0) for log in softsoil.example_logs())
        >>> found = softsoil.identify([lock, multi], softsoil.load_soil("clay"), known)
        >>> found.verdict, found.judged.log
        ('needs_data', 'multi_clay_n0.50')
        >>> found.reason.split(":")[0]
        'Every log repeats one steering wave'
    """
    began = time.perf_counter()
    if len(logs) < 2:
        raise ValueError(f"identify: expected two logs or more, one of which judges; found {len(logs)}")
    known = as_known(known)
    owned = declared_vehicle(known)
    recordings = distinct([usable(log, owned, late_steering(owned)) for log in logs])
    if len(absent_wheels(recordings)) == len(WHEEL_CHANNELS) and not known.driveline:
        raise ValueError(
            f"{known.file or 'known'}: expected the table [driveline] with centre_lock and front_drive, which wheels are driven, "
            f"since wheels of both axles have no measured speed in {_without_wheels(recordings)}; found none"
        )
    soils = [soils] * len(logs) if isinstance(soils, Soil) else list(soils)
    if len(soils) != len(logs):
        raise ValueError(f"identify: expected one soil, or one for each of {len(logs)} logs; found {len(soils)}")
    refuse_copies(recordings)
    known, late = with_late_channels(_with_steering(known, recordings), recordings)
    last, progress = range(len(recordings))[judged], _forwards(progress)

    def attempt(known: Known, told: Progress) -> _Attempt:
        return _attempt(make_bench(recordings, soils, known, start, told), last, rules, progress)

    found, ground = _on_either_ground(attempt, known, rules, progress)
    bench, fitted, places, state, numbers = found.bench, found.fitted, found.places, found.state, found.numbers
    known, had = bench.known, excitation(fitted.recordings, start)
    beside = float(np.hypot(model_error(recordings[last], bool(bench.balances), rules), state.unmeasured))
    judgement = judge(bench.only([last]), state.values, beside)
    # Errors of identified numbers are correlated: independent ones of full size would allow what no log allows.
    alone = dict(zip(state.errors.names, map(float, state.errors.alone), strict=True))
    vehicle = vehicle_of(known, state.values, {name: found.std * alone.get(name, 1.0) for name, found in numbers.items()})
    there = [name for name in state.errors.names if name in numbers and name not in (*SIMULATOR.names, "l_f", "l_r")]
    joint = joint_error(state.errors, there, rules.model_error_joint)
    vehicle = vehicle.with_(joint_error=joint)
    n = dict(zip(fitted.names, zip(state.n, state.n_std, strict=True), strict=True)) | {judgement.log: judgement.n_after}
    left = own_logs(bench.recordings, bench.soils, vehicle, {log: value for log, (value, _) in n.items()}, start)
    more = more_than_right(left)  # what moves n beside its sampling error grows with what the numbers leave
    wide = {one.log: one.class_std for one in left}
    n = {log: (value, float(np.hypot(more * std, wide[log] * value))) for log, (value, std) in n.items()}
    judgement = replace(judgement, n_after=n[judgement.log])
    vehicle = vehicle.with_(n_error=min(more * n_error(state.n, state.n_std), 1.0), unexplained=own_unexplained(left))
    contradicted = [c.name for c in state.contradictions]
    vague = vehicle.n_error if vehicle.n_error > rules.n_error else 0.0
    doubted = doubt(bench.recordings, bench.soils, vehicle_of(known, {}), left, contradicted, start, vague) if had.steers else ""
    verdict, reason = ("contradicts_given", doubted) if doubted else fit_verdict(state, numbers, fitted, had, rules)
    bent = verdict == "contradicts_given" and not (state.contradictions and not doubted)
    return Identification(
        verdict=verdict,
        reason=reason,
        numbers=numbers,
        n=n,
        judged=judgement,
        asks=() if bent else asks(vehicle, numbers, had, rules.load_share),  # no manoeuvre mends a channel or a law
        contradictions=state.contradictions,
        unexplained=left,
        vehicle=vehicle.with_(verdict=verdict),
        known=known,
        seconds=time.perf_counter() - began,
        notes=(
            *ground, places.note, state.rolls, *late, *recorded_late(numbers), *steering_ratio(numbers, vehicle),
            *_own_notes(recordings),
        ),
    )


def _forwards(progress: Progress) -> Progress:
    """Progress that never goes back, though a second fit begins anew."""
    most = 0.0

    def tell(share: float) -> None:
        nonlocal most
        most = max(most, share)
        progress(most)

    return tell


@dataclass(frozen=True)
class _Attempt:
    """A bench of all logs, that of the fitted ones, where their axles are, and the fit with its numbers."""

    bench: Bench
    fitted: Bench
    places: AxlePlaces
    state: FitState
    numbers: dict[str, Found]


def _attempt(bench: Bench, last: int, rules: Rules, progress: Callable[[float], None]) -> _Attempt:
    """Fit the logs of a bench but the one that judges, `last`."""
    fitted = bench.only([i for i in range(len(bench.recordings)) if i != last])
    places = axle_places(bench.recordings, bench.known, rules)
    state = _fit(fitted, places, rules, progress)
    return _Attempt(bench, fitted, places, state, _numbers(fitted, state))


def _on_either_ground(
    attempt: Callable[[Known, Progress], _Attempt], known: Known, rules: Rules, progress: Progress
) -> tuple[_Attempt, tuple[str, ...]]:
    """The fit on ground that stays sheared in ruts; where that asks for strange numbers, the one on ground that shears anew, if
    it leaves less with fewer of them and nobody has said which ground it is; and a note of that."""
    found = attempt(known, lambda share: progress(0.15 * share))
    odd = odd_numbers(found.numbers, rules.strange)
    if not odd or says_ground(known):
        return found, ()
    anew = attempt(replace(known, other_ground=True), lambda share: None)
    better = anew.state.cost <= rules.other_ground * found.state.cost
    if not better or len(odd_numbers(anew.numbers, rules.strange)) >= len(odd):
        return found, ()
    said = ", ".join(f"[effects.{effect}] {name} = {value:g}" for effect, t in OTHER_GROUND.items() for name, value in t.items())
    note = (
        f"ground: it shears anew where the front wheels have sheared it ({said}): that leaves "
        f"{found.state.cost / anew.state.cost:.3g} times less than ground that stays sheared, where {' and '.join(odd)} would be "
        "strange for a vehicle"
    )
    return anew, (note,)


def _without_wheels(recordings: Sequence[Recording]) -> str:
    """Names of those that do not measure the speed of every wheel."""
    return ", ".join(recording.name for recording in recordings if not recording.measured(*WHEEL_CHANNELS))


def _own_notes(recordings: Sequence[Recording]) -> list[str]:
    return [f"{recording.name}: {note}" for recording in recordings for note in recording.notes]


def _not_rolling(recordings: Sequence[Recording]) -> str:
    """What is not known where wheels' balances are not there."""
    return (
        f"wheels: not every speed is measured in {_without_wheels(recordings) or 'the log left out'}; in all logs those wheels "
        "turn as the balance of forces asks: it pins fewer numbers than measured ones do, and a wrong radius does not show"
    )


def _with_steering(known: Known, recordings: Sequence[Recording]) -> Known:
    """The known numbers with the largest steering of the logs where full lock is not given."""
    if "max_steer" in known.numbers:
        return known
    largest = max(float(np.nanmax(np.abs(r["steer"]))) for r in recordings)
    return known.with_numbers(max_steer=float(np.clip(round(1.02 * largest, 3), 0.05, 1.5)))


def _fit(bench: Bench, places: AxlePlaces, rules: Rules, progress: Callable[[float], None]) -> FitState:
    """All numbers free, given ones within their error of measuring; those that the logs contradict freed; those that they do not
    see fixed as expected, and the rest fitted once more. The fits that judge what is given leave the radius free: a wrong one
    would move n and the numbers, and they the evidence against it. Wheels without a measured speed say nothing of it."""
    before = {**expected(bench.known), **places.left}
    names = [number.name for number in NUMBERS if number.free or number.name in places.left]
    contradictions = list(places.contradictions)
    doubted = [c.name for c in contradictions]

    def free(doubted: Sequence[str]) -> list[Free]:
        return free_numbers(bench, names, doubted, places.left)

    values: Values = dict(places.values)
    n = first_n(bench, values)
    for _ in range(rules.rounds):
        fit = fit_numbers(bench, free([*doubted, *(["radius"] if bench.balances else [])]), values, n)
        progress(0.5)
        values, n = {**values, **_values(fit)}, _n(fit)
        errors = errors_of(fit)
        found = _worst(bench, fit, errors, {*doubted, *places.left, "radius"}, rules)  # by_rolling judges the radius
        if found is None:
            break
        doubted.append(found.name)
        contradictions.append(found)
    rolling, rolls = by_rolling(bench.known, values, errors, rules) if bench.balances else (None, _not_rolling(bench.recordings))
    if rolling is not None:
        doubted.append(rolling.name)
        contradictions.append(rolling)
    elif bench.balances:
        fit = fit_numbers(bench, free(doubted), values, n)
        values, n, errors = {**values, **_values(fit)}, _n(fit), errors_of(fit)
    contradictions = [_settled(c, values, errors, rules) for c in contradictions]
    std = {name: min(errors.std[name], before[name][1]) if name not in doubted else errors.std[name] for name in names}
    kept = [name for name in names if name in doubted or std[name] <= rules.seen * before[name][1]]
    values = {**values, **{name: before[name][0] for name in names if name not in kept}}
    if len(kept) < len(names):
        last = fit_numbers(bench, free_numbers(bench, kept, doubted, places.left), values, n)
        values, n = {**values, **_values(last)}, _n(last)
    progress(0.8)
    moved = unmeasured(bench, free(doubted), fit, places.values)
    progress(0.9)
    every = fit_numbers(bench, free_numbers(bench, [number.name for number in NUMBERS], doubted, places.left), values, n, 0)
    # Standard errors are those with every number free: fixing one does not make it known. What the model misses is in them.
    stds = {name: s for name, (_, s) in before.items()}
    stds |= {name: s if name in doubted else min(rules.model_error * s, before[name][1]) for name, s in std.items()}
    stds |= {c.name: c.std for c in contradictions}
    states = {name: _state(bench.known, name, kept) for name in before}
    taped = expected(bench.known)
    for name in places.left:  # free within their stated errors: given is only what has not moved
        if stds[name] <= rules.seen * taped[name][1] or values[name] != bench.known.value(name):
            states[name] = "identified"
    states |= {c.name: "identified" for c in contradictions}
    n_std = n_stds(bench, n, errors, moved, rules)
    all_values = {**{name: value for name, (value, _) in before.items()}, **values}
    costs = {**n_costs(every, stds), **{name: 100.0 * float(max(by, key=abs)) for name, by in moved.items()}}
    share = float(np.sqrt(sum(np.mean(by**2) for by in moved.values())))
    return FitState(all_values, stds, states, tuple(n), n_std, share, costs, tuple(contradictions), errors, rolls, every.cost)


def _state(known: Known, name: str, kept: Sequence[str]) -> str:
    if name in kept:
        return "identified"
    return "given" if known.value(name) is not None else "not_identifiable"


def _values(fit: WindowFit) -> Values:
    return {f.name: float(v) for f, v in zip(fit.free, fit.value, strict=True) if f.drive is None}


def _n(fit: WindowFit) -> list[float]:
    return [float(v) for f, v in zip(fit.free, fit.value, strict=True) if f.drive is not None]


def by_rolling(
    known: Known, values: Mapping[str, float], errors: Errors, rules: Rules
) -> tuple[Contradiction | None, str]:
    """The radius, as a tape would say it, against wheel speeds, motion and the balances of the wheels: whether it is
    contradicted, and a note of what the logs say.

    values, errors: of a fit that did not know the radius.
    """
    given, (rolls, std) = known["radius"], expected(known)["radius"]
    own = float(np.hypot(errors.std["radius"], ROLLING_ERROR * given))
    off, both = values["radius"] - rolls, float(np.hypot(own, std))
    sigmas = float(abs(off) / both)
    note = (
        f"radius: given as {given:.4f} m, {with_error(given + off, own)} m by rolling ({sigmas:.1f} standard deviations); these "
        f"logs contradict one that is {1e3 * rules.contradicted_rolling * both:.1f} mm off"
    )
    if sigmas < rules.contradicted_rolling or abs(off) < rules.material * given:
        return None, note
    return Contradiction("radius", given, given + off, own, sigmas, "the speeds that its wheels roll at"), note


def _worst(bench: Bench, fit: WindowFit, errors: Errors, left: Collection[str], rules: Rules) -> Contradiction | None:
    """The given number, none of `left`, that the logs contradict most; None where they contradict none."""
    found = []
    for name, (value, std, sigmas) in departures(fit, errors, rules.bent).items():
        given = bench.known.value(name)
        if given is None or name in left:
            continue
        if sigmas > rules.contradicted and abs(value - given) > rules.material * abs(given):
            found.append(Contradiction(name, given, value, std, sigmas, "predictions of the logs"))
    return max(found, key=lambda c: c.sigmas, default=None)


def _settled(c: Contradiction, values: Mapping[str, float], errors: Errors, rules: Rules) -> Contradiction:
    """The contradiction with the value and error of the fit in which its number was free."""
    if c.name not in errors.names or c.name == "radius":  # the fit's is what rolls, not what a tape measures
        return c
    std = float(np.hypot(errors.std[c.name], rules.bent.get(c.name, 0.0) * c.given))
    return Contradiction(c.name, c.given, values[c.name], std, c.sigmas, c.evidence)


def _numbers(bench: Bench, state: FitState) -> dict[str, Found]:
    before, numbers = expected(bench.known), by_name()
    return {
        name: Found(
            value=state.values[name], std=state.std[name], unit=numbers[name].unit, state=state.states[name],
            n_percent_per_std=state.costs.get(name, 0.0), given=bench.known.value(name), before=before[name],
        )
        for name in before
    }  # fmt: skip
