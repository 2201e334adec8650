"""The verdict on an estimate of n: whether it may be used, and why not where it may not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.changed_vehicle import change_words
from softsoil.estimator.evidence import Evidence, gather, percent_above
from softsoil.estimator.hard_ground import HardGround, compare_hard_ground, on_hard_ground
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.recording.drive import Recording
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS

Array = NDArray[np.float64]

IDENTIFIED = "identified"
WORDS = (
    IDENTIFIED, "not_excited", "depends_on_first_guess", "at_bound", "axles_disagree", "inconsistent", "no_soil",
)  # fmt: skip
"""Every verdict; any but the first means: do not use this n."""
BOUNDS = (SOIL_SIGNALS["n"].lower, SOIL_SIGNALS["n"].upper)
GUESSES = (0.35, 1.1)
"""Initial guesses that are tried beside the user's: a stiff and a soft soil."""
LONGEST = 4.0
"""How many times as long a drive is asked for at most."""
NEGATIVE = -0.9  # an inertia so much smaller is no vehicle's: something else is wrong, and it is not spoken of
CHANNEL_WORDS = {"omega_z": "yaw rate", "v": "lateral velocity"}


@dataclass(frozen=True)
class Verdict:
    """word: one of WORDS; reason: one sentence; evidence: the numbers behind it, None where there is no window to look at."""

    word: str
    reason: str
    evidence: Evidence | None = None

    @property
    def usable(self) -> bool:
        """Whether the n may be used."""
        return self.word == IDENTIFIED


def judge(
    recording: Recording,
    model: Model,
    n0: float,
    n: Sequence[float] | None,
    *,
    tied: bool,
    start: float,
    again: Callable[[float], Sequence[float]] | None = None,
    corrected: bool = False,
    rules: VerdictRules | None = None,
) -> Verdict:
    """The verdict on the final n (A,) of an estimator that ran over a drive, None for that of the windows themselves.

    model: the bicycle it used; n0: its initial guess; again: final n (A,) that the same estimator gives from another initial
    guess, asked for that of the windows; corrected: whether the windows' n takes the place of an identified one: then it
    is enough that the estimator stays there when it starts there; tied, start: as of `estimate_horizon`; rules: limits.
    """
    horizon = HorizonRules()
    try:
        windows = drive_windows(recording, model, start, horizon)
    except ValueError as error:
        return Verdict("not_excited", f"no window of the drive can be judged: {error}")
    evidence, rules = gather(windows, initial_guesses(n0), tied, horizon), (rules or VerdictRules()).of(model)
    others = () if again is None else (np.asarray(again(float(np.clip(evidence.n[0], *BOUNDS))), dtype=float),)
    end = evidence.n if n is None else np.asarray(n, dtype=float)
    if corrected and len(end) == 1 and others and abs(others[0][0] - evidence.n[0]) < abs(end[0] - evidence.n[0]):
        end, others = others[0], (end,)
    verdict = decide(evidence, end, others, rules)
    if verdict.word not in ("inconsistent", "at_bound", "axles_disagree", "depends_on_first_guess"):
        return verdict
    road = drive_windows(recording, on_hard_ground(model), start, horizon)
    return hard_ground(compare_hard_ground(windows, road, n0), evidence, rules) or verdict


def hard_ground(found: HardGround, evidence: Evidence, rules: VerdictRules | None = None) -> Verdict | None:
    """The verdict "no_soil" where the windows are those of a road; None where they are not."""
    rules = rules or VerdictRules()
    if evidence.motion < rules.least_motion or found.friction < rules.road:
        return None
    if found.better <= rules.road_sigmas * found.better_std:
        return None
    return Verdict(
        "no_soil",
        f"hard ground with a coefficient of friction of {found.friction:.2f} leaves {found.cost:.1f}, soil "
        f"{found.soil_cost:.1f} in the mean square of the sensors' standard deviations: nothing sinks here and n has no meaning, "
        "or soil and vehicle are far from what is declared",
        evidence,
    )


def initial_guesses(n0: float) -> tuple[float, ...]:
    """The user's initial guess n0 and those of GUESSES that differ from it."""
    return (n0, *(guess for guess in GUESSES if abs(guess - n0) > 0.1))


