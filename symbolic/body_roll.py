"""The lateral specific force as a suspended body has followed it: what rolls it, a moment late."""

from __future__ import annotations

from symbolic.history import lag_share
from symbolic.model import Memory, Quantities
from symbolic.signals import Layout, Signal


def body_roll(effect: str, cell: str, provided: str, time: float) -> Memory:
    """Memory of an effect: the lateral specific force (m/s^2) through a first-order lag of `time` (s), and its rate (m/s^3).

    cell, provided: names under which it is kept and read; each with `_rate` for the rate.
    """

    def layout(name: str) -> Layout:
        return Layout.of(
            Signal(name, "m/s^2", "lateral specific force that the rolled body has followed"),
            Signal(f"{name}_rate", "m/s^3", "its rate"),
        )

    def read(q: Quantities) -> Quantities:
        return {provided: q["memory"][cell], f"{provided}_rate": q["memory"][f"{cell}_rate"]}

    def advance(q: Quantities) -> Quantities:
        before = q["memory"][cell]
        moved = lag_share(q["dt"], time) * (q["force_y"] / q["mass"] - before)
        return {cell: before + moved, f"{cell}_rate": moved / q["dt"]}

    def start(q: Quantities) -> Quantities:
        return {cell: q["u"] * q["omega_z"], f"{cell}_rate": 0.0}

    return Memory(effect, layout(cell), layout(provided), read=read, advance=advance, start=start)
