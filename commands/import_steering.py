"""The steering of an import: angles from commands by the vehicle's map, or a map from a log that has both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from softsoil.commands.output import console
from softsoil.importing.import_map import STEER_COMMAND, ImportMap, Mapped
from softsoil.importing.merge import wanted_span
from softsoil.importing.sources import Series
from softsoil.importing.steering_fit import SteeringFit, fit_steering_map
from softsoil.symbolic.vehicle import Vehicle


def steered(plan: ImportMap, vehicle: Vehicle) -> ImportMap:
    """The plan with `steer` made of `steer_command` by the vehicle's steering map, where it maps no `steer` of its own.

    Raises ValueError for a vehicle without a steering map.
    """
    command = plan.channels.get(STEER_COMMAND)
    if command is None or "steer" in plan.channels:
        return plan
    if vehicle.steering is None:
        raise ValueError(
            f"map: channels.{STEER_COMMAND}: expected channels.steer beside it, or a vehicle with a table [steering]; vehicle "
            f"{vehicle.name} has none"
        )
    if command.table is not None or command.offset:
        raise ValueError(f"map: channels.{STEER_COMMAND}: expected the command as recorded, found a table or an offset")
    steer = replace(command, table=vehicle.steering.pairs)
    return without_command(replace(plan, channels={**plan.channels, "steer": steer}))


def without_command(plan: ImportMap) -> ImportMap:
    """The plan without `steer_command`, which is no channel of a drive."""
    return replace(plan, channels={name: one for name, one in plan.channels.items() if name != STEER_COMMAND})


def fitted_map(plan: ImportMap, series: Mapping[str, Series]) -> SteeringFit | None:
    """The steering map of a log with both channels, None for one without; of the part that the map's [clock] wants.

    plan: the import's; series: by source. Raises ValueError where the angles do not follow the command.
    """
    if STEER_COMMAND not in plan.channels:
        return None
    (t, command), (of_angle, angle) = (_values(plan.channels[name], series) for name in (STEER_COMMAND, "steer"))
    begin, end = wanted_span(plan, series)
    inside = (of_angle >= max(t[0], begin)) & (of_angle <= min(t[-1], end))
    return fit_steering_map(of_angle[inside], np.interp(of_angle[inside], t, command), angle[inside])


def _values(mapped: Mapped, series: Mapping[str, Series]) -> tuple[np.ndarray, np.ndarray]:
    one = series[mapped.source]
    values = mapped.si(mapped.samples(one), 1.0) + mapped.offset
    good = np.isfinite(values)
    return one.t[good] - mapped.late, values[good]


def say_map(fit: SteeringFit) -> dict[str, Any]:
    """Print what was fitted; the entry `steering` of import.json."""
    words = "a straight line" if fit.degree == 1 else f"a polynomial of degree {fit.degree}"
    console.print(
        f"steering map: {words}, ± {np.degrees(fit.std):.2g} deg; the wheels follow the command by {fit.delay:.3f} s"
        f"{f' and a lag of {fit.lag:.3f} s' if fit.lag else ''}, and "
        f"{np.degrees(fit.residual):.2g} deg rms of their angle stay unexplained", highlight=False,
    )  # fmt: skip
    return {
        "command": list(fit.map.command), "angle": list(fit.map.angle), "degree": fit.degree, "std": fit.std,
        "residual": fit.residual, "delay_s": fit.delay, "lag_s": fit.lag,
    }  # fmt: skip
