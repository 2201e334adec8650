"""Effects of the soil and of the tyre on it."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from softsoil.symbolic.bicycle import Corner
from softsoil.symbolic.effect import Effect, each_wheel
from softsoil.symbolic.model import Quantities
from softsoil.symbolic.side_wall import Wall, side_wall
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.smooth import smooth_norm, smooth_positive

CHANGE_WIDTH = 0.3
"""m over which a soil changes into another."""


def rate_damping() -> Effect:
    """sigma += R omega X: another damping of the sinkage rate than the declared soil has."""

    def compute(q: Quantities, corner: Corner) -> Corner:
        soil = corner.soil
        return corner.with_(soil=replace(soil, R=smooth_positive(soil.R + q["damping_change"], 1.0)))  # type: ignore

    return Effect(
        name="rate_damping",
        doc="soil that resists fast sinking by another amount than declared",
        reference="soil contact model: sigma -= R V_n",
        parameters=Layout.of(
            Signal("damping_change", "Pa s/m", "damping beyond the declared", 0.0, -3e4, 1e5, spread=3e4)
        ),
        typical={"damping_change": -5e3},
        corrections={"contacts": each_wheel(compute)},
        confusable=("steering_gain", "payload"),
        separates="the same manoeuvre at several speeds",
    )


def bulldozing() -> Effect:
    """Passive earth pressure on each wheel's side wall, `side_wall`: the law that the single-wheel tests in sand gave."""

    def compute(q: Quantities, corner: Corner) -> Corner:
        force = corner.force
        wall = Wall(q["soil_density"])
        aside = side_wall(wall, corner.soil, q["radius"], corner.contact, force.sinkage)  # type: ignore
        return corner.with_(force=replace(force, f_y=force.f_y + aside))  # type: ignore

    return Effect(
        name="bulldozing",
        doc="soil pushed aside by the wheel's side wall",
        reference="Hegedus; Ishigami 2007; passive earth pressure after Lancellotta 2002",
        parameters=Layout.of(Signal("soil_density", "N/m^3", "unit weight of the soil", 0.0, 0.0, 25e3, spread=2e4)),
        typical={"soil_density": 8e3},
        corrections={"forces": each_wheel(compute)},
        confusable=("steering_gain",),
        separates="slow driving at large slip angles",
    )


def slip_sinkage() -> Effect:
    """A slipping wheel digs: the same pressure at h (1 + f |s|), hence k_eq/(1 + f |s|)^n."""

    def compute(q: Quantities, corner: Corner) -> Corner:
        contact, soil = corner.contact, corner.soil
        rolling = q["radius"] * contact.omega  # type: ignore[union-attr]
        v_x = contact.v_x  # type: ignore[union-attr]
        slip = ca.sqrt((rolling - v_x) ** 2 + 1e-4) / smooth_norm(v_x, rolling, 0.1)
        soften = ca.exp(-soil.n * ca.log(1.0 + q["slip_sinkage"] * slip))  # type: ignore[union-attr]
        return corner.with_(soil=replace(soil, k_phi=soil.k_phi * soften, k_c=soil.k_c * soften))  # type: ignore

    return Effect(
        name="slip_sinkage",
        doc="a wheel that slips digs itself in",
        reference="Vasilev; Lyasko 2010: h (1 + s)/(1 - s/2) and like laws",
        parameters=Layout.of(Signal("slip_sinkage", "", "sinkage per unit slip", 0.0, 0.0, 10.0, spread=2)),
        typical={"slip_sinkage": 1.0},
        corrections={"contacts": each_wheel(compute)},
        confusable=("rate_damping",),
        separates="strong throttle at a constant speed",
    )


def soil_change() -> Effect:
    """Another n beyond a line on the ground: n + n_change where a wheel has passed (change_x, change_y) along change_heading."""

    def compute(q: Quantities, corner: Corner) -> Corner:
        behind = 0.0 if corner.axle == "f" else q["l_f"] + q["l_r"]
        x, y = q["x"] - behind * ca.cos(q["psi"]), q["y"] - behind * ca.sin(q["psi"])
        past = (x - q["change_x"]) * ca.cos(q["change_heading"]) + (y - q["change_y"]) * ca.sin(q["change_heading"])
        share = 0.5 * (1.0 + past / ca.sqrt(past * past + CHANGE_WIDTH**2))
        n = corner.soil.n + q["n_change"] * share  # type: ignore[union-attr]
        return corner.with_(soil=replace(corner.soil, n=ca.fmax(0.2, ca.fmin(1.6, n))))  # type: ignore[type-var]

    far = 1e6
    return Effect(
        name="soil_change",
        doc="the soil changes where the vehicle drives",
        reference="piecewise homogeneous terrain",
        parameters=Layout.of(
            Signal("n_change", "", "change of the sinkage exponent", 0.0, -0.8, 0.8, spread=0.3),
            Signal("change_x", "m", "world x of the change", far, -far, far),
            Signal("change_y", "m", "world y of the change", 0.0, -far, far),
            Signal("change_heading", "rad", "direction across the line of change", 0.0, -100.0, 100.0),
        ),
        typical={"n_change": 0.1, "change_x": 0.0, "change_y": 0.0, "change_heading": 0.0},
        corrections={"contacts": each_wheel(compute)},
        confusable=("rate_damping",),
        separates="driving over the same place twice",
    )


def relaxation() -> Effect:
    """(l/u) dF/dt + F = F_ss on both axles: the force needs a travelled length to build up."""
    states = Layout.of(
        Signal("relaxed_f", "N", "lateral force of the front axle, built up"),
        Signal("relaxed_r", "N", "lateral force of the rear axle, built up"),
    )

    def balance(q: Quantities) -> Quantities:
        # Share of the built-up force: none at length 0, so that the absent effect leaves the forces as they are.
        share = q["relaxation_length"] / (q["relaxation_length"] + 0.01)
        front = q["force_f"] + share * (q["relaxed_f"] - q["force_f"])
        rear = q["force_r"] + share * (q["relaxed_r"] - q["force_r"])
        moment = (front - q["force_f"]) * q["l_f"] - (rear - q["force_r"]) * q["l_r"]
        return {
            "steady_f": q["force_f"],
            "steady_r": q["force_r"],
            "force_f": front,
            "force_r": rear,
            "force_y": q["force_y"] + front + rear - q["force_f"] - q["force_r"],
            "moment_z": q["moment_z"] + moment,
        }

    def rates(q: Quantities) -> Quantities:
        speed = ca.sqrt(q["u"] * q["u"] + 0.01) / (q["relaxation_length"] + 0.15)
        return {f"d_relaxed_{axle}": speed * (q[f"steady_{axle}"] - q[f"relaxed_{axle}"]) for axle in ("f", "r")}

    return Effect(
        name="relaxation",
        doc="tyre force that needs a travelled length to build up",
        reference="first-order tyre relaxation (Pacejka)",
        parameters=Layout.of(
            Signal("relaxation_length", "m", "relaxation length beyond 0.15 m", 0.0, 0.0, 2.0, spread=0.7)
        ),
        typical={"relaxation_length": 0.2},
        corrections={"balance": balance},
        states=states,
        rates=rates,
        confusable=("steering_lag", "steering_delay"),
        separates="the same steering at several speeds: this lag goes with 1/u and is there at the rear too",
    )
