"""Resistance to motion that the commanded acceleration does not contain."""

from softsoil.symbolic.effect import GRAVITY, Correction, Effect, Layout, Signal, Vehicle


def effect(vehicle: Vehicle) -> Effect:
    """du/dt -= f g: only where a_x is commanded, not where it is measured."""
    return Effect(
        name="motion_resistance",
        doc="resistance to motion that the commanded acceleration does not contain",
        kind="load",
        reference="rolling resistance coefficient",
        parameters=Layout.of(Signal("motion_resistance", "", "resistance over weight", 0.0, -0.3, 0.3, spread=0.2)),
        typical={"motion_resistance": 0.03},
        corrections={
            "inputs": Correction(lambda q: {"gravity_x": q["gravity_x"] - GRAVITY * q["motion_resistance"]}, adds=("gravity_x",))
        },
        signatures=("resistance",),
        separates="driving on opposite headings",
        rests_on=("u", "a_x_imu"),
    )
