"""The turn-slip law with the factors of a calibration on single-wheel runs, the same for all soils and loads.

The factors are kept separate by what they belong to. [soil] would hold what the soil contact model does and the law does
not; it is empty: against a soil contact model whose grid and step are refined, nothing is left to fit. [rig] belongs to
the numerics of the reference rig (grid of 0.025 m, step of 1 ms, the wheel beside its yaw axis). On the vehicle, whose
grid and step differ, [rig] factors make the front-wheel force worse, so they are used on that rig's runs only.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from pathlib import Path

from softsoil.files.toml_file import finite, read_toml
from softsoil.symbolic.laws.turn_slip import Factors, TurnSlip
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact, Wheel, WheelForce

COEFFICIENTS = Path(__file__).parent / "coefficients" / "turn_slip_calibrated.toml"
"""What `softsoil calibrate` wrote for the reference rig."""


SECTIONS = ("soil", "rig", "soil_multiples")
"""Sections of a calibration's TOML."""


def load_factors(path: Path, section: str) -> Factors:
    """Factors of one section (`soil` or `rig`) of a calibration's TOML; neutral where the section is missing.

    Raises ValueError naming the file, the key, what was expected and what was found.
    """
    table = read_toml(path, "calibration")
    for key in table:
        if key not in SECTIONS:
            raise ValueError(f"{path}: expected sections {', '.join(SECTIONS)}; found {key!r}")
    known = {f.name for f in fields(Factors)}
    values: dict[str, float] = {}
    for key, entry in table.get(section, {}).items():
        value = entry.get("value") if isinstance(entry, Mapping) else entry
        if key not in known:
            raise ValueError(f"{path}: [{section}]: expected keys {', '.join(sorted(known))}; found {key!r}")
        values[key] = finite(value, f"{path}: [{section}]: {key}")
    return Factors(**values)


@lru_cache(maxsize=8)
def _packaged(section: str) -> Factors:
    return load_factors(COEFFICIENTS, section)


@dataclass(frozen=True)
class TurnSlipCalibrated:
    """The turn-slip law with fitted factors.

    base: the law and its options; on_reference_rig: use the [rig] factors of the reference rig's own numerics instead of
    the [soil] ones; factors: others in their place, e.g. of a user's own calibration.
    """

    base: TurnSlip = field(default_factory=TurnSlip)
    on_reference_rig: bool = False
    factors: Factors | None = None

    @property
    def name(self) -> str:
        """turn_slip_calibrated."""
        return "turn_slip_calibrated"

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel, as softsoil.symbolic.laws.turn_slip."""
        chosen = self.factors or _packaged("rig" if self.on_reference_rig else "soil")
        return replace(self.base, factors=chosen)(soil, wheel, contact)
