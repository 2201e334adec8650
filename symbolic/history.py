"""What follows late, from a history kept beside the states: dead times and first-order lags."""

from collections.abc import Sequence

import casadi as ca

from softsoil.symbolic.model import Compute, Memory, Quantities, Scalar
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.track import interpolate, push, read_cells, track_layout, write_cells


def lag_share(dt: Scalar, time: Scalar) -> Scalar:
    """Share of the way that a first-order lag of the given time constant (s) goes in a step dt (s), its target held."""
    return 1.0 - ca.exp(-dt / time)


def late_by(
    delay: str, prefix: str, values: Sequence[Signal], present: Compute, still: Compute, cells: int, spacing: float
) -> Memory:
    """A memory that provides <prefix>_<value>: the value `delay` seconds ago less the present one, linear between cells.

    delay: name of the parameter (s), reaching cells * spacing back; prefix: of all names; values: what is remembered;
    present: their values now; still: those of a history in which nothing moved; cells, spacing (s): of the history.
    """
    remembered = (Signal("age", "s", "age"), *values)
    layout = Layout.of(Signal(f"{prefix}_step", "s", "last time step")) + track_layout(prefix, cells, remembered)
    provides = Layout(tuple(Signal(f"{prefix}_{s.name}", s.unit, f"{s.doc}, late less present") for s in values))

    def past(q: Quantities) -> list[Quantities]:
        old = read_cells(q["memory"], prefix, cells, remembered)
        aged = ({**cell, "age": cell["age"] + q["memory"][f"{prefix}_step"]} for cell in old)
        return [{"age": 0.0, **present(q)}, *aged]

    def read(q: Quantities) -> Quantities:
        at = past(q)
        return {f"{prefix}_{s.name}": interpolate(at, "age", q[delay], s.name) - at[0][s.name] for s in values}

    def advance(q: Quantities) -> Quantities:
        now, *old = past(q)
        return {f"{prefix}_step": q["dt"], **write_cells(push(old, now, "age", spacing), prefix)}

    def start(q: Quantities) -> Quantities:
        steady = [{"age": spacing * k, **still(q)} for k in range(cells)]
        return {f"{prefix}_step": 0.0, **write_cells(steady, prefix)}

    return Memory(prefix, layout, provides, read, advance, start)
