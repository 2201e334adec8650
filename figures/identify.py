"""Pictures of an identification: numbers against what was expected, what each costs n, errors before and after."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from softsoil.figures.labels import SYMBOLS, plain, quantity
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, page
from softsoil.identification.result import Identification, in_order
from softsoil.recording.drive import STATE_CHANNELS

COLOURS = {"given": SOFT, "identified": ESTIMATED, "not_identifiable": REAR}


def draw_numbers(result: Identification, path: Path) -> Path:
    """Each number and its standard deviation, in standard deviations of what was expected; returns the path."""
    names = in_order(result.numbers)
    with page(path, "Numbers against what was expected before the logs", 8.0, 0.24 * len(names) + 1.2) as axis:
        at = np.arange(len(names))[::-1]
        axis.barh(at, 2.0, left=-1.0, height=0.62, color="#e4e7eb", label="expected ± std")
        for y, name in zip(at, names, strict=True):
            one = result.numbers[name]
            value, std = (one.value - one.before[0]) / one.before[1], one.std / one.before[1]
            axis.errorbar(value, y, xerr=std, fmt="o", ms=4, capsize=2, color=COLOURS[one.state])
        for state, colour in COLOURS.items():
            axis.plot([], [], "o", color=colour, label=plain(state))
        axis.set_yticks(at, [plain(name) for name in names])
        axis.set_xlabel("(value - expected)/standard deviation of what was expected")
        axis.legend(loc="upper left")
    return path


def draw_costs(result: Identification, path: Path) -> Path:
    """Change of n by an error of one standard deviation of each number; returns the path."""
    names = sorted(in_order(result.numbers), key=lambda name: abs(result.numbers[name].n_percent_per_std))[-12:]
    with page(path, "What an error of each number costs n", 8.0, 3.6) as axis:
        at = np.arange(len(names))
        costs = [result.numbers[name].n_percent_per_std for name in names]
        axis.barh(at, costs, color=[COLOURS[result.numbers[name].state] for name in names], height=0.62)
        axis.set_yticks(at, [plain(name) for name in names])
        axis.set_xlabel("change of n by one standard deviation, %")
    return path


def draw_errors(result: Identification, path: Path) -> Path:
    """Root mean square error of the log left out, before and after, per horizon and state; returns the path."""
    horizons = list(result.judged.before)
    with page(path, f"{result.judged.log}: prediction errors before and after", 10.0, 3.4, 1, len(horizons)) as axes:
        at = np.arange(len(STATE_CHANNELS))
        for axis, horizon in zip(axes, horizons, strict=True):
            pairs = ((result.judged.before, INITIAL, "before", -0.2), (result.judged.after, ESTIMATED, "after", 0.2))
            for table, colour, label, shift in pairs:
                values = [quantity(s).factor * np.sqrt(table[horizon][s]) for s in STATE_CHANNELS]
                axis.bar(at + shift, values, 0.38, color=colour, label=label)
            axis.set_yscale("log")
            axis.set_xticks(at, [f"{SYMBOLS[s]}\n{quantity(s).unit}" for s in STATE_CHANNELS])
            axis.grid(axis="x", visible=False)
            axis.set_title(f"Predicted {horizon} s ahead")
        axes[0].set_ylabel("rms error, units as named")
        axes[0].legend(loc="upper left")
    return path
