"""Numbers of a vehicle that its drives may doubt: how well each is known, which are free beside n, and which may be wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from softsoil.refinement.fit import Free
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.rules import RULES
from softsoil.refinement.trace import Bench, fit_base, reweighted
from softsoil.refinement.vehicle_numbers import FIXED, OTHER_GROUND, WIDE, by_name, expected, own_layout
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import NUMBERS, Vehicle

HALF_WAY = 0.5
"""Share of the way from one kind of ground to the other from which on drives show that it is the other."""


@dataclass(frozen=True)
class Doubt:
    """A number of the vehicle, or a parameter of one of its declared effects, that drives may move.

    signal: its name, unit, bounds and declared value; std: standard deviation of the declared value; wide: the same where
    the declaration is not believed.
    """

    signal: Signal
    std: float
    wide: float

    @property
    def free(self) -> Free:
        """The number as a free one with what is known of it."""
        s = self.signal
        return Free(s.name, (s.name,), self.std / 2, s.lower, s.upper, known=(float(s.nominal), self.std))


def known_of(vehicle: Vehicle) -> Known:
    """What the owner of a complete vehicle file knows: a number at its default was not measured, unless its error is stated."""
    values = {n.name: float(getattr(vehicle, n.name)) for n in NUMBERS}
    numbers = {n.name: values[n.name] for n in NUMBERS if values[n.name] != n.default or n.name in vehicle.uncertainty}
    given = (vehicle.effects, vehicle.uncertainty, vehicle.source, vehicle.simulator)
    return Known(vehicle.name, numbers, *given, driveline=vehicle.driveline)


def doubts(vehicle: Vehicle) -> dict[str, Doubt]:
    """Numbers that logs may move, by name: those that an identification frees, and the parameters of declared effects.

    The standard deviation is the one that the vehicle file states, else that of measuring the number, or the prior of one that
    stands at its default, as in an identification; for other effects' parameters their plausible spread. Not those that are
    drawn or that an identification holds fixed, nor those of effects that are tried again.
    """
    known, numbers = known_of(vehicle), by_name()
    before = expected(known)

    def wide(name: str, value: float, std: float) -> float:
        number = numbers.get(name)
        return max(std, WIDE * abs(value), 0.0 if number is None else number.prior(known)[1])

    found = {}
    for signal in own_layout(vehicle):
        std = before[signal.name][1]
        found[signal.name] = Doubt(signal, std, wide(signal.name, float(signal.nominal), std))
    for key, values in vehicle.effects.items():
        effect = catalogue(vehicle)[key]
        for name, value in values.items():
            signal = effect.parameters[name]
            std = vehicle.uncertainty.get(name, before[name][1] if name in before else signal.spread)
            fixed = name in FIXED.get(key, {}) or name in effect.drawn or effect.repeats
            if not fixed and value != signal.nominal and np.isfinite(std):
                found[name] = Doubt(replace(signal, nominal=value), std, wide(name, value, std))
    return found


def grounds(vehicle: Vehicle) -> dict[str, Doubt]:
    """The parameters of declared effects that say of which kind the ground is, by name: no drive moves them by a little."""
    found = {}
    for key, table in OTHER_GROUND.items():
        effect = catalogue(vehicle)[key]
        for name in table if key in vehicle.effects else ():
            signal = effect.parameters[name]
            way = abs(FIXED[key][name] - table[name])
            declared = replace(signal, nominal=vehicle.effects[key].get(name, signal.nominal))
            found[name] = Doubt(declared, HALF_WAY * way, way)
    return found


def other_ground(vehicle: Vehicle) -> dict[str, Effect]:
    """Ground of the other kind than the declared one, as candidates by name: from half of the way on it is that."""
    return {
        name: replace(
            wrong_number(doubt), doc="ground of the other kind than declared", kind="soil", separates="drives on both kinds",
            parameters=Layout.of(replace(doubt.signal, spread=HALF_WAY * doubt.wide / RULES.least_size)),
        )
        for name, doubt in grounds(vehicle).items()
    }  # fmt: skip


def loosened(bench: Bench, vehicle: Vehicle) -> tuple[Bench, dict[str, Effect]]:
    """The bench with the numbers of the vehicle free within what is known of them, fitted with n; and, by name, those that may be
    declared wrong, as candidates.

    A number whose standard deviation moves the predictions by less than RULES.least_doubt of what is left stays as declared.
    So does one that the drives contradict by RULES.contradicted: an effect may be the reason, so that both are candidates.
    """
    table = doubts(vehicle)
    loose = tuple(doubt.free for doubt in table.values())
    loose = tuple(f for f, moved in zip(loose, _moved(bench, loose), strict=True) if moved >= RULES.least_doubt)
    wrong = {free.name: wrong_number(table[free.name]) for free in loose}
    while loose:
        last = fit_base(replace(bench, loose=loose))
        sigmas = {free.name: departure(free, *last.named()[free.name]) for free in loose}
        worst = max(loose, key=lambda free: sigmas[free.name])
        if sigmas[worst.name] <= RULES.contradicted:
            return reweighted(replace(bench, loose=loose, absent=last.p)), wrong
        loose = tuple(free for free in loose if free is not worst)
    return bench, wrong


def departure(free: Free, value: float, std: float) -> float:
    """Standard deviations, of the drives and of what is declared together, by which the drives alone depart from it.

    value, std: of a fit that knew what is declared, N(g, w^2): the drives alone say (value/std^2 - g/w^2) V with
    1/V = 1/std^2 - 1/w^2.
    """
    given, stated = free.known or (value, np.inf)
    precision = 1.0 / std**2 - 1.0 / stated**2
    if not precision > 0.0:
        return 0.0
    alone = (value / std**2 - given / stated**2) / precision
    return float(abs(alone - given) / np.hypot(precision**-0.5, stated))


def _moved(bench: Bench, loose: tuple[Free, ...]) -> list[float]:
    """Rms change of the predictions of the fitted windows by one standard deviation of each number, over what is left there."""
    totals = np.zeros(len(loose))
    count = 0
    for shooting, windows, row in zip(bench.shootings, bench.fitted, bench.absent, strict=True):
        rows = np.tile(row, (1 + len(loose), 1))
        for i, free in enumerate(loose):
            value, std = free.known or (0.0, 0.0)
            rows[1 + i, bench.model.p.index(free.name)] = value + std if value + std <= free.upper else value - std
        z = np.nan_to_num(shooting.residual(rows, windows) / bench.weights.sigma)
        totals += ((z[1:] - z[0]) ** 2).sum(axis=(1, 2, 3))
        count += z[0].size
    return [float(v) for v in np.sqrt(totals / count)]


def wrong_number(doubt: Doubt) -> Effect:
    """A number as what a drive may have in the place of an effect: declared wrong by more than is stated."""
    s = doubt.signal
    value = float(s.nominal)
    typical = value + doubt.wide if value + doubt.wide <= s.upper else value - doubt.wide
    return Effect(
        name=s.name,
        doc=f"the vehicle's {s.name}, declared as {value:.4g} {s.unit}".rstrip(),
        kind="body",
        reference="the vehicle file",
        parameters=Layout.of(replace(s, spread=doubt.wide)),
        typical={s.name: float(np.clip(typical, s.lower, s.upper))},
        corrections={},
        separates="a new identification of the vehicle on full-lock and multi-sine drives",
    )
