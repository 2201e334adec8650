"""What an identified gain of the steering says of the map that logs were imported by."""

from __future__ import annotations

from collections.abc import Mapping

from softsoil.identification.result import Found
from softsoil.refinement.words import with_error
from softsoil.symbolic.vehicle import Vehicle
from softsoil.windows.own_numbers import steering_scale_of

LEAST, SIGMAS = 0.05, 3.0
"""Share, and standard errors, by which road wheels must turn more or less than the logs say: a linkage gives some per cent."""


def steering_ratio(numbers: Mapping[str, Found], vehicle: Vehicle) -> tuple[str, ...]:
    """A note where the road wheels of a vehicle turn by another share of the recorded angle than a linkage gives; none else.

    numbers: that were identified, by name.
    """
    name = steering_scale_of(vehicle).parameters[0].name
    one = numbers.get(name)
    if one is None or one.state != "identified" or abs(one.value - 1.0) <= max(LEAST, SIGMAS * one.std):
        return ()
    return (
        f"{name}: road wheels turn {with_error(one.value, one.std)} times as far as the logs say, more than a linkage makes of "
        f"it: where steer comes from a hand wheel, its ratio in the map of the import is {1.0 / one.value:.3f} times the one "
        "there (a wrong unit or a command does it, too). This file makes up for it wherever steer is recorded alike",
    )
