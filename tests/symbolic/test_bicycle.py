"""The soft-soil bicycle: symmetry, limits, balances and conventions."""

from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.symbolic.bicycle import Corner, nominal_bicycle
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SAND, SANDY_LOAM
from softsoil.symbolic.wheel import law_names

U_MIRROR = np.array([-1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
X_MIRROR = np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])


@lru_cache(maxsize=8)
def ode(model):
    return model.ode()


def rates(model, x, u):
    return np.asarray(ode(model)(x, u, model.p.nominal))[:, 0]


def inputs(u=6.0, steer=0.0, steer_rate=0.0, a_x=0.0, slip=0.05):
    spin = u / (reference_vehicle().radius * (1 - slip))
    return np.array([steer, steer_rate, a_x, spin, spin, spin, spin])


@pytest.fixture(params=law_names(), scope="module")
def model(request):
    return nominal_bicycle(reference_vehicle(), CLAY, request.param)


def test_left_and_right_mirror_each_other(model):
    rng = np.random.default_rng(4)
    for _ in range(20):
        x = np.array([0, 0, 0, 6, 0, 0]) + rng.normal(size=6) * [5, 5, 1, 1, 0.5, 0.4]
        u = inputs(x[3], *rng.normal(size=3) * [0.2, 0.3, 0.5], rng.uniform(-0.2, 0.3))
        assert np.allclose(
            rates(model, x * X_MIRROR, u * U_MIRROR), rates(model, x, u) * X_MIRROR, rtol=1e-9, atol=1e-9
        )


@pytest.mark.parametrize("speed", [0.0, 0.05, 6.0])
def test_defined_and_differentiable_at_zero_slip_speed_and_steering(model, speed):
    x, u = np.array([0, 0, 0, speed, 0, 0.0]), inputs(speed, slip=0.0)
    ode = model.ode()
    sx, su, sp = model.symbols()
    f = ode(sx, su, sp)
    jacobian = ca.Function("j", [sx, su, sp], [ca.jacobian(f, ca.vertcat(sx, su, sp))])
    assert np.isfinite(rates(model, x, u)).all()
    assert np.isfinite(np.asarray(jacobian(x, u, model.p.nominal))).all()


def test_straight_ahead_stays_straight(model):
    assert np.allclose(rates(model, [0, 0, 0, 6, 0, 0], inputs()), [6, 0, 0, 0, 0, 0], atol=1e-9)


def test_steering_left_pushes_left_and_turns_left(model):
    found = rates(model, [0, 0, 0, 6, 0, 0], inputs(steer=0.1))
    assert found[4] > 0.1 and found[5] > 0.05


def test_sideways_motion_is_braked(model):
    assert rates(model, [0, 0, 0, 6, 0.5, 0], inputs())[4] < 0 < rates(model, [0, 0, 0, 6, -0.5, 0], inputs())[4]


def test_position_is_that_of_the_front_axle(model):
    vehicle = reference_vehicle()
    x = np.array([3.0, -2.0, 0.7, 5.0, 0.4, 0.3])
    cos, sin = np.cos(0.7), np.sin(0.7)
    side = 0.4 + vehicle.l_f * 0.3
    expected = [5 * cos - side * sin, 5 * sin + side * cos, 0.3, 0.8]
    assert np.allclose(rates(model, x, inputs(5.0, 0.1, a_x=0.8))[:4], expected, rtol=1e-12)


def test_forces_and_moments_balance(model):
    """M (dv/dt + u omega_z) = F_f + F_r and I domega/dt = l_f F_f - l_r F_r (paper, eq. (bicycle))."""
    vehicle = reference_vehicle()
    x, u = np.array([0, 0, 0.2, 6.0, 0.3, 0.4]), inputs(6.0, 0.2, 0.1, 0.5)
    found = rates(model, x, u)
    front, rear = np.asarray(model.probe("force_f", "force_r")(x, u, model.p.nominal))[:, 0]
    assert vehicle.mass * (found[4] + 6.0 * 0.4) == pytest.approx(front + rear, rel=1e-12)
    assert vehicle.yaw_inertia * found[5] == pytest.approx(vehicle.l_f * front - vehicle.l_r * rear, rel=1e-12)


