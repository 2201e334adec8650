"""The paper's surrogate: the Bekker law with correction factors g_1, g_2, g_3, in two branches.

tau_y = tau_max (1 - exp(-|j_y|/g_3)) g_1 and j_y = -|r (1 - s)(theta_f - theta) tan(beta)| + sign(beta) r sin(theta)
Delta-delta g_2, per branch (paper, eqs. (19), (21), (22) and appendix). What the print leaves open or has wrong:
- Delta-delta is the change of the steering angle over the plant's step of 2 ms: the steering rate times 2 ms;
- the rule of the branches is not given: steering away from zero slip makes the smaller force (lower curve). They do not
  meet as the steering rate goes to 0, so they are blended over the product of steering rate and slip angle;
- g_3n = -0.22 (upper) would be a negative modulus, with forces up to -21 kN: its magnitude is used;
- j/k_y of eq. (18) is j_y/k_y e^(1 - j_y/k_y), a formulation for other soils which is not used;
- the appendix stands for clay, 0 <= s < 0.16 and one unnamed tire: outside, s stays at the end of its range. Table 4
  says n up to 1.3, but g_1n (lower) grows from 1.3 at n = 1 to 12.5 there: n stays at 1 beyond it.
- the surrogate's force "acts on the vehicle frame": it is taken as the force across the wheel's course, and turned into
  the wheel frame with the longitudinal force.
Sinkage, longitudinal force and moments are those of the Bekker law.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import casadi as ca

from softsoil.symbolic.laws.bekker import Arc, Bekker, Rolling, pressure, rolling
from softsoil.symbolic.smooth import Scalar, smooth_positive
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.wheel import Contact, Wheel, WheelForce

PLANT_STEP = 0.002
"""s: the step over which the paper's Delta-delta is taken."""
LEAST_MODULUS = 1e-3
"""m: least k_y, reached smoothly."""


@dataclass(frozen=True)
class Factor:
    """One g: product of a polynomial in n, one in s (highest power first), one linear in F_z and a power of v.

    n_positive: the polynomial in n is cut at zero (max(., 0) in the paper), smoothly.
    """

    n: Sequence[Scalar] = (1.0,)
    s: Sequence[Scalar] = (1.0,)
    load: Sequence[Scalar] = (1.0,)
    speed: tuple[float, float] = (1.0, 0.0)
    n_positive: bool = False

    def __call__(self, n: Scalar, s: Scalar, load: Scalar, log_v: Scalar) -> Scalar:
        """Value at n, s, F_z (N) and log v (v in m/s)."""
        of_n = _polynomial(self.n, n)
        if self.n_positive:
            of_n = smooth_positive(of_n, 0.02)
        value = of_n * _polynomial(self.s, s) * _polynomial(self.load, load) * self.speed[0]
        return value * ca.exp(self.speed[1] * log_v) if self.speed[1] else value


@dataclass(frozen=True)
class Branch:
    """g_1, g_2 and g_3 of one curve."""

    g_1: Factor
    g_2: Factor
    g_3: Factor


@dataclass(frozen=True)
class SlipRange:
    """Both curves over one range of longitudinal slip."""

    low: float
    high: float
    lower: Branch
    upper: Branch


_G2 = Factor(
    n=(1.8, -1.08),
    n_positive=True,
    s=(1.367e6, -3.71e5, 2.809e4, -545.7, 70.0),
    load=(0.0001, 0.7),
    speed=(4.908, -0.9295),
)
_G3_LOAD = (8.3e-5, 0.76)
APPENDIX = SlipRange(
    0.0,
    0.16,
    lower=Branch(
        Factor(n=(128.3, -415.4, 523.3, -320.0, 95.07, -9.942), s=(563.5, -107.9, -4.848, 1.761, 1.024)),
        _G2,
        Factor(n=(-0.1235, 0.7287, 0.08425), s=(-309.5, 90.48, -8.983, 0.2631, 0.086), load=_G3_LOAD),
    ),
    upper=Branch(
        Factor(n=(1.16,), s=(1913.0, -520.6, 49.57, -1.204, 1.024)),
        _G2,
        Factor(n=(0.22,), s=(1609.0, -529.0, 58.88, -2.467, 0.082), load=_G3_LOAD),
    ),
)
"""The appendix: clay, 0 <= s < 0.16."""


