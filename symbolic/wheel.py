"""The interface of every force law: what a wheel meets, what it gives back, and the laws by name.

Conventions (stated once, for every law): wheel frame, x forward in the wheel plane, y left, z up; SI units, radians.
(v_x, v_y) is the velocity of the wheel centre in the wheel frame: v_y = -v sin(alpha) with alpha the slip angle,
alpha = steering angle - course angle. Forces act on the wheel, in the wheel frame; forces are per wheel.
Longitudinal slip (paper): s = 1 - v_x/(r omega) when driving, s = r omega/v_x - 1 when braking.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Protocol

from softsoil.files.own_modules import LAWS, made, module_names
from softsoil.symbolic import laws
from softsoil.symbolic.soil import Soil

Scalar = Any
"""A CasADi SX scalar, or a float."""


LOAD_WIDTH = 0.1
"""N: loads below this are smoothed towards zero, so that a wheel in the air carries nothing instead of failing."""
DEEPEST = 0.9
"""Sinkage over radius at which the smooth cap of the sinkage bends, short of the axle."""


@dataclass(frozen=True)
class Wheel:
    """A rigid cylinder wheel: radius (m), width (m), floats or CasADi scalars. ValueError for floats not positive."""

    radius: Scalar
    width: Scalar

    def __post_init__(self) -> None:
        numbers = [value for value in (self.radius, self.width) if isinstance(value, int | float)]
        if not all(value > 0 for value in numbers):
            raise ValueError(f"wheel: expected positive radius and width (m), found {self.radius} and {self.width}")


@dataclass(frozen=True)
class Contact:
    """The state of one wheel on the soil; each field a CasADi scalar or a float.

    v_x, v_y: velocity of the wheel centre in the wheel frame (m/s), v_x > 0;
    omega: spin (rad/s, forward positive); load: force that the soil carries (N);
    yaw_rate: yaw rate of the wheel body, steering rate + omega_z (rad/s); steer_rate: its steering part (rad/s);
    dv_y: rate of v_y in the wheel frame, a_y - yaw_rate v_x (m/s^2), for laws that know shear history;
    entry_path: shear path already spent in the soil where the wheel enters it (m), 0 for fresh soil;
    overlap: fraction of the width that runs in a rut, where the path starts at entry_path; on the rest it starts at 0;
    rut_depth: how deep the wheel that made the rut pressed it (m), for laws that know the rut's floor;
    sweep: rate at which the rim of a leaning wheel sweeps sideways through the contact, omega sin(lean) (rad/s): along the
    contact it is as a yaw rate, but nothing scrubs over the width.
    """

    v_x: Scalar
    v_y: Scalar
    omega: Scalar
    load: Scalar
    yaw_rate: Scalar = 0.0
    steer_rate: Scalar = 0.0
    dv_y: Scalar = 0.0
    entry_path: Scalar = 0.0
    overlap: Scalar = 0.0
    rut_depth: Scalar = 0.0
    sweep: Scalar = 0.0


@dataclass(frozen=True)
class WheelForce:
    """What the soil does to the wheel, in the wheel frame.

    f_x, f_y: force (N); m_y: moment of all soil forces about the spin axis, rolling resistance and
    traction (N m, positive turns the wheel forward);
    m_z: aligning moment about the contact centre (N m, left positive); sinkage: maximum sinkage h (m);
    exit_path: shear path that soil runs under this wheel from entry to exit (m), to be carried to the wheel that follows;
    exit_drift: how far the wheel moves sideways over that soil meanwhile (m, >= 0): so wide are the rut's edges, over which
    the path falls to 0; exit_shift: of the rut's middle from the wheel's centre (m, left positive).
    """

    f_x: Scalar
    f_y: Scalar
    m_y: Scalar
    m_z: Scalar
    sinkage: Scalar
    exit_path: Scalar
    exit_drift: Scalar = 0.0
    exit_shift: Scalar = 0.0


class ForceLaw(Protocol):
    """A force law: soil, wheel and contact to forces, in smooth CasADi operations only."""

    @property
    def name(self) -> str:
        """The law's name on the command line and in TOML."""
        ...

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel."""
        ...


def law_names() -> tuple[str, ...]:
    """Names of the modules of `softsoil.symbolic.laws` and the user's own: those that `force_law` knows, alphabetically."""
    return module_names(laws.__path__, LAWS)


def force_law(name: str, **options: Any) -> ForceLaw:
    """The law called `name`; ValueError names the laws there are, and the options of the law for one that it lacks.

    options: of the law's class (TurnSlip in turn_slip.py), e.g. contact_step=0.002 for turn_slip on a simulated soil.
    """
    if name not in law_names():
        raise ValueError(f"force law: expected one of {', '.join(law_names())}; found {name!r}")
    called = name.title().replace("_", "")
    law: Any = made(laws.__name__, name, LAWS, lambda module: getattr(module, called, None))
    usable = is_dataclass(law) and hasattr(law, "name")
    if not usable:
        found = "none" if law is None else "one that is no dataclass, or without a name"
        raise ValueError(f"force law {name}: expected a dataclass {called} with a `name` in {name}.py, found {found}")
    known = [field.name for field in fields(law)]
    for option in options:
        if option not in known:
            raise ValueError(f"force law {name}: expected options {', '.join(known)}; found {option!r}")
    return law(**options)


def simulated(law: Any, options: Mapping[str, float], given: bool = False) -> Any:
    """The law with those of the options that it, or the law it is built on (`base`), has; a law that is no dataclass has none.

    given: whether an option that the law has at another value than its default stays as it was given.
    """
    if not hasattr(law, "__dataclass_fields__"):
        return law
    known = {field.name: field.default for field in fields(law)}
    mine = {k: v for k, v in options.items() if k in known and not (given and getattr(law, k) != known[k])}
    if "base" in known:
        mine["base"] = simulated(law.base, options, given)
    return replace(law, **mine) if mine else law