def test_a_pull_turns_a_vehicle_that_drives_straight():
    vehicle = reference_vehicle().with_(effects={"yaw_moment": {"yaw_moment": 30.0}})
    found = rates(bicycle(vehicle, CLAY), np.array([0, 0, 0, 6.0, 0, 0]), inputs())
    assert found[5] == pytest.approx(30.0 / vehicle.yaw_inertia)
    assert found[4] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("a_x", [-3.0, 0.0, 2.0])
def test_axle_loads_carry_the_weight_and_its_transfer(model, a_x):
    vehicle = reference_vehicle()
    front, rear = np.asarray(model.probe("load_f", "load_r")([0, 0, 0, 6, 0, 0], inputs(a_x=a_x), model.p.nominal))[
        :, 0
    ]
    assert front + rear == pytest.approx(vehicle.mass * 9.81)
    transfer = vehicle.mass * a_x * vehicle.h_cg / vehicle.wheelbase
    static = vehicle.mass * 9.81 * (vehicle.l_r - vehicle.load_offset) / vehicle.wheelbase
    assert front == pytest.approx(static - transfer)


@pytest.mark.parametrize("soil", [CLAY, SANDY_LOAM, SAND], ids=lambda s: s.name)
def test_larger_n_is_softer_soil_with_less_side_force(soil):
    """Sinkage below 1 m: k h^n falls with n, the wheel sinks deeper and the lateral force changes with it."""
    model = nominal_bicycle(reference_vehicle(), soil)
    x, u = np.array([0, 0, 0, 6.0, 0, 0]), inputs(6.0, 0.15)
    sideways = [float(model.ode()(x, u, model.p.pack(n_f=n, n_r=n))[4]) for n in (0.5, 0.7, 0.9)]
    assert len(set(np.sign(np.diff(sideways)))) == 1 and abs(sideways[2] / sideways[0] - 1) > 0.05


@pytest.mark.parametrize("apart", [0.0, 0.08, -0.3])
def test_a_wheel_heads_where_it_is_turned(apart):
    cos, sin = (float(value) for value in Corner("f", 1, 1, 0.0, 1.0, 0.4, 15.0, apart=apart).heading)
    assert (cos, sin) == pytest.approx((np.cos(0.4 + apart), np.sin(0.4 + apart)), abs=3e-6)


def test_unknown_law_and_stage_are_named():
    with pytest.raises(ValueError, match=r"expected one of bekker, dallas.*found 'magic'"):
        nominal_bicycle(reference_vehicle(), CLAY, "magic")
    with pytest.raises(ValueError, match="expected a stage of inputs"):
        nominal_bicycle(reference_vehicle(), CLAY).correct("tyres", lambda q: {})
    with pytest.raises(KeyError, match="expected its stages to compute 'nothing'"):
        nominal_bicycle(reference_vehicle(), CLAY).probe("nothing")


def test_quantities_of_other_symbols_are_those_of_the_models_own_and_a_caller_may_change_what_it_gets():
    model = nominal_bicycle(reference_vehicle(), CLAY)
    own = model.quantities(*model.symbols())
    own.clear()
    others = [ca.SX.sym(name, len(layout)) for name, layout in zip("xup", (model.x, model.u, model.p), strict=True)]
    point = np.array([0, 0, 0, 6, 0.2, 0.3]), inputs(steer=0.2), model.p.nominal
    values = [
        np.asarray(ca.Function("forces", list(symbols), [q["force_f"], q["d_omega_z"]])(*point))
        for symbols in (model.symbols(), others)
        for q in [model.quantities(*symbols)]
    ]
    assert np.array_equal(values[0], values[1])
    assert np.all(values[0] != 0)


def test_a_steered_wheel_knows_that_its_slip_grows(model):
    """dv_y of the front contact is what steering alone changes of its lateral velocity; the rear wheels are not steered."""

    def contacts(q):
        return {f"{value}_{w.axle}": getattr(w.contact, value) for w in q["wheels"] for value in ("v_y", "dv_y")}

    probe = model.correct("contacts", contacts).probe("v_y_f", "dv_y_f", "dv_y_r")
    x, step = [0, 0, 0, 5.0, 0.3, 0.4], 1e-4
    turned = (inputs(steer=0.2 + k * step, steer_rate=0.7) for k in (-1, 0, 1))
    before, at, after = (np.asarray(probe(x, u, model.p.nominal))[:, 0] for u in turned)
    assert at[1] == pytest.approx(0.7 * (after[0] - before[0]) / (2 * step), rel=1e-6) and at[1] < -3.0
    assert at[2] == 0.0
