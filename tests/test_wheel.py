"""Properties of every force law: finite, smooth, mirror-symmetric; and of turn_slip: passive, bounded, carries its load."""

import casadi as ca
import numpy as np
import pytest

from symbolic.contact_line import contact_line, tan_phi
from symbolic.domain import check_contact, check_sinkage
from symbolic.soil import CLAY, SANDY_LOAM, SOILS, Soil
from symbolic.turn_slip import TurnSlip
from symbolic.wheel import Contact, Wheel, force_law, law_names

WHEEL = Wheel(0.330229, 0.2121)
MOTION = ("v_x", "v_y", "omega", "load", "yaw_rate", "steer_rate", "dv_y", "entry_path", "overlap")
SOIL = ("k_phi", "k_c", "n", "c", "phi", "k")
LATERAL = [1, 4, 5, 6]
OUT = ("f_x", "f_y", "m_y", "m_z", "sinkage", "exit_path")


def function(law, name="clay", wheel=WHEEL):
    motion, soil = ca.SX.sym("motion", len(MOTION)), ca.SX.sym("soil", len(SOIL))
    force = law(
        Soil(name, *[soil[i] for i in range(len(SOIL))]),
        wheel,
        Contact(**{key: motion[i] for i, key in enumerate(MOTION)}),
    )
    out = ca.vertcat(*[getattr(force, key) for key in OUT])
    x = ca.vertcat(motion, soil)
    return ca.Function("force", [x], [out]), ca.Function("slope", [x], [ca.jacobian(out, x)])


def point(soil=CLAY, **changes):
    values = {"v_x": 5.0, "v_y": 0.0, "omega": 15.5, "load": 3000.0, **changes}
    motion = [values.get(key, 0.0) for key in MOTION]
    return np.array(motion + [float(values.get(key, getattr(soil, key))) for key in SOIL])


def box(count, seed=0):
    """Random points over the paper's Table 4, steering and ruts included, braked and driven."""
    rng = np.random.default_rng(seed)
    soils = list(SOILS.values())
    points = []
    for _ in range(count):
        v, angle, slip = rng.uniform(0.5, 10), rng.uniform(-0.5, 0.5), rng.uniform(-0.9, 0.9)
        v_x = v * np.cos(angle)
        omega = v_x / WHEEL.radius * (1 + slip if slip < 0 else 1 / (1 - slip))
        points.append(
            point(
                soils[rng.integers(3)], v_x=v_x, v_y=-v * np.sin(angle), omega=omega, load=rng.uniform(500, 6000),
                yaw_rate=rng.uniform(-2, 2), steer_rate=rng.uniform(-2, 2), dv_y=rng.uniform(-10, 10),
                entry_path=rng.uniform(0, 0.05), overlap=rng.uniform(0, 1), n=rng.uniform(0.4, 1.3),
            )
        )  # fmt: skip
    return np.array(points).T


@pytest.fixture(scope="module", params=law_names())
def law(request):
    return function(force_law(request.param))


@pytest.fixture(scope="module")
def turn_slip():
    return function(TurnSlip())


ODD_PLACES = [
    {},
    {"v_x": 0.0, "omega": 0.0},
    {"v_x": 0.0},
    {"omega": 0.0},
    {"v_y": -1.0},
    {"load": 0.0},
    {"load": -500.0},
    {"load": 20000.0, "n": 1.3},
    {"v_x": 0.01, "omega": 0.0, "yaw_rate": 2.0},
    {"k_c": 0.0, "c": 0.0, "phi": 0.0},
    {"overlap": 1.0, "entry_path": 0.3},
]


@pytest.mark.parametrize("place", ODD_PLACES, ids=str)
def test_finite_with_finite_derivatives(law, place):
    value, slope = law
    assert np.all(np.isfinite(np.array(value(point(**place)))))
    assert np.all(np.isfinite(np.array(slope(point(**place)))))


def test_mirror_symmetry(law):
    value, _ = law
    x = box(40)
    mirrored = x.copy()
    mirrored[LATERAL] *= -1
    sign = np.array([1, -1, 1, -1, 1, 1])[:, None]
    assert np.allclose(np.array(value(x)), sign * np.array(value(mirrored)), rtol=1e-9, atol=1e-7)


