"""Soils: the Bekker-Wong pressure-sinkage and Janosi-Hanamoto shear parameters, with built-in classes and TOML."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from softsoil.files.identify_verdict import verdict_from_table
from softsoil.files.joint_error import joint_error_from_table
from softsoil.files.toml_file import finite, number_table, read_toml, table_inside
from softsoil.symbolic.signals import Layout, Signal

Scalar = Any
"""A float, or a CasADi scalar where a parameter is free."""
Stated = Any
"""Pairs of a parameter's name and its standard deviation."""

Together = Any
"""A JointError, or None."""

SOIL_SIGNALS = Layout.of(
    Signal("k_phi", "N/m^(n+2)", "frictional modulus of sinkage", 692200.0, 0.0, 1e9),
    Signal("k_c", "N/m^(n+1)", "cohesive modulus of sinkage", 13200.0, 0.0, 1e9),
    Signal("n", "", "sinkage exponent", 0.5, 0.2, 1.6),
    Signal("c", "Pa", "cohesion", 4140.0, 0.0, 1e6),
    Signal("phi", "rad", "angle of internal friction", 0.2269, 0.0, 1.2),
    Signal("k", "m", "shear deformation modulus", 0.01, 1e-4, 1.0),
    Signal("K", "Pa/m", "elastic stiffness of unloading and reloading", 2e8, 1e5, 1e12),
    Signal("R", "Pa s/m", "damping of the sinkage rate", 3e4, 0.0, 1e7),
)
"""Names, units, reference values (clay of Table 6) and bounds of the soil parameters."""
CLASS_NUMBERS = ("k_phi", "k_c", "c", "phi", "k")
"""What a class of soil states beside n and may be wrong about (the paper's tables have one value of each)."""
SAME = 0.01
"""Share by which a standard deviation in two tables of one file may differ."""
SOFTEST = 3e4
"""N/m^(n+2): least k_phi + k_c/(0.1 m) of a soil; snow has 2e5, wet lean clay 1e5 (Wong). Below it a table was in kN and kPa."""


@dataclass(frozen=True)
class Soil:
    """A soil: sigma = (k_c/b + k_phi) h^n, tau = (c + sigma tan phi)(1 - exp(-j/k)) (paper, eqs. (1)-(3)).

    Fields in SI units as in SOIL_SIGNALS; K and R are the elastic stiffness and the damping of the soil contact model.
    Each may be a float or a CasADi scalar. uncertainty: name and standard deviation of each that is known with an error, in its
    unit; verdict: of `softsoil soil`, empty for none; joint_error: of those that were identified together, None for none: it
    stands for theirs. Raises ValueError for a float outside its bounds.
    Example: softsoil.Soil("loam", k_phi=1.5e6, k_c=5300.0, n=0.7, c=1700.0, phi=0.5, k=0.025).with_(n=0.6).n == 0.6
    """

    name: str
    k_phi: Scalar
    k_c: Scalar
    n: Scalar
    c: Scalar
    phi: Scalar
    k: Scalar
    K: Scalar = 2e8
    R: Scalar = 3e4
    uncertainty: Stated = ()
    verdict: Any = ""
    joint_error: Together = None

    def __post_init__(self) -> None:
        for signal in SOIL_SIGNALS:
            value = getattr(self, signal.name)
            if isinstance(value, int | float) and not signal.lower <= value <= signal.upper:
                raise ValueError(
                    f"soil {self.name}: expected {signal.name} in [{signal.lower:g}, {signal.upper:g}] {signal.unit}, "
                    f"found {value:g}" + (" (degrees?)" if signal.name == "phi" and value > 1.2 else "")
                )

    def with_(self, **values: Scalar) -> Soil:
        """The same soil with other parameters, by name."""
        return replace(self, **values)

    def parameters(self) -> dict[str, Scalar]:
        """Parameter name -> value, in the order of SOIL_SIGNALS."""
        return {signal.name: getattr(self, signal.name) for signal in SOIL_SIGNALS}


