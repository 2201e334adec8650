"""Where the force laws hold: numbers are checked here, at the edge, since a law itself is one smooth expression."""

from __future__ import annotations

import math

from softsoil.symbolic.wheel import DEEPEST, Contact, Wheel


def check_contact(contact: Contact) -> None:
    """Raise ValueError for numbers outside the domain of the force laws; CasADi scalars pass.

    Forward motion (v_x >= 0: reversing is excluded), spin forward or locked (omega >= 0), load >= 0, entry_path >= 0,
    rut_depth >= 0, overlap between 0 and 1, all finite.
    """
    for name, value in vars(contact).items():
        if not isinstance(value, int | float):
            continue
        if not math.isfinite(value):
            raise ValueError(f"contact: expected a finite {name}, found {value}")
        if name in ("v_x", "omega", "load", "entry_path", "rut_depth") and value < 0:
            raise ValueError(f"contact: expected {name} >= 0 (forward motion, load on the soil), found {value:g}")
        if name == "overlap" and not 0 <= value <= 1:
            raise ValueError(f"contact: expected overlap in [0, 1], found {value:g}")


def check_sinkage(sinkage: float, wheel: Wheel) -> None:
    """Raise ValueError for a sinkage (m) at which the contact reaches the axle and no law holds."""
    most = 0.8 * DEEPEST * wheel.radius
    if not sinkage <= most:
        raise ValueError(
            f"sinkage: expected at most {most:.3f} m for a wheel of radius {wheel.radius:g} m, found {sinkage:.3f} m "
            "(the soil does not carry this load)"
        )
