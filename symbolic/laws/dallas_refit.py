"""The paper's surrogate with correction factors fitted again, by the paper's procedure, on other single-wheel runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

from softsoil.files.toml_file import read_toml
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.dallas import Branch, Dallas, Factor, SlipRange
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact, Wheel, WheelForce

COEFFICIENTS = Path(__file__).parent / "coefficients" / "dallas_refit.toml"
"""Correction factors per soil class and slip range, fitted on the `cal` runs of the reference rig."""
N_RANGE = (0.4, 1.3)
"""Range of n in those runs."""


@dataclass(frozen=True)
class DallasRefit:
    """The paper's surrogate, refitted per soil class and slip range; valid for the wheel and soils of the fit only.

    tables: soil class -> slip ranges (the packaged ones by default); base: the Bekker law corrected. by_class: its numbers go by
    the soil's name, so that a model built on one class is none of another.
    """

    tables: Mapping[str, Sequence[SlipRange]] | None = None
    base: Bekker = field(default_factory=Bekker)
    by_class: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """dallas_refit."""
        return "dallas_refit"

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel; ValueError for a soil class (soil.name) that was not fitted."""
        tables = self.tables if self.tables is not None else packaged()
        name = soil_class(soil.name)
        if name not in tables:
            raise ValueError(f"dallas_refit: expected a soil class of {', '.join(tables)}, found {soil.name!r}")
        return Dallas(tables[name], self.base, n_range=N_RANGE)(soil, wheel, contact)


def soil_class(name: str) -> str:
    """`name` without underscores, so that sandy_loam and sandyloam are one class."""
    return name.replace("_", "")


def load_tables(path: Path) -> dict[str, list[SlipRange]]:
    """Correction factors from TOML; ValueError for what is not such a table."""
    table = read_toml(path, "correction factors")
    try:
        return {name: [_slip_range(entry) for entry in entries] for name, entries in table["soil"].items()}
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{path}: expected correction factors of dallas_refit, found: {error!r}") from None


@lru_cache(maxsize=1)
def packaged() -> dict[str, list[SlipRange]]:
    """The packaged correction factors."""
    return load_tables(COEFFICIENTS)


def _slip_range(entry: Mapping[str, Any]) -> SlipRange:
    def branch(name: str) -> Branch:
        return Branch(*[_factor(entry[name][g]) for g in ("g_1", "g_2", "g_3")])

    return SlipRange(float(entry["low"]), float(entry["high"]), branch("lower"), branch("upper"))


def _factor(entry: Mapping[str, Any]) -> Factor:
    return Factor(
        n=tuple(map(float, entry["n"])),
        s=tuple(map(float, entry["s"])),
        load=tuple(map(float, entry["load"])),
        speed=(float(entry["speed"][0]), float(entry["speed"][1])),
        n_positive=bool(entry["n_positive"]),
    )
