"""What a fit of a vehicle's numbers is worth: identified, in need of other logs, or contradicting what was given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from softsoil.identification.asks import Excitation
from softsoil.identification.bench import Bench
from softsoil.identification.errors import Errors
from softsoil.identification.result import Contradiction, Found
from softsoil.identification.rules import Rules
from softsoil.identification.words import NO_BETTER

Values = dict[str, float]


@dataclass(frozen=True)
class FitState:
    """Result of the fits: values, standard errors and states of all numbers, n of each drive, what numbers that nobody measured
    make of it (a share), costs of all numbers, contradictions, errors with every number free, a note of the radius by
    rolling, and the mean robust square of what is left."""

    values: Values
    std: Values
    states: dict[str, str]
    n: tuple[float, ...]
    n_std: tuple[float, ...]
    unmeasured: float
    costs: Values
    contradictions: tuple[Contradiction, ...]
    errors: Errors
    rolls: str
    cost: float


def odd_numbers(numbers: Mapping[str, Found], sigmas: float) -> dict[str, Found]:
    """Those of the `numbers`, by name, that are identified, that nobody gave and that are more than so many standard deviations
    (`sigmas`) from what is expected of any vehicle."""
    return {name: f for name, f in numbers.items() if f.state == "identified" and f.given is None and f.departs > sigmas}


def fit_verdict(
    state: FitState, numbers: Mapping[str, Found], bench: Bench, had: Excitation, rules: Rules
) -> tuple[str, str]:
    """Verdict, "identified", "needs_data" or "contradicts_given", and its reason.

    state: of the fit; numbers: by name; bench: of the fitted logs; had: how these excite the vehicle; rules: limits.
    """
    if not had.steers:
        return "needs_data", (
            "The logs are driven straight on: without lateral motion they show neither n nor the vehicle's numbers."
        )
    if state.contradictions:
        words = "; ".join(
            f"{c.name} is given as {c.given:.5g} {numbers[c.name].unit}, but by {c.evidence} it is {c.value:.5g} ± {c.std:.2g} "
            f"({c.sigmas:.0f} standard deviations)"
            for c in state.contradictions
        )
        far = [c.name for c in state.contradictions if abs(c.value - c.given) > rules.believable * abs(c.given)]
        stands = ", ".join(f"{c.name} = {abs(c.value - c.given):.2g}" for c in state.contradictions)
        cure = f"[uncertainty] {stands} in the known numbers leaves it to the logs" if not far else (
            f"n is not to be had from these logs: no law of this model has {' and '.join(far)} so far off"
        )
        return "contradicts_given", (
            f"{words}: measure it again before this file is used. Where the measurement stands, since force law or slip are "
            f"other ones there, {cure}."
        )
    if not had.many_waves:
        return "needs_data", (
            "Every log repeats one steering wave: n and the vehicle's numbers change its one amplitude and phase alike, whatever "
            "the fit's own standard errors say."
        )
    odd = odd_numbers(numbers, rules.odd)
    if len(odd) >= rules.most_odd:
        words = ", ".join(f"{name} {f.value:.3g} {f.unit}".rstrip() + f" by {f.departs:.1f}" for name, f in odd.items())
        return "contradicts_given", (
            f"The logs ask for numbers that no vehicle has, by standard deviations from what is expected of any: {words}. The "
            "ground, its class, a channel or a given number is other than said, and n comes out wrong with such numbers."
        )
    for log, n, std in zip(bench.names, state.n, state.n_std, strict=True):
        if std > rules.n_std * n:
            return "needs_data", f"With the vehicle's numbers free, n of {log} stays uncertain: {n:.2f} ± {std:.2f}."
    inertia = numbers["yaw_inertia"]
    if inertia.state != "given" and inertia.std > rules.inertia_std * inertia.value:
        return "needs_data", f"The yaw inertia stays uncertain: {inertia.value:.0f} ± {inertia.std:.0f} kg m^2."
    if inertia.state != "given":
        for i, log in enumerate(bench.names):
            tied = state.errors.correlation(f"n_{i}", "yaw_inertia")
            if abs(tied) > rules.correlation:
                return "needs_data", f"{log} cannot tell n from the yaw inertia: their errors are correlated by {tied:+.2f}."
    seen = sum(f.state == "identified" and not f.no_better for f in numbers.values())
    vague = sum(f.no_better for f in numbers.values())
    others = f", {vague} are fitted and {NO_BETTER}" if vague else ""
    open_ = [name for name, f in numbers.items() if f.state == "not_identifiable"]
    rest = f"; as expected of any vehicle stays what they do not show: {', '.join(open_)}" if open_ else ""
    return "identified", f"{seen} numbers are identified from {len(bench.names)} logs{others}{rest}."
