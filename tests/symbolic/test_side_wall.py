"""The side wall's earth pressure and the sinkage of a sliding wheel: known limits, mirror symmetry, no effect at nothing."""

import casadi as ca
import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.cases.ploughing import Digging, Ploughing
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.side_wall import Wall, passive_pressure, side_wall
from softsoil.symbolic.soil import CLAY, Soil
from softsoil.symbolic.wheel import Contact, Wheel

SAND = Soil("sand", k_phi=3.4e6, k_c=0.0, n=1.28, c=0.0, phi=np.deg2rad(29), k=0.01, R=0.0)
SMALL = Wheel(0.058, 0.05)
LAW = TurnSlip(contact_step=0.0, speed_floor=2e-4)
STILL = 2e-4


def contact(angle=45.0, rim=0.01, speed=0.01, load=22.0):
    return Contact(speed * np.cos(np.deg2rad(angle)), -speed * np.sin(np.deg2rad(angle)), rim / 0.058, load)


def wall_force(angle=45.0, rim=0.01, sinkage=0.03, soil=SAND, **wall):
    given = Wall(**{"unit_weight": 13e3, "standstill": STILL, **wall})
    return float(ca.DM(side_wall(given, soil, SMALL.radius, contact(angle, rim), sinkage)))


def ploughing(angle, rim, weight=13e3, **digging):
    law = Ploughing(LAW, Wall(weight, standstill=STILL), Digging(**digging, standstill=STILL))
    force = law(SAND, SMALL, contact(angle, rim))
    return float(ca.DM(force.f_y)), float(ca.DM(force.sinkage))


def test_smooth_wall_is_rankine_and_friction_adds():
    phi = np.deg2rad(30)
    assert float(passive_pressure(phi, 0.0)) == pytest.approx(3.0, rel=1e-6)
    # A lower bound of plasticity stays below Coulomb's plane, whose horizontal parts at 30 deg are 4.81 (phi/2) and 8.74 (phi).
    half, full = float(passive_pressure(phi, phi / 2)), float(passive_pressure(phi, phi * (1 - 1e-6)))
    assert 3.0 < half < 4.81 and half < full < 8.74


def test_wall_pushes_against_the_motion_and_is_mirrored():
    assert wall_force(30) > 0
    assert wall_force(-30) == pytest.approx(-wall_force(30), rel=1e-9)
    assert wall_force(0) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("more", "less"), [
    ({"angle": 60}, {"angle": 20}), ({"sinkage": 0.04}, {"sinkage": 0.02}), ({"unit_weight": 16e3}, {"unit_weight": 12e3}),
    ({"heap": 0.8}, {"heap": 0.2}), ({"rim": 0.0}, {"rim": 0.1}), ({"soil": SAND.with_(phi=0.6)}, {"soil": SAND}),
    ({"soil": SAND.with_(c=500.0)}, {"soil": SAND}),
])  # fmt: skip
def test_wall_force_grows_with_what_it_should(more, less):
    assert wall_force(**more) > 1.05 * wall_force(**less)


def test_nothing_declared_changes_nothing():
    plain = LAW(SAND, SMALL, contact())
    force, sinkage = ploughing(45, 0.01, weight=0.0)
    assert force == pytest.approx(float(ca.DM(plain.f_y)), rel=1e-12)
    assert sinkage == pytest.approx(float(ca.DM(plain.sinkage)), rel=1e-12)


def test_a_rolling_wheel_does_not_dig_and_a_locked_one_does():
    rolling = ploughing(0, 0.01)[1]
    assert ploughing(0, 0.01, shear=0.75, push=2.0)[1] == pytest.approx(rolling, rel=2e-2)
    locked = [ploughing(angle, 0.0, shear=0.75, push=2.0)[1] / ploughing(angle, 0.0)[1] for angle in (0, 45, 90)]
    assert locked == pytest.approx([1.375 * 3] * 3, rel=0.02)


@pytest.mark.parametrize("scale", [1.0, 10.0])
def test_slow_wheels_plough_like_faster_ones(scale):
    """Quasi-static: neither rate nor floor may show at the speed of a laboratory wheel."""
    slow = LAW(SAND, SMALL, contact())
    fast = LAW(SAND, SMALL, contact(rim=0.01 * scale, speed=0.01 * scale))
    assert float(ca.DM(slow.f_y)) == pytest.approx(float(ca.DM(fast.f_y)), rel=2e-3)


def test_vehicle_carries_the_same_wall():
    """The catalogue's effect adds the wall's force of both wheels of an axle, neutral at zero."""
    vehicle = reference_vehicle().with_(effects={})
    plain = bicycle(vehicle, CLAY)
    x = [0.0, 0.0, 0.0, 5.0, 0.4, 0.2]
    u, p = plain.u.nominal, plain.p.nominal
    rate = np.array(plain.ode()(x, u, p)).ravel()
    for density in (0.0, 16e3):
        model = bicycle(vehicle, CLAY, effects={"bulldozing": {"soil_density": density}})
        more = np.array(model.ode()(x, u, model.p.nominal)).ravel() - rate
        if density == 0.0:
            assert more == pytest.approx(np.zeros(6), abs=1e-12)
        else:
            assert more[4] < -1e-3  # against v > 0
    assert catalogue(vehicle)["bulldozing"].parameters.names == ("soil_density",)