def decide(evidence: Evidence, n: Array, others: Sequence[Array] = (), rules: VerdictRules | None = None) -> Verdict:
    """The verdict from the evidence on the final n (A,); others: final n (A,) each from other guesses of the same estimator."""
    rules = rules or VerdictRules()
    of_log = (_files_hold, _in_time, _consistent)
    of_drive = (_as_heavy_to_turn, _as_identified, _excited, _class_is_known, _beside_the_law, _shows_a_load)
    for check in (*of_log, *of_drive, _inside, _same_from_all_guesses, _same_as_windows, _axles_agree, _one_soil):
        found = check(evidence, n, others, rules)
        if found is not None:
            return Verdict(*found, evidence)
    alone, std = (100 * float(np.max(one / np.maximum(n, 1e-9))) for one in (evidence.information_std, evidence.std))
    return Verdict(
        IDENTIFIED,
        f"the drive determines n to ± {max(alone, 1.0):.0f} % (± {std:.0f} % with errors of law, vehicle and class), the model "
        f"leaves no more than a right one, {_alike(evidence)}" + _changed(evidence),
        evidence,
    )


def _changed(e: Evidence) -> str:
    """Since when n holds, where the soil has changed; a load that is taken up looks the same."""
    return f"; the soil, or the vehicle, changes at {e.changes[-1]:.1f} s: n is that of what follows" if e.changes else ""


def _alike(e: Evidence) -> str:
    """Where the initial guesses end, those that are left out named."""
    if not e.left_out:
        return "every initial guess ends alike"
    left = (f"{guess:.2f} ends at {n:.2f}, where windows fit {100 * worse:.0f} % worse" for guess, n, worse in e.left_out)
    return f"every initial guess that fits ends alike ({'; '.join(left)})"


Found = tuple[str, str] | None


