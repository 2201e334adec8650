"""Joint error of numbers that were identified together, standard deviations and correlations, in a vehicle's or a soil's file."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softsoil.files.toml_file import finite, toml_number, toml_text

KEYS = ("names", "std", "correlation")
ROUNDED = 0.01
"""By which an eigenvalue of the correlations may be below 0: written to two digits, they are not exact."""


@dataclass(frozen=True)
class JointError:
    """Gaussian error of K numbers.

    names (K,); std (K,): standard deviation of each, in its unit, whatever the others are; correlation: row i has the
    correlations of number i with those before it. Raises ValueError for lengths that differ or values out of range.
    Example: JointError(("track", "scrub"), (0.04, 0.03), ((), (0.9,))).covariance[0, 1] == 0.9 * 0.04 * 0.03
    """

    names: tuple[str, ...]
    std: tuple[float, ...]
    correlation: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        count = len(self.names)
        lengths = [len(self.std), len(self.correlation), len({*self.names})]
        if not count or lengths != [count] * 3 or [len(row) for row in self.correlation] != [*range(count)]:
            raise ValueError("joint_error: expected a std and a row of 0, 1, 2 ... correlations for each of different names")
        if not all(np.isfinite(self.std)) or min(self.std, default=1.0) <= 0:
            raise ValueError(f"joint_error: expected positive standard deviations, found {list(self.std)}")
        if any(not abs(value) <= 1.0 for row in self.correlation for value in row):
            raise ValueError("joint_error: expected correlations from -1 to 1, found one beyond")
        least = float(np.linalg.eigvalsh(self.covariance / np.outer(self.std, self.std))[0])
        if least < -ROUNDED:
            raise ValueError(f"joint_error: expected correlations that go together, found an eigenvalue of {least:.2f}")

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(K, K) covariance of the numbers."""
        matrix = np.eye(len(self.names))
        for i, row in enumerate(self.correlation):
            matrix[i, :i] = matrix[:i, i] = row
        return matrix * np.outer(self.std, self.std)

    def only(self, known: Set[str]) -> JointError | None:
        """The error of those numbers alone whose names are known; None where there are none."""
        kept = [i for i, name in enumerate(self.names) if name in known]
        names, std = tuple(self.names[i] for i in kept), tuple(self.std[i] for i in kept)
        rows = tuple(tuple(self.correlation[i][k] for k in kept[:place]) for place, i in enumerate(kept))
        return JointError(names, std, rows) if kept else None

    def toml(self, table: str = "joint_error") -> list[str]:
        """Lines of the table called `table` in a file."""
        names, std = ", ".join(map(toml_text, self.names)), ", ".join(map(toml_number, self.std))
        rows = (f"  [{', '.join(f'{value:.6f}' for value in row)}]," for row in self.correlation)
        return [f"[{table}]", f"names = [{names}]", f"std = [{std}]", "correlation = [", *rows, "]"]


def joint_error_of(names: tuple[str, ...], covariance: NDArray[np.float64]) -> JointError:
    """The error with a covariance (K, K), rounded as a file has it."""
    std = np.sqrt(np.diag(covariance))
    matrix = np.clip(covariance / np.outer(std, std), -1.0, 1.0)
    rows = tuple(tuple(round(float(matrix[i, k]), 6) for k in range(i)) for i in range(len(names)))
    return JointError(names, tuple(float(f"{value:.6g}") for value in std), rows)


def independent_error(stds: Mapping[str, float]) -> JointError | None:
    """The error of numbers that were measured one by one; stds: standard deviation of each, None for none of them."""
    return JointError((*stds,), (*stds.values(),), tuple((0.0,) * row for row in range(len(stds)))) if stds else None


def joint_error_from_table(value: Any, known: Set[str], where: str) -> JointError | None:
    """The error in a parsed table `joint_error`, None for an empty one; known: names that it may have.

    Raises ValueError naming `where`, the key, what was expected and what came.
    """
    if not isinstance(value, dict) or (value and {*value} != {*KEYS}):
        raise ValueError(f"{where}: expected a table [joint_error] of {', '.join(KEYS)}, found {value!r}")
    if not value:
        return None
    if not all(isinstance(value[key], list) for key in KEYS) or not all(isinstance(row, list) for row in value["correlation"]):
        raise ValueError(f"{where}: joint_error: expected lists of names, std and rows of correlation")
    for name in value["names"]:
        if not isinstance(name, str) or name not in known:
            raise ValueError(f"{where}: joint_error: expected names of {', '.join(sorted(known))}; found {name!r}")
    std = tuple(finite(one, f"{where}: joint_error.std") for one in value["std"])
    rows = tuple(tuple(finite(one, f"{where}: joint_error.correlation") for one in row) for row in value["correlation"])
    try:
        return JointError(tuple(value["names"]), std, rows)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