def test_derivatives_against_finite_differences(turn_slip):
    value, slope = turn_slip
    for x in box(15, seed=3).T:
        steps = 1e-6 * np.maximum(np.abs(x), 0.1)
        exact = np.array(slope(x))
        for i, step in enumerate(steps):
            up, down = x.copy(), x.copy()
            up[i] += step
            down[i] -= step
            numeric = (np.array(value(up)) - np.array(value(down))).ravel() / (2 * step)
            # Central differences are good to about 1e-5 of the largest change here.
            assert np.allclose(exact[:, i], numeric, rtol=1e-3, atol=1e-5 * (1 + np.abs(exact).max()))


def test_soil_never_gives_the_wheel_energy(turn_slip):
    """f . v + m_y omega + m_z yaw_rate is the power that the soil gives to the wheel."""
    x = box(400, seed=1)
    f_x, f_y, m_y, m_z, *_ = np.array(turn_slip[0](x))
    power = f_x * x[0] + f_y * x[1] + m_y * x[2] + m_z * x[4]
    assert power.max() <= 0.0


def test_mohr_coulomb_bounds_the_force(turn_slip):
    x = box(400, seed=2)
    f_x, f_y, _, _, h, _ = np.array(turn_slip[0](x))
    r = WHEEL.radius
    longest = np.sqrt(h * (2 * r - h)) + 0.15 * r  # the tail is shorter than that
    bound = x[3] * np.tan(x[len(MOTION) + 4]) + x[len(MOTION) + 3] * WHEEL.width * longest
    assert np.all(np.hypot(f_x, f_y) <= bound)


def test_force_and_sinkage_grow_with_load(turn_slip):
    loads = np.linspace(200, 8000, 60)
    for soil in SOILS.values():
        x = np.array([point(soil, load=load, v_y=-0.7) for load in loads]).T
        _, f_y, _, _, h, _ = np.array(turn_slip[0](x))
        assert np.all(np.diff(f_y) > 0)
        assert np.all(np.diff(h) > 0)


def test_continuous_across_zero_slip(law):
    value, _ = law
    rolling = 5.0 / WHEEL.radius
    spins = rolling * (1 + np.linspace(-1e-5, 1e-5, 11))
    forces = np.array(value(np.array([point(omega=w, v_y=-0.5) for w in spins]).T))
    assert np.all(np.abs(np.diff(forces[:2])) < 1.0)


def test_opposes_slip_and_vanishes_straight_ahead(law):
    value, _ = law
    assert float(value(point(v_y=-0.5))[1]) > 100
    assert abs(float(value(point())[1])) < 1e-6


def test_the_line_carries_its_load():
    for soil in (CLAY, SANDY_LOAM.with_(n=1.2)):
        for load in (500.0, 3000.0, 6000.0):
            line = contact_line(soil, WHEEL, load, 20.0, 5)
            total = sum(float(node.weight * node.sigma) for node in line.nodes) * WHEEL.width
            assert total == pytest.approx(load, rel=1e-6)


def test_sinkage_against_bisection():
    """The one Newton step against the load integral solved to the last digit."""
    r, b = WHEEL.radius, WHEEL.width
    worst = 0.0
    for soil in (CLAY, CLAY.with_(n=1.2), SANDY_LOAM):
        stiffness = soil.k_phi + soil.k_c * (1 / b + 1 / (1.6 * r))

        def load(h, omega, soil=soil, stiffness=stiffness):
            xi = (np.arange(4000) + 0.5) / 4000
            x_f = np.sqrt(h * (2 * r - h))
            x, dx = x_f * (1 - xi**2), 2 * x_f * xi / 4000
            depth = np.maximum(np.sqrt(r * r - x * x) - (r - h), 0)
            sigma = stiffness * h**soil.n
            x_r = np.sqrt(2 * r * sigma / soil.K)
            tail = (2 / 3 * sigma) ** 2 / (2 / 3 * sigma + 0.5 * soil.R * omega * x_r)
            return b * (np.sum((stiffness * depth**soil.n + soil.R * omega * x) * dx) + tail * x_r)

        for target in (1000.0, 4000.0):
            low, high = 1e-5, 0.25
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if load(middle, 15.0) < target else (low, middle)
            h = float(contact_line(soil, WHEEL, target, 15.0, 5).sinkage)
            worst = max(worst, abs(h / low - 1))
    assert worst < 0.01


def test_a_rut_shears_less_and_counts_by_its_share(turn_slip):
    value, _ = turn_slip
    fresh, half, full = [float(value(point(v_y=-0.2, entry_path=0.02, overlap=share))[1]) for share in (0.0, 0.5, 1.0)]
    assert full > half > fresh
    assert half == pytest.approx(0.5 * (fresh + full), rel=1e-9)
    assert float(value(point(v_y=-0.2, entry_path=0.0, overlap=1.0))[1]) == pytest.approx(fresh, rel=1e-12)


