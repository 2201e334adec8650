"""The optimal control problem of path tracking on soft soil, from the same Model that the estimator uses.

States z = (model states, steer), inputs w = (steer_rate, a_x). The soil, every effect and the wheel slip are run-time
parameters s = (model parameters, slip, slip_gain); what the model's histories provide (ruts, body roll) comes as stage
parameters r, rolled forward along the previous solution. Each piece is a CasADi SX function, so that the real-time
solver, IPOPT, do-mpc, acados and generated C all solve one and the same problem:

  min sum_k dt l(z_k, w_k, ref_k) + terminal dt l(z_N, 0, ref_N) + rho_1 slack + rho_2/2 slack^2
  z_{k+1} = RK4(f; z_k, w_k, r_k, s),  z_0 given
  steer_rate, a_x in their limits; soft: steer, u in theirs, clearance of obstacles >= 0, lateral-force reserve.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from softsoil.declaration.handed import check_model
from softsoil.symbolic.model import Model, Quantities
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.smooth import smooth_norm
from softsoil.symbolic.vehicle import Vehicle

CIRCLES = 3
"""Circles that stand for the vehicle where obstacles are."""
WHEELS = (("fl", 1, 1), ("fr", 1, -1), ("rl", 0, 1), ("rr", 0, -1))
"""Name, front (1) or rear (0), side."""
CRAWL = 0.2
"""m/s: at a slower speed of the path the direction of a motion gives way to the heading."""


@dataclass(frozen=True)
class Weights:
    """Of squared errors, per second: across and along (1/m^2) the path, course (1/rad^2), the direction in which the front axle
    moves against the path's, speed (s^2/m^2), yaw-rate (s^2/rad^2), steering rate (s^2/rad^2), acceleration (s^4/m^2);
    terminal: times of a step that the last state counts; slack, slack_squared: of soft limits per unit violated. Raises
    ValueError for a negative one.
    """

    across: float = 1.0
    along: float = 0.02
    course: float = 2.0
    speed: float = 0.3
    yaw_rate: float = 0.0
    steer_rate: float = 0.3
    a_x: float = 0.1
    terminal: float = 5.0
    slack: float = 20.0
    slack_squared: float = 50.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value >= 0:
                raise ValueError(f"weights: expected {name} >= 0, found {value}")


@dataclass(frozen=True)
class OcpSettings:
    """Horizon, limits and weights.

    steps: N; dt: s; a_x: least and greatest acceleration (m/s^2); speed: least and greatest u (m/s); obstacles: how many
    are watched; room: kept around the vehicle's half width (m), margin: how much of it a
    plan may use up where it must (m): one that needs more is taken to touch the obstacle; reserve: share of the soil's lateral
    force that is kept (softly); slip: of the wheels at constant speed; slip_gain: its growth with a_x (s^2/m); both are
    only the nominal values of run-time parameters. Raises ValueError for an empty range or a step <= 0.
    """

    steps: int = 40
    dt: float = 0.0625
    a_x: tuple[float, float] = (-3.0, 1.5)
    speed: tuple[float, float] = (0.5, 12.0)
    obstacles: int = 2
    room: float = 0.33
    margin: float = 0.2
    reserve: float = 0.02
    slip: float = 0.04
    slip_gain: float = 0.02
    weights: Weights = field(default_factory=Weights)

    def __post_init__(self) -> None:
        if self.steps < 2 or not self.dt > 0:
            raise ValueError(f"ocp: expected steps >= 2 and dt > 0 s, found {self.steps} and {self.dt}")
        if self.obstacles < 0 or not 0 <= self.reserve < 1:
            raise ValueError(
                f"ocp: expected obstacles >= 0 and reserve in [0, 1), found {self.obstacles}, {self.reserve}"
            )
        if not 0 <= self.margin <= self.room:
            raise ValueError(f"ocp: expected margin in [0, room], found {self.margin} and a room of {self.room} m")
        for name in ("a_x", "speed"):
            low, high = getattr(self, name)
            if not low < high:
                raise ValueError(f"ocp: expected {name} as (least, greatest), found {getattr(self, name)}")


REFERENCE = Layout.of(
    Signal("x", "m", "path"), Signal("y", "m", "path"), Signal("psi", "rad", "course"), Signal("u", "m/s", "speed", 5.0)
)
OBSTACLE = Layout.of(Signal("x", "m", "centre"), Signal("y", "m", "centre"), Signal("radius", "m", "radius"))


class Ocp:
    """The pieces of the problem.

    model: bicycle with its effects; vehicle: the same as the model's (limits, wheel geometry); settings.
    z, w, r, s: layouts of states, inputs, stage parameters and shared parameters. Raises TypeError for what is no model.

    Example:
        >>> import softsoil
        >>> vehicle = softsoil.load_vehicle("reference")
        >>> ocp = softsoil.Ocp(softsoil.bicycle(vehicle, softsoil.load_soil("clay")), vehicle)
        >>> ocp.w.names
        ('steer_rate', 'a_x')
    """

    def __init__(self, model: Model, vehicle: Vehicle, settings: OcpSettings | None = None) -> None:
        check_model("Ocp", model)
        self.model, self.vehicle, self.settings = model, vehicle, settings or OcpSettings()
        low, high = self.settings.speed
        acceleration = self.settings.a_x
        lock, rate = vehicle.max_steer, vehicle.max_steer_rate
        self.z = Layout(model.x.signals + (Signal("steer", "rad", "steering angle", 0.0, -lock, lock),))
        self.w = Layout.of(
            Signal("steer_rate", "rad/s", "rate of the steering angle", 0.0, -rate, rate),
            Signal("a_x", "m/s^2", "rate of u", 0.0, *acceleration),
        )
        self.r = Layout(model.u.signals[len(model.external) :])
        self.s = model.p + Layout.of(
            Signal("slip", "", "wheel slip at constant speed", self.settings.slip, -0.5, 0.9),
            Signal("slip_gain", "s^2/m", "growth of wheel slip with a_x", self.settings.slip_gain, 0.0, 0.3),
        )
        self.state_box = {"steer": (-lock, lock), "u": (low, high)}
        """Soft limits of states by name."""

    @property
    def body(self) -> float:
        """Radius of the circles along the vehicle that must stay clear (m): half its width and the room around it."""
        return half_width(self.vehicle) + self.settings.room

    @property
    def bears(self) -> bool:
        """Whether the model has wheels on soil, so that a lateral-force reserve can be kept."""
        x, u, p = self.model.symbols()
        return "wheels" in self.model.quantities(x, u, p)

    def external(self, z: ca.SX, w: ca.SX, s: ca.SX) -> ca.SX:
        """(n_external,) inputs of the model, its wheel speeds following from the motion: with a locked centre differential
        the axles' rims turn alike, r omega = (v_xf + v_xr)/(2 (1 - slip)), and each wheel by its own way more or less.
        """
        v = self.vehicle
        u, v_y, omega_z, steer = (z[self.z.index(name)] for name in ("u", "v", "omega_z", "steer"))
        slip = s[self.s.index("slip")] + s[self.s.index("slip_gain")] * w[1]
        scale = {radius: 1.0 / (radius * (1.0 - slip)) for radius in (v.radius, v.rear_radius)}
        cos, sin = ca.cos(steer), ca.sin(steer)
        front = u * cos + (v_y + v.l_f * omega_z) * sin
        values: dict[str, Any] = {"steer": steer, "steer_rate": w[0], "a_x": w[1]}
        for name, is_front, side in WHEELS:
            turn = -side * (v.track if is_front else v.rear_track) / 2 * omega_z * (cos if is_front else 1.0)
            values[f"omega_{name}"] = scale[v.radius if is_front else v.rear_radius] * (0.5 * (front + u) + turn)
        return ca.vertcat(*[values.get(signal.name, signal.nominal) for signal in self.model.external])

    def dynamics(self) -> ca.Function:
        """[z, w, r, s] -> [rate of z, (2,) lateral force of each axle over what the soil bears: c b x_f + F_z tan phi]."""
        z, w, r, s = self.symbols()
        x, p = z[: len(self.model.x)], s[: len(self.model.p)]
        q = self.model.quantities(x, ca.vertcat(self.external(z, w, s), r), p)
        rates = ca.vertcat(*[q[f"d_{name}"] for name in self.model.x.names], w[0])
        use = ca.SX.zeros(2)
        if self.bears:
            use = ca.vertcat(*[q[f"force_{axle}"] / _bearing(q, axle) for axle in ("f", "r")])
        return ca.Function(
            "dynamics", [z, w, r, s], [ca.densify(rates), ca.densify(use)], ["z", "w", "r", "s"], ["d", "use"]
        )

    def step(self) -> ca.Function:
        """[z, w, r, s] -> [z one dt later]: one classical Runge-Kutta step."""
        f, h = self.dynamics(), self.settings.dt
        z, w, r, s = self.symbols()
        k1 = f(z, w, r, s)[0]
        k2 = f(z + h / 2 * k1, w, r, s)[0]
        k3 = f(z + h / 2 * k2, w, r, s)[0]
        k4 = f(z + h * k3, w, r, s)[0]
        return ca.Function(
            "step", [z, w, r, s], [z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)], ["z", "w", "r", "s"], ["z_next"]
        )

    def cost(self) -> ca.Function:
        """[z, w, ref] -> [l]: weighted squared errors, per second.

        The front axle keeps to the path where it moves along it: psi + (v + l_f omega_z)/u is the path's course, and the heading
        stands inside the curve by about the wheelbase over its radius. u is the path's, which keeps the cost quadratic.
        """
        z, w, _, _ = self.symbols()
        ref = ca.SX.sym("ref", len(REFERENCE))
        weights = self.settings.weights
        dx, dy, psi, u = (z[self.z.index(name)] - ref[i] for i, name in enumerate(REFERENCE.names))
        v_y, omega_z = (z[self.z.index(name)] for name in ("v", "omega_z"))
        course = psi + (v_y + self.vehicle.l_f * omega_z) / smooth_norm(ref[3], 0.0, CRAWL)
        cos, sin = ca.cos(ref[2]), ca.sin(ref[2])
        terms = (
            (weights.along, cos * dx + sin * dy),
            (weights.across, cos * dy - sin * dx),
            (weights.course, course),
            (weights.speed, u),
            (weights.yaw_rate, omega_z),
            (weights.steer_rate, w[0]),
            (weights.a_x, w[1]),
        )
        total = sum(0.5 * weight * error**2 for weight, error in terms)
        return ca.Function("cost", [z, w, ref], [total], ["z", "w", "ref"], ["l"])

    def clearance(self) -> ca.Function:
        """[z, obstacle] -> [(CIRCLES,) gaps between the obstacle and the circles from the front axle to the rear one, m]."""
        z, _, _, _ = self.symbols()
        obstacle = ca.SX.sym("obstacle", len(OBSTACLE))
        x, y, psi = (z[self.z.index(name)] for name in ("x", "y", "psi"))
        gaps = []
        for back in (i * self.vehicle.wheelbase / (CIRCLES - 1) for i in range(CIRCLES)):
            dx, dy = x - back * ca.cos(psi) - obstacle[0], y - back * ca.sin(psi) - obstacle[1]
            gaps.append(smooth_norm(dx, dy, 0.05) - obstacle[2] - self.body)
        return ca.Function("clearance", [z, obstacle], [ca.vertcat(*gaps)], ["z", "obstacle"], ["gap"])

    def symbols(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """Fresh symbols (z, w, r, s)."""
        return (
            ca.SX.sym("z", len(self.z)), ca.SX.sym("w", len(self.w)), ca.SX.sym("r", len(self.r)),
            ca.SX.sym("s", len(self.s)),
        )  # fmt: skip


def half_width(vehicle: Vehicle) -> float:
    """Half the width of a vehicle over its wheels (m)."""
    return 0.5 * max(vehicle.track + vehicle.width, vehicle.rear_track + vehicle.rear_width)


def _bearing(q: Quantities, axle: str) -> Any:
    """Greatest lateral force of an axle (N), Mohr-Coulomb over the contact line: sum of c b x_f + F_z tan phi."""
    total: Any = 0.0
    for corner in q["wheels"]:
        if corner.axle == axle:
            h, r = corner.force.sinkage, q["radius"]
            length = ca.sqrt(h * (2.0 * r - h))
            total = total + corner.count * (q["c"] * q["width"] * length + corner.load * ca.tan(q["phi"]))
    return total
