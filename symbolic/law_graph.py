"""A force law's expressions, written once per kind of wheel.

A law makes a thousand expressions of each wheel, one Python call each, the same for every model of it: here they are made once,
of symbols, and CasADi puts a wheel's own quantities in their places, with the simplifications that the law itself would meet.
"""

from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import casadi as ca

from softsoil.symbolic.soil import SOIL_SIGNALS, Soil
from softsoil.symbolic.wheel import Contact, ForceLaw, Wheel, WheelForce

CONTACT = tuple(one.name for one in fields(Contact))
RESULTS = tuple(one.name for one in fields(WheelForce))
NUMBERS = len(SOIL_SIGNALS.names) + 2


def wheel_force(law: ForceLaw, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
    """law(soil, wheel, contact), the same expressions.

    law: called itself where it holds more than numbers and names, or for quantities that are neither floats nor SX scalars.
    """
    soils = tuple(getattr(soil, name) for name in SOIL_SIGNALS.names)
    values = (*soils, wheel.radius, wheel.width, *(getattr(contact, name) for name in CONTACT))
    given = tuple(float(value) if isinstance(value, int | float) else None for value in values)
    free = [value for value, number in zip(values, given, strict=True) if number is None]
    known = not (soil.uncertainty or soil.verdict) and type(contact) is Contact
    if not (known and _constant(law) and all(isinstance(value, ca.SX) and value.is_scalar() for value in free)):
        return law(soil, wheel, contact)
    function, found = _graph(law, soil.name, given)  # type: ignore[arg-type]
    results = iter(function.call(free))
    return WheelForce(*(next(results) if number is None else number for number in found))


def _constant(value: Any) -> bool:
    """Whether a value is made of numbers and names only, in frozen dataclasses and tuples: it can't change, nor hold symbols."""
    if isinstance(value, tuple):
        return all(_constant(one) for one in value)
    if is_dataclass(value) and not isinstance(value, type):
        frozen = type(value).__dataclass_params__.frozen  # type: ignore[attr-defined]
        return frozen and all(_constant(getattr(value, one.name)) for one in fields(value))
    return isinstance(value, str | int | float | None)


@lru_cache(maxsize=64)
def _graph(law: ForceLaw, name: str, given: tuple[float | None, ...]) -> tuple[ca.Function, tuple[Any, ...]]:
    """The law as a function of the quantities that are not given, and its results, None for those that the function has."""
    symbols = [ca.SX.sym(f"q{i}") if value is None else value for i, value in enumerate(given)]
    soil = Soil(name, **dict(zip(SOIL_SIGNALS.names, symbols, strict=False)))
    contact = Contact(**dict(zip(CONTACT, symbols[NUMBERS:], strict=True)))
    force = law(soil, Wheel(*symbols[NUMBERS - 2 : NUMBERS]), contact)
    results = [getattr(force, name) for name in RESULTS]
    made = [one for one in results if isinstance(one, ca.SX)]
    function = ca.Function("law", [one for one in symbols if isinstance(one, ca.SX)], made)
    return function, tuple(None if isinstance(one, ca.SX) else one for one in results)
