"""Picture of numbers that logs have identified, against what was expected of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np

from softsoil.figures.labels import plain
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, page

COLOURS = {"given": SOFT, "identified": ESTIMATED, "not_identifiable": REAR, "fitted": INITIAL}
"""State of a number -> its colour; "fitted": no better known by the logs than before."""


class Number(Protocol):
    """A number of a vehicle or of a soil: value and standard deviation, both as expected beforehand (`before`), its state,
    and whether it was fitted and is no better known than before."""

    @property
    def value(self) -> float: ...
    @property
    def std(self) -> float: ...
    @property
    def before(self) -> tuple[float, float]: ...
    @property
    def state(self) -> str: ...
    @property
    def no_better(self) -> bool: ...


def shown_states(numbers: Mapping[str, Number]) -> dict[str, str]:
    """Key of COLOURS for each number."""
    return {name: "fitted" if one.no_better else one.state for name, one in numbers.items()}


def draw_numbers(numbers: Mapping[str, Number], path: Path) -> Path:
    """Each number and its standard deviation, in standard deviations of what was expected; returns the path.

    numbers: name -> number, from top to bottom.
    """
    names, states = list(numbers), shown_states(numbers)
    with page(path, "Numbers against what was expected before the logs", 9.0, 0.24 * len(names) + 1.2) as axis:
        at = np.arange(len(names))[::-1]
        axis.barh(at, 2.0, left=-1.0, height=0.62, color="#e4e7eb", label="expected ± std")
        for y, name in zip(at, names, strict=True):
            one = numbers[name]
            value, std = (one.value - one.before[0]) / one.before[1], one.std / one.before[1]
            axis.errorbar(value, y, xerr=std, fmt="o", ms=4, capsize=2, color=COLOURS[states[name]])
        for state, colour in COLOURS.items():
            if state in states.values():
                axis.plot([], [], "o", color=colour, label=plain(state))
        axis.set_yticks(at, [plain(name) for name in names])
        axis.set_xlabel("(value - expected)/standard deviation of what was expected")
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return path
