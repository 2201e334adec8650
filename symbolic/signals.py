"""Named, unit-carrying vectors: the only way a quantity enters or leaves a model."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # a command that only reads names and bounds starts without NumPy
    import numpy as np
    from numpy.typing import NDArray

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}\Z")


@dataclass(frozen=True)
class Signal:
    """One scalar quantity.

    name: a C identifier; unit: SI symbol, "" for a pure number; doc: one line;
    nominal: default value; lower, upper: bounds (lower <= nominal <= upper); spread: how far from nominal it plausibly lies (one
    standard deviation), infinite where nothing is known.
    Raises ValueError for a name that is no identifier, bounds that exclude the nominal value or a spread that is not positive.
    Example: softsoil.Signal("mass", "kg", "mass of the load", nominal=50.0, lower=0.0).upper == float("inf")
    """

    name: str
    unit: str
    doc: str
    nominal: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    spread: float = math.inf

    def __post_init__(self) -> None:
        if not _NAME.match(self.name):
            raise ValueError(f"signal name: expected a C identifier (letters, digits, _), found {self.name!r}")
        if not self.lower <= self.nominal <= self.upper:
            raise ValueError(
                f"signal {self.name}: expected lower <= nominal <= upper, "
                f"found {self.lower} <= {self.nominal} <= {self.upper}"
            )
        if not self.spread > 0:
            raise ValueError(f"signal {self.name}: expected spread > 0, found {self.spread}")


@dataclass(frozen=True)
class Layout(Sequence[Signal]):
    """An ordered vector of signals with distinct names.

    Raises ValueError where two signals share a name.
    Example: softsoil.Layout.of(softsoil.Signal("u", "m/s", "speed", 5.0)).pack(u=6.0)[0] == 6.0
    """

    signals: tuple[Signal, ...] = ()

    def __post_init__(self) -> None:
        seen: set[str] = set()
        for signal in self.signals:
            if signal.name in seen:
                raise ValueError(f"layout: expected distinct names, found {signal.name!r} twice")
            seen.add(signal.name)

    @classmethod
    def of(cls, *signals: Signal) -> Layout:
        """Layout of the given signals, in order."""
        return cls(tuple(signals))

    def __len__(self) -> int:
        return len(self.signals)

    def __iter__(self) -> Iterator[Signal]:
        return iter(self.signals)

    def __getitem__(self, key):
        if isinstance(key, str):
            return self.signals[self.index(key)]
        return self.signals[key]

    def __contains__(self, item: object) -> bool:
        return item in self.names if isinstance(item, str) else item in self.signals

    def __add__(self, other: Layout) -> Layout:
        return Layout(self.signals + tuple(other))

    @property
    def names(self) -> tuple[str, ...]:
        """Names in order."""
        return tuple(signal.name for signal in self.signals)

    @property
    def nominal(self) -> NDArray[np.float64]:
        """(n,) nominal values."""
        return _vector(signal.nominal for signal in self.signals)

    @property
    def lower(self) -> NDArray[np.float64]:
        """(n,) lower bounds."""
        return _vector(signal.lower for signal in self.signals)

    @property
    def upper(self) -> NDArray[np.float64]:
        """(n,) upper bounds."""
        return _vector(signal.upper for signal in self.signals)

    def index(self, name, start=0, stop=None):
        """Position of the signal called `name`; KeyError names what there is."""
        try:
            return self.names.index(name if isinstance(name, str) else name.name)
        except ValueError:
            raise KeyError(f"expected one of {', '.join(self.names) or '(no signals)'}; found {name!r}") from None

    def without(self, *names: str) -> Layout:
        """The layout less the named signals; KeyError for one that is not there."""
        drop = {self.index(name) for name in names}
        return Layout(tuple(s for i, s in enumerate(self.signals) if i not in drop))

    def with_nominal(self, **values: float) -> Layout:
        """The layout with other nominal values; KeyError for a name that is not there."""
        for name in values:
            self.index(name)
        return Layout(tuple(replace(s, nominal=float(values[s.name])) if s.name in values else s for s in self.signals))

    def pack(self, values: Mapping[str, float] | None = None, **more: float) -> NDArray[np.float64]:
        """(n,) vector: nominal values overridden by name; KeyError for a name that is not there."""
        vector = self.nominal
        for name, value in {**(values or {}), **more}.items():
            vector[self.index(name)] = value
        return vector


def _vector(values: Iterable[float]) -> NDArray[np.float64]:
    import numpy as np

    return np.array(list(values), dtype=float)
