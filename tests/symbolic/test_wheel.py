"""Properties of every force law: finite, smooth, mirror-symmetric; and of turn_slip: passive, bounded, carries its load."""

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import brentq

from softsoil.calibration.domain import check_contact, check_sinkage
from softsoil.symbolic.contact_line import bulk_modulus, contact_line, tan_phi
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.rut_line import contact_lines
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, SOILS, Soil
from softsoil.symbolic.wheel import Contact, Wheel, force_law, law_names

WHEEL = Wheel(0.330229, 0.2121)
MOTION = ("v_x", "v_y", "omega", "load", "yaw_rate", "steer_rate", "dv_y", "entry_path", "overlap", "rut_depth", "sweep")
SOIL = ("k_phi", "k_c", "n", "c", "phi", "k")
LATERAL = [1, 4, 5, 6, 10]
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
                entry_path=rng.uniform(0, 0.05), overlap=rng.uniform(0, 1), rut_depth=rng.uniform(0, 0.06),
                n=rng.uniform(0.4, 1.3), sweep=rng.uniform(-1, 1),
            )
        )  # fmt: skip
    return np.array(points).T


@pytest.fixture(scope="module", params=law_names())
def law(request):
    return function(force_law(request.param))


@pytest.fixture(scope="module")
def turn_slip():
    """On the simulated soil of the reference vehicle."""
    return function(TurnSlip(contact_step=0.002, patch_length=1.6))


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


def test_a_leaning_wheel_sweeps_its_contact_and_scrubs_nothing(turn_slip):
    """At no slip a sweep moves the ends of the contact sideways as a yaw rate does; what a yaw rate scrubs over the width, and
    so takes from a slipping wheel's side force, a sweep does not."""
    value, _ = turn_slip
    rolling = {"omega": 5.0 / WHEEL.radius}

    def of(**motion):
        return dict(zip(OUT, np.array(value(point(**rolling, **motion)))[:, 0], strict=True))

    swept, yawed = of(sweep=0.6), of(yaw_rate=0.6)
    assert swept["m_z"] < -1.0
    assert np.sign(swept["m_z"]) == np.sign(yawed["m_z"])
    slow = {"v_y": -0.05}
    upright, leaning, left = of(**slow), of(**slow, sweep=0.5), of(**slow, sweep=-0.5)
    both = 0.5 * (leaning["f_y"] + left["f_y"])
    scrubbed = 0.5 * (of(**slow, yaw_rate=0.5)["f_y"] + of(**slow, yaw_rate=-0.5)["f_y"])
    assert scrubbed < 0.97 * both
    assert both == pytest.approx(upright["f_y"], rel=0.1)


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
        stiffness = soil.k_phi + soil.k_c / b

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
    assert half == pytest.approx(0.5 * (fresh + full), rel=0.01)
    assert float(value(point(v_y=-0.2, entry_path=0.0, overlap=1.0))[1]) == pytest.approx(fresh, rel=0.01)


def test_contact_step_is_half_a_step_of_path_and_a_rim_met_late():
    """The soil meets the rim where it was a step before, and counts half a step more, at every node."""
    with_step = function(TurnSlip(contact_step=0.002))[0]
    x = point(omega=30.0)  # straight on, so that no soil comes in from the side
    line = contact_line(CLAY, WHEEL, 3000.0, 30.0, 5)
    front, rear = float(line.x_front), float(line.x_rear)
    at = np.linspace(-rear, front, 4001)
    met = np.minimum(at + 0.002 * 5.0, front)
    speed = np.abs(5.0 - 30.0 * np.sqrt(WHEEL.radius**2 - met**2))
    expected = np.trapezoid(speed, at) / 5.0 + 0.001 * speed.mean()
    assert float(with_step(x)[5]) == pytest.approx(expected, rel=0.01)
    assert expected - np.trapezoid(np.abs(5.0 - 30.0 * np.sqrt(WHEEL.radius**2 - at**2)), at) / 5.0 > 0.003


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
    for bad in ({"v_x": -1.0}, {"omega": -2.0}, {"load": -5.0}, {"rut_depth": -0.1}, {"overlap": 1.5}, {"v_y": float("nan")}):
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