def test_contact_step_is_half_a_step_of_path():
    with_step, without = (function(TurnSlip(contact_step=dt))[0] for dt in (0.002, 0.0))
    x = point(omega=30.0)  # straight on, so that no soil comes in from the side, and spinning at nearly one speed all along
    slowest = 5.0 - 30.0 * WHEEL.radius
    extra = float(with_step(x)[5]) - float(without(x)[5])
    assert extra == pytest.approx(0.001 * abs(slowest), rel=0.1)


def test_any_wheel_and_scale():
    """A wheel of 58 mm at 10 mm/s, with the speed floor below that, sees the same slip angles as a large one."""
    small = function(TurnSlip(contact_step=0.0, speed_floor=1e-4), wheel=Wheel(0.058, 0.05))[0]
    x = point(v_x=0.009, v_y=-0.004, omega=0.17, load=22.0, n=1.3, k_phi=1.5e6, k_c=1e3, c=100.0, phi=0.5)
    out = np.array(small(x)).ravel()
    assert np.all(np.isfinite(out))
    assert 0 < out[1] < 22.0 and 0 < out[4] < 0.058


def test_tangent_without_a_library_call():
    phi = ca.SX.sym("phi")
    f = ca.Function("tan", [phi], [tan_phi(phi)])
    angles = np.linspace(0, 1.2, 50)
    assert np.allclose(np.array(f(angles[None])).ravel(), np.tan(angles), rtol=1e-4)
    assert float(f(0.5061)) == pytest.approx(np.tan(0.5061), rel=1e-9)


def test_unknown_law_is_named():
    with pytest.raises(ValueError, match=r"turn_slip.*found .pacejka"):
        force_law("pacejka")
    with pytest.raises(ValueError, match=r"contact_step.*found 'grip'"):
        force_law("turn_slip", grip=1.0)
    assert force_law("turn_slip", contact_step=0.0) == TurnSlip(contact_step=0.0)


def test_outside_the_domain_is_said():
    check_contact(Contact(5.0, 0.1, 15.0, 3000.0))
    for bad in ({"v_x": -1.0}, {"omega": -2.0}, {"load": -5.0}, {"overlap": 1.5}, {"v_y": float("nan")}):
        with pytest.raises(ValueError, match=next(iter(bad))):
            check_contact(Contact(**{"v_x": 5.0, "v_y": 0.1, "omega": 15.0, "load": 3000.0, **bad}))
    check_sinkage(0.05, WHEEL)
    with pytest.raises(ValueError, match="does not carry"):
        check_sinkage(0.3, WHEEL)


def test_extrapolation_stays_bounded(turn_slip):
    """Ten times the load, the speed and the yaw rate of Table 4: the sinkage stays short of the axle, forces physical."""
    x = box(200, seed=5)
    x[[0, 1, 2, 3, 4, 6]] *= 10
    f_x, f_y, _, _, h, _ = np.array(turn_slip[0](x))
    assert np.all(h < 0.95 * WHEEL.radius)
    assert np.all(np.hypot(f_x, f_y) < x[3] + 2e4)


def swept_path(values):
    """(2,) path int |u| dX/v_x over the contact line of turn_slip on clay, and its exit_path (m)."""
    force, _ = function(TurnSlip(contact_step=0.0))
    out = dict(zip(OUT, np.asarray(force(values)).ravel(), strict=True))
    motion = dict(zip(MOTION, values[: len(MOTION)], strict=True))
    line = contact_line(CLAY, WHEEL, motion["load"], motion["omega"], 5)
    x = np.linspace(-float(line.x_rear), float(line.x_front), 2001)
    u_x, u_y = motion["v_x"] - motion["omega"] * np.sqrt(WHEEL.radius**2 - x * x), motion["v_y"] + motion["yaw_rate"] * x
    speed = np.hypot(np.hypot(u_x, u_y), 0.01 * motion["v_x"])
    return np.trapezoid(speed, x) / motion["v_x"], out["exit_path"]


def test_exit_path_is_the_path_where_no_soil_comes_in_from_the_side():
    path, left = swept_path(point(omega=30.0))
    assert left == pytest.approx(path, rel=0.01)


def test_soil_from_the_side_leaves_less_sheared():
    path, left = swept_path(point(v_y=3.0))
    assert 0.2 * path < left < 0.7 * path