def _files_hold(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    if not rules.contradicted:
        return None
    if "vehicle" in rules.contradicted:
        return "inconsistent", (
            "the vehicle's file holds given numbers that its logs contradict (softsoil identify; its first line names them): "
            "measure them again and identify anew"
        )
    return "inconsistent", "the soil's file is contradicted by its own drives (softsoil soil; its first line says how)"


def _in_time(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    if e.motion < rules.least_motion or e.late < rules.late:
        return None
    return "inconsistent", (
        f"the noise of the yaw rate is that of a low-pass, which makes it {e.late:.3f} s late and n too low (limit "
        f"{rules.late:g} s): log it unfiltered"
    )


def _consistent(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    if e.motion < rules.least_motion:
        return None
    for name, limit in rules.unexplained:
        left, error = e.unexplained.get(name, 0.0), e.unexplained_std.get(name, np.inf)
        if left - rules.unexplained_sigmas * error > limit**2:
            low, high = (100 * np.sqrt(max(left + sign * error, 0.0)) for sign in (-1, 1))
            return "inconsistent", (
                f"the model leaves {low:.1f} to {high:.1f} % of the {CHANNEL_WORDS[name]}'s motion unexplained beyond sensor "
                f"noise, a right one at most {100 * limit:.1f} %: another vehicle, soil class or effect, or a wrong channel"
                + (f"; of yaw inertias, {said}" if e.inertia > NEGATIVE and (said := _inertia(e, rules)) else "")
            )
    return None


def _as_heavy_to_turn(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    said = _inertia(e, rules)
    if said and e.inertia <= NEGATIVE:
        return "inconsistent", "no yaw inertia fits the drive: a channel is late or wrong, or another vehicle drove it"
    return ("inconsistent", f"the drive contradicts the declared yaw inertia: {said}") if said else None


def _as_identified(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    change = e.change
    if e.motion < rules.least_motion or change is None:
        return None
    said = change_words(
        change, rules.strain, change.strain > rules.strain, rules.another_mass(change.load, change.load_std),
        abs(change.steering) > max(rules.steering, rules.steering_sigmas * change.steering_std),
    )  # fmt: skip
    return ("inconsistent", said) if said else None


def _inertia(e: Evidence, rules: VerdictRules) -> str:
    """Which yaw inertia the drive asks for, where that is not the declared one; else nothing."""
    if e.motion < rules.least_motion or not e.inertia_std <= rules.inertia_known:
        return ""
    if abs(e.inertia) < max(rules.inertia, float(np.hypot(rules.inertia_sigmas * e.inertia_std, rules.inertia_stated))):
        return ""
    size, std = 100 * abs(e.inertia), max(100 * e.inertia_std, 1.0)
    return f"one {size:.0f} ± {std:.0f} % {'larger' if e.inertia > 0 else 'smaller'} leaves less"


def _excited(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    if e.motion < rules.least_motion:
        return "not_excited", (
            f"the vehicle hardly turns (lateral specific force {e.motion:.2f} m/s^2 rms, expected at least "
            f"{rules.least_motion:g}): steer more, at several speeds"
        )
    share = float(np.max(e.information_std / np.maximum(n, SOIL_SIGNALS["n"].lower)))
    if not share <= rules.excited:
        return "not_excited", (
            f"the drive determines n to ± {percent_above(share, rules.excited)} % only (limit {100 * rules.excited:.0f} %; "
            f"lateral specific force {e.motion:.2f} m/s^2 rms over {e.windows} windows): steer more, at several speeds"
        )
    return None


def _class_is_known(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    if e.soil.std <= rules.of_class:
        return None
    return "not_excited", (
        f"the errors that the soil's file states of its class make n uncertain by ± {percent_above(e.soil.std, rules.of_class)} "
        f"% (limit {100 * rules.of_class:.0f} %): softsoil soil fits them to drives"
    )


def _beside_the_law(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    if e.soil.law_std <= rules.of_law:
        return None
    front, rear = (100 * abs(share) for share in e.soil.forces)
    return "not_excited", (
        f"1 % of the lateral force of the front axle is {front:.1f} % of n, of the rear axle {rear:.1f} %: n is uncertain by "
        f"± {percent_above(e.soil.law_std, rules.of_law)} % (limit {100 * rules.of_law:.0f} %), as on steady curves near the "
        f"limit of grip; steer to and fro, at several speeds"
    )


def _shows_a_load(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    if e.change is None or e.change.seen_std <= rules.load_seen:
        return None
    longer = (e.change.seen_std / rules.load_seen) ** 2
    more = f"about {longer + 0.05:.1f} times as long, or " if longer < LONGEST else ""
    return "not_excited", (
        f"the drive tells a load to ± {percent_above(e.change.seen_std, rules.load_seen)} % of the vehicle's mass only (limit "
        f"{100 * rules.load_seen:.0f} %), and a load that it does not show would make n wrong: drive "
        f"{more}with more steering, at several speeds"
    )


def _inside(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    bounds = SOIL_SIGNALS["n"]
    for value in (*n, *e.n):
        if value < bounds.lower + rules.bound or value > bounds.upper - rules.bound:
            return "at_bound", f"n ends at {value:.2f}, a bound of its range {bounds.lower:g} to {bounds.upper:g}"
    return None


def _same_from_all_guesses(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    for axle, value in enumerate(n):
        for ends in (e.by_guess[:, axle], np.array([value, *(other[axle] for other in others)])):
            low, high = float(ends.min()), float(ends.max())
            if high - low > rules.same * float(value):
                return "depends_on_first_guess", f"different initial guesses end between {low:.3f} and {high:.3f}"
    return None


def _same_as_windows(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    apart = float(np.max(np.abs(n - e.n)))
    if apart > rules.same * float(np.min(e.n)):
        return "inconsistent", (
            f"the estimator ends at {', '.join(f'{v:.3f}' for v in n)}, windows with free initial states say "
            f"{', '.join(f'{v:.3f}' for v in e.n)}"
        )
    return None


def _axles_agree(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    front, rear = e.n_axles
    apart = abs(front - rear)
    if apart > rules.apart_sigmas * float(np.hypot(*e.axles_std)) and apart > rules.apart * 0.5 * (front + rear):
        return "axles_disagree", (
            f"the front axle alone gives n = {front:.2f} ± {e.axles_std[0]:.2f}, the rear one {rear:.2f} ± {e.axles_std[1]:.2f}"
        )
    return None


def _one_soil(e: Evidence, n: Array, others: Sequence[Array], rules: VerdictRules) -> Found:
    before, after = e.parts
    if e.parts_sigmas > rules.parts_sigmas and abs(after - before) > rules.parts * float(n[0]):
        return "inconsistent", (
            f"the earlier part of the drive gives n = {before:.2f}, the later one {after:.2f}, {e.parts_sigmas:.1f} standard "
            f"deviations from each other: the soil or the vehicle changes on the way"
        )
    return None