def test_a_wheel_that_drifts_leaves_a_wide_rut_beside_it():
    """While soil passes under it the wheel moves by v_y per v_x: so wide are the rut's edges, on both sides of where it stood."""
    contact = Contact(v_x=5.0, v_y=1.0, omega=15.5, load=3000.0)
    force = TurnSlip(contact_step=0.0)(CLAY, WHEEL, contact)
    line = contact_line(CLAY, WHEEL, 3000.0, 15.5, 5)
    front, rear = float(line.x_front), float(line.x_rear)
    assert float(force.exit_drift) == pytest.approx(0.2 * (front + rear), rel=0.01)
    assert float(force.exit_shift) == pytest.approx(-0.1 * (front - rear), rel=0.01)


RUT = 0.03


def in_rut(share=1.0, load=3500.0, n=0.62, depth=RUT):
    contact = Contact(v_x=5.0, v_y=-0.1, omega=15.5, load=load, entry_path=0.01, overlap=share, rut_depth=depth)
    return contact_lines(CLAY.with_(n=n), WHEEL, contact, 5)


@pytest.mark.parametrize("share", [0.05, 0.5, 0.95, 1.0])
@pytest.mark.parametrize("load", [300.0, 3500.0, 6000.0])
def test_both_strips_stand_at_one_sinkage_and_carry_the_load(share, load):
    beside, inside = in_rut(share, load)
    assert inside is not None
    assert float(beside.sinkage) == pytest.approx(float(inside.sinkage), rel=1e-12)
    carried = WHEEL.width * (beside.share * beside.load + inside.share * inside.load)
    assert float(carried) == pytest.approx(load, rel=1e-3)


def test_a_wheel_in_a_rut_stands_deeper_on_a_shorter_contact():
    """Deeper the more of it is in the rut; in a rut of no depth it stands as in fresh soil."""
    fresh = contact_line(CLAY.with_(n=0.62), WHEEL, 3500.0, 15.5, 5)
    depths = [float(in_rut(share)[0].sinkage) for share in (0.01, 0.3, 0.7, 1.0)]
    assert depths[0] == pytest.approx(float(fresh.sinkage), rel=0.015)
    assert all(a < b for a, b in pairwise(depths))
    inside = in_rut(1.0)[1]
    assert inside is not None
    assert float(inside.x_front) < 0.8 * float(fresh.x_front)
    flat = in_rut(1.0, depth=0.0)[1]
    assert flat is not None
    assert float(flat.sinkage) == pytest.approx(float(fresh.sinkage), rel=0.02)


@pytest.mark.parametrize("share", [0.2, 0.6, 1.0])
@pytest.mark.parametrize("depth", [0.005, 0.02, 0.05])
@pytest.mark.parametrize("load", [1500.0, 3500.0, 6000.0])
def test_the_sinkage_in_a_rut_is_that_of_the_equations(share, depth, load):
    """Against the pressures integrated finely and the sinkage found by bisection."""
    soil, r, b = CLAY.with_(n=0.62), WHEEL.radius, WHEEL.width
    stiffness = float(bulk_modulus(soil, WHEEL))
    floor = depth - stiffness * depth**soil.n / soil.K

    def carried(h, floor):
        e = max(h - floor, 1e-9)
        x = np.linspace(0.0, np.sqrt(e * (2 * r - e)), 4001)
        sunk = np.sqrt(r * r - x * x) - (r - h)
        sigma = np.minimum(stiffness * np.maximum(sunk, 0.0) ** soil.n, soil.K * np.maximum(sunk - floor, 0.0))
        peak = sigma[0]
        tail = np.sqrt(2 * r * peak / soil.K)
        return b * (np.trapezoid(sigma + soil.R * 15.5 * x, x) + tail * (2 / 3 * peak - 0.5 * soil.R * 15.5 * tail))

    h = brentq(lambda h: share * carried(h, floor) + (1 - share) * carried(h, 0.0) - load, 1e-4, 0.25)
    assert float(in_rut(share, load, depth=depth)[0].sinkage) == pytest.approx(h, rel=0.06)
