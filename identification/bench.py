"""Drives of one vehicle ready for an identification: a model with its numbers free, windows and wheel balances of each drive."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from softsoil.identification.wheel_balance import WheelBalance, balances
from softsoil.recording.drive import Recording
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.unknown_ground import N_NAMES, free_n
from softsoil.refinement.vehicle_numbers import WIDE, by_name, expected, free_layout, vehicle_of
from softsoil.refinement.wheel_speeds import all_open
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import Vehicle
from softsoil.windows.absent_wheels import absent_wheels, with_log_wheels
from softsoil.windows.free_starts import FASTEST, free_windows, steps_of
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import Drive, shooting_drive
from softsoil.windows.window_fit import ITERATIONS, WindowFit, fit_windows, window_costs

Array = NDArray[np.float64]

FIRST_N = (-0.2, 0.0, 0.2)
"""First guesses of a drive's n beside its soil's own."""


@dataclass(frozen=True)
class Bench:
    """What all fits of an identification share.

    known; vehicle: with every number as expected; model: its numbers as parameters; names of the drives; recordings; soils;
    drives; windows, balances: one per drive, or no balances; p (D, n_p): parameters of each drive, numbers as expected.
    """

    known: Known
    vehicle: Vehicle
    model: Model
    names: tuple[str, ...]
    recordings: tuple[Recording, ...]
    soils: tuple[Soil, ...]
    drives: tuple[Drive, ...]
    windows: tuple[FreeWindows, ...]
    balances: tuple[WheelBalance, ...]
    p: Array

    def only(self, chosen: Sequence[int]) -> Bench:
        """The bench of the `chosen` drives, by index."""

        def of(values: Sequence) -> tuple:
            return tuple(values[i] for i in chosen) if values else ()

        return Bench(
            self.known, self.vehicle, self.model, of(self.names), of(self.recordings), of(self.soils), of(self.drives),
            of(self.windows), of(self.balances), self.p[list(chosen)],
        )  # fmt: skip

    def parameters(self, values: Mapping[str, float], n: Sequence[float]) -> Array:
        """(D, n_p) parameters with the numbers `values` and each drive's n."""
        p = self.p.copy()
        for name, value in values.items():
            p[:, self.model.p.index(name)] = value
        for name in N_NAMES:
            p[:, self.model.p.index(name)] = n
        return p


def make_bench(
    recordings: Sequence[Recording],
    soils: Sequence[Soil],
    known: Known,
    start: float,
    progress: Callable[[float], None] = lambda share: None,
) -> Bench:
    """The bench of the drives.

    soils: one per drive, n unknown; start: seconds left out at the beginning of each drive.
    Raises ValueError for drives that cannot be used.
    """
    recordings = list(recordings)
    vehicle = vehicle_of(known, {})
    layout = free_layout(known)
    models = [with_log_wheels(bicycle(vehicle, soil, "turn_slip", None, layout), recordings) for soil in soils]
    rolling = not absent_wheels(recordings)
    model = models[0]
    drives = [shooting_drive(recording, model, start) for recording in recordings]
    compiled: dict[float, WindowModel] = {}
    windows, beside = [], []
    p = np.array([m.p.nominal for m in models])
    for i, (recording, drive) in enumerate(zip(recordings, drives, strict=True)):
        key = round(drive.dt, 7)
        if key not in compiled:
            compiled[key] = WindowModel(model, drive.dt, steps_of(drive.dt), balances(model) if rolling else None)
        windows.append(free_windows(compiled[key], drive, recording))
        if rolling:
            beside.append(WheelBalance(windows[-1], p[i], all_open(recording, vehicle), FASTEST))
        progress((i + 1) / len(drives))
    return Bench(
        known, vehicle, model, tuple(r.name for r in recordings), tuple(recordings), tuple(soils), tuple(drives),
        tuple(windows), tuple(beside), p,
    )  # fmt: skip


def free_numbers(
    bench: Bench,
    names: Sequence[str],
    doubted: Sequence[str] = (),
    instead: Mapping[str, tuple[float, float]] = MappingProxyType({}),
) -> list[Free]:
    """The named numbers as free ones with what is known of them.

    doubted: given ones whose measuring is not believed; instead: number -> (value, standard deviation) in the place of what is
    given.
    """
    numbers, before = by_name(), {**expected(bench.known), **instead}
    free = []
    for name in names:
        number, (value, std) = numbers[name], before[name]
        if name in doubted and name not in instead:
            std = max(number.prior(bench.known)[1], WIDE * abs(value))
        free.append(Free(name, (name,), std / 2, number.lower, number.upper, known=(value, std)))
    return free


def fit_numbers(
    bench: Bench, free: Sequence[Free], values: Mapping[str, float], n: Sequence[float], iterations: int = ITERATIONS
) -> WindowFit:
    """The free numbers, and n of each drive, that predict the windows and balance the wheels best.

    values: where numbers start, and where those that are not free stand; n: first guesses; iterations: at most, 0 for
    derivatives at the start.
    """
    p = bench.parameters(values, n)
    start = np.array([*(values.get(f.name, bench.p[0, bench.model.p.index(f.name)]) for f in free), *n])
    return fit_windows(bench.windows, [*free, *free_n(len(bench.windows))], start, p, bench.balances, iterations)


def first_n(bench: Bench, values: Mapping[str, float]) -> list[float]:
    """n of each drive alone, with the numbers `values`, from the best of a few first guesses."""
    found = []
    for i, soil in enumerate(bench.soils):
        one = bench.only([i])
        tries = []
        for shift in FIRST_N:
            guess = float(np.clip(float(soil.n) + shift, 0.25, 1.5))
            p = one.parameters(values, [guess])
            tries.append((float(window_costs(one.windows[0].residual(p[0], one.windows[0].first)).mean()), guess))
        guess = min(tries)[1]
        fit = fit_windows(one.windows, free_n(1), np.array([guess]), one.parameters(values, [guess]))
        found.append(float(fit.value[0]))
    return found