@dataclass(frozen=True)
class Dallas:
    """The paper's surrogate for one soil.

    ranges: correction factors by slip range, in increasing order; base: the Bekker law corrected;
    blend: rad^2/s, product of steering rate and slip angle at which 85 % of the way to a branch is gone;
    range_width: width in s over which neighbouring slip ranges are blended; n_range: where the factors are held.
    """

    ranges: Sequence[SlipRange] = (APPENDIX,)
    base: Bekker = field(default_factory=Bekker)
    blend: float = 0.005
    range_width: float = 0.01
    n_range: tuple[float, float] = (0.4, 1.0)

    @property
    def name(self) -> str:
        """dallas."""
        return "dallas"

    def __call__(self, soil: Soil, wheel: Wheel, contact: Contact) -> WheelForce:
        """Forces on one wheel; see the module for the equations and softsoil.symbolic.wheel for conventions."""
        base = self.base
        roll = rolling(contact, wheel.radius, base.speed_floor, base.spin_floor)
        arc = base.sink(soil, wheel, contact, roll)
        v = ca.sqrt(contact.v_x**2 + contact.v_y**2 + base.speed_floor**2)
        side = -contact.v_y / ca.sqrt(contact.v_y**2 + (base.slip_floor * v) ** 2)
        f_y: Scalar = 0.0
        m_z: Scalar = 0.0
        upper = 0.5 - 0.5 * _sigmoid(-contact.steer_rate * contact.v_y / v / self.blend)
        for piece, share in zip(self.ranges, self._shares(roll.slip), strict=True):
            for branch, weight in ((piece.lower, share * (1.0 - upper)), (piece.upper, share * upper)):
                force, moment = self._side(soil, wheel, contact, roll, arc, side, v, piece, branch)
                f_y, m_z = f_y + weight * force, m_z + weight * moment
        along = base.forces(soil, wheel, contact, roll, arc)
        cos, sin = ca.sqrt(contact.v_x**2 + base.speed_floor**2) / v, -contact.v_y / v
        return replace(along, f_y=(f_y - along.f_x * sin) / cos, m_z=m_z)

    def _shares(self, s: Scalar) -> list[Scalar]:
        """Weights of the slip ranges, summing to one."""
        steps = [0.5 + 0.5 * _sigmoid((s - piece.low) / self.range_width) for piece in self.ranges[1:]]
        return [a - b for a, b in zip([1.0, *steps], [*steps, 0.0], strict=True)]

    def _side(
        self, soil: Soil, wheel: Wheel, contact: Contact, roll: Rolling, arc: Arc, side: Scalar, v: Scalar, piece: SlipRange,
        branch: Branch,
    ) -> tuple[Scalar, Scalar]:  # fmt: skip
        """F_y (N) and M_z (N m) of one curve, equations (17), (19), (21) and (22)."""
        r = wheel.radius
        n = _held(soil.n, *self.n_range, 0.02)
        state = (n, _held(roll.slip, piece.low, piece.high, self.range_width), contact.load, ca.log(v))
        g_1, g_2 = branch.g_1(*state), branch.g_2(*state)
        g_3 = LEAST_MODULUS + smooth_positive(branch.g_3(*state) - LEAST_MODULUS, LEAST_MODULUS)
        turn = side * contact.steer_rate * PLANT_STEP * g_2

        def shear(theta: Scalar, ahead: bool) -> Scalar:
            run = r * roll.aside * (arc.front - theta)
            slipped = ca.sqrt(run * run + 1e-12)
            path = -slipped + r * ca.sin(theta) * turn
            limit = soil.c + pressure(soil, wheel, arc, theta, ahead) * ca.tan(soil.phi)
            return limit * (1.0 - ca.exp(-ca.sqrt(path * path + 1e-12) / g_3))

        plain, _, with_sin = arc.integrals(shear)
        scale = wheel.width * r * g_1 * side
        return scale * plain, scale * r * with_sin


def _polynomial(coefficients: Sequence[Scalar], at: Scalar) -> Scalar:
    """Horner's rule, highest power first."""
    value: Scalar = coefficients[0]
    for coefficient in coefficients[1:]:
        value = value * at + coefficient
    return value


def _sigmoid(x: Scalar) -> Scalar:
    """x/sqrt(1 + x^2), from -1 to 1."""
    return x / ca.sqrt(1.0 + x * x)


def _held(value: Scalar, low: float, high: float, width: float) -> Scalar:
    """`value` between low and high, held smoothly at the nearer end outside."""
    above = low + smooth_positive(value - low, width)
    return high - smooth_positive(high - above, width)