CLAY = Soil("clay", k_phi=692200.0, k_c=13200.0, n=0.5, c=4140.0, phi=0.2269, k=0.01)
SANDY_LOAM = Soil("sandy_loam", k_phi=1515000.0, k_c=5300.0, n=0.7, c=1700.0, phi=0.5061, k=0.025)
SAND = Soil("sand", k_phi=1528600.0, k_c=1000.0, n=1.08, c=200.0, phi=0.4712, k=0.024)
SOILS = {soil.name: soil for soil in (CLAY, SANDY_LOAM, SAND)}
"""Built-in classes: clay and sandy loam of the paper's Table 6, sand of its Table 2."""


def check_n(what: str, n: Any) -> None:
    """Raise ValueError naming `what` for a sinkage exponent that is no number within its bounds."""
    signal = SOIL_SIGNALS["n"]
    if not signal.lower <= n <= signal.upper:
        raise ValueError(f"{what}: expected a sinkage exponent in [{signal.lower:g}, {signal.upper:g}], found {n:g}")


KEYS = frozenset(field.name for field in fields(Soil))
"""Of a soil's file."""


def load_soil(source: str | Path) -> Soil:
    """A built-in class by name, or a TOML file with the parameters of SOIL_SIGNALS (K and R optional).

    Raises ValueError naming the file, the key, what was expected and what was found.
    Example: softsoil.load_soil("sandy_loam").n == 0.7
    """
    if isinstance(source, str) and source in SOILS:
        return SOILS[source]
    path = Path(source)
    if path.suffix != ".toml" or not path.is_file():
        raise ValueError(f"soil: expected one of {', '.join(SOILS)} or a TOML file, found {str(source)!r}")
    table = table_inside(read_toml(path, "soil"), "soil", KEYS, str(path))
    return soil_from_table(table, str(path), path.stem)


def soil_from_table(table: dict[str, Any], where: str, name: str) -> Soil:
    """Soil from a parsed TOML table; ValueError naming `where`, the key, what was expected and what was found."""
    for key in table:
        if key not in KEYS:
            raise ValueError(f"{where}: expected keys {', '.join(sorted(KEYS))}; found {key!r}")
    missing = [s for s in SOIL_SIGNALS if s.name not in table and s.name not in ("K", "R")]
    if missing:
        keys = "; ".join(f"{s.name!r} ({s.doc}, {s.unit})" for s in missing)
        raise ValueError(f"{where}: expected key{'s' if missing[1:] else ''} {keys}, found none")
    values = {s.name: finite(table[s.name], f"{where}: key {s.name!r}") for s in SOIL_SIGNALS if s.name in table}
    most = {key: 10 * abs(values[key]) + 1e-12 for key in CLASS_NUMBERS} | {"phi": 0.3}  # rad: one in degrees is beyond it
    stds = number_table(table, "uncertainty", where, {key: (1e-12, most[key]) for key in CLASS_NUMBERS})
    joint = joint_error_from_table(table.get("joint_error", {}), {*CLASS_NUMBERS}, where)
    for key, std in zip(joint.names, joint.std, strict=True) if joint else ():
        if abs(stds.get(key, std) / std - 1.0) > SAME:
            words = f"expected {std:g}, as [joint_error] has it, found {stds[key]:g}: change both"
            raise ValueError(f"{where}: uncertainty.{key}: {words}")
    verdict = verdict_from_table(table, where)
    stiffness = values["k_phi"] + values["k_c"] / 0.1
    if stiffness < SOFTEST:
        raise ValueError(
            f"{where}: expected k_phi + k_c/(0.1 m) of at least {SOFTEST:g} N/m^(n+2), found {stiffness:g}: no soil is so soft; "
            "k_phi and k_c are in N, c in Pa (kN and kPa?)"
        )
    try:
        return Soil(str(table.get("name", name)), **values, uncertainty=tuple(stds.items()), joint_error=joint, verdict=verdict)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
