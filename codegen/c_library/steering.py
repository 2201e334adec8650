"""A vehicle's steering map as a C header: angles of commands, and commands of angles."""

from __future__ import annotations

from collections.abc import Sequence

from softsoil.codegen.c_library.kernels import number
from softsoil.files.steering_map import SteeringMap

HEADER = "include/softsoil_steering.h"
"""Where it stands in the folder of a vehicle that has a map."""
DIGITS = 17
_TEXT = """\
/* Steering map of the vehicle: command, in the unit of logs and actuator, and mean road-wheel angle (rad). Straight lines between
 * the pairs of the table, the end values beyond. C99, no allocation, no state. Generated: never edited by hand. */
#ifndef SOFTSOIL_STEERING_H
#define SOFTSOIL_STEERING_H

static inline double softsoil_steering_line(const double *from, const double *to, double value)
{{
    int k = 0;
    if (!(value > from[0]))
        return value == value ? to[0] : value;
    if (value >= from[{last}])
        return to[{last}];
    while (value >= from[k + 1])
        ++k;
    return to[k] + (to[k + 1] - to[k]) * ((value - from[k]) / (from[k + 1] - from[k]));
}}

/* Mean road-wheel angle (rad, positive to the left) of a command. */
static inline double softsoil_steer_angle(double command)
{{
    static const double from[{count}] = {{{command}}};
    static const double to[{count}] = {{{angle}}};
    return softsoil_steering_line(from, to, command);
}}

/* Command of a mean road-wheel angle (rad). */
static inline double softsoil_steer_command(double angle)
{{
    static const double from[{count}] = {{{rising_angle}}};
    static const double to[{count}] = {{{its_command}}};
    return softsoil_steering_line(from, to, angle);
}}

#endif
"""


def steering_header(steering: SteeringMap) -> str:
    """The text of HEADER for a steering map."""
    rising = steering.angle[-1] > steering.angle[0]
    order = slice(None) if rising else slice(None, None, -1)
    return _TEXT.format(
        last=len(steering.command) - 1, count=len(steering.command), command=_row(steering.command),
        angle=_row(steering.angle), rising_angle=_row(steering.angle[order]), its_command=_row(steering.command[order]),
    )  # fmt: skip


def _row(values: Sequence[float]) -> str:
    return ", ".join(number(value, DIGITS) for value in values)
