"""A law's expressions are made once per kind of wheel, and are those that the law makes itself."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

import casadi as ca
import numpy as np
import pytest

import softsoil
from softsoil.symbolic.law_graph import wheel_force
from softsoil.symbolic.laws.turn_slip import Factors, TurnSlip
from softsoil.symbolic.wheel import Contact, Wheel, WheelForce, force_law, law_names

CLAY = softsoil.load_soil("clay")
FREE = ("v_x", "v_y", "omega", "load", "yaw_rate")
MEMORY = ("dv_y", "entry_path", "overlap", "rut_depth", "sweep")
AT = dict(zip((*FREE, *MEMORY), (4.0, -0.3, 9.0, 3000.0, 0.2, 0.1, 0.01, 0.6, 0.02, 0.05), strict=True))
RESULTS = ("f_x", "f_y", "m_y", "m_z", "sinkage", "exit_path", "exit_drift", "exit_shift")


def values(call, law, names):
    """Results of a law called by `call`, with the named quantities of the contact and the soil's n as symbols."""
    symbols = {name: ca.SX.sym(name) for name in names}
    n, radius = ca.SX.sym("n"), ca.SX.sym("r")
    force = call(law, CLAY.with_(n=n), Wheel(radius, 0.3), Contact(**{name: AT[name] for name in FREE} | symbols))
    graph = ca.Function("f", [n, radius, *symbols.values()], [ca.vertcat(*[getattr(force, name) for name in RESULTS])])
    return np.array(graph(0.5, 0.4, *[AT[name] for name in names])).ravel()


def itself(law, soil, wheel, contact):
    return law(soil, wheel, contact)


@pytest.mark.parametrize("name", law_names())
@pytest.mark.parametrize("names", [FREE, (*FREE, *MEMORY), ("v_y",), ()])
def test_the_forces_are_the_laws(name, names):
    law = force_law(name)
    first = values(wheel_force, law, names)
    np.testing.assert_array_equal(first, values(itself, law, names))
    np.testing.assert_array_equal(first, values(wheel_force, law, names), "from what was made before")
    assert np.isfinite(first).all()


def test_options_and_the_names_of_soils_make_laws_of_their_own():
    one, other = (values(wheel_force, TurnSlip(front_nodes=nodes), FREE) for nodes in (3, 5))
    assert not np.array_equal(one, other)
    assert not np.array_equal(one, values(wheel_force, TurnSlip(front_nodes=3, factors=Factors(width=1.1)), FREE))


def test_a_law_with_a_symbol_in_it_keeps_its_symbol():
    step = ca.SX.sym("step")
    law = TurnSlip(contact_step=step)
    force = wheel_force(law, CLAY, Wheel(0.4, 0.3), Contact(**{name: ca.SX(AT[name]) for name in FREE}))
    assert ca.depends_on(force.f_y, step)


@dataclass(frozen=True)
class Counted:
    """A law of numbers that counts its calls."""

    scale: float = 1.0
    name: str = "counted"

    calls: ClassVar[list] = []

    def __call__(self, soil, wheel, contact):
        self.calls.append(self.scale)
        return WheelForce(0.0, -self.scale * contact.v_y, 0.0, 0.0, 0.01, 0.0)


@dataclass(frozen=True)
class Remembering(Counted):
    """The same with something in it that may change."""

    tables: list = field(default_factory=list)
    calls: ClassVar[list] = []


@pytest.mark.parametrize(("law", "calls"), [(Counted(), 1), (Counted(2.0), 1), (Remembering(), 3)])
def test_a_law_is_called_once_for_wheels_of_a_kind_unless_it_may_change(law, calls):
    type(law).calls.clear()
    forces = []
    for _ in range(3):
        v_y = ca.SX.sym("v_y")
        contact = Contact(v_x=1.0, v_y=v_y, omega=1.0, load=1.0)
        forces.append(wheel_force(law, CLAY, Wheel(0.4, 0.3), contact))
        assert ca.depends_on(forces[-1].f_y, v_y) and forces[-1].sinkage == 0.01
    assert len(type(law).calls) == calls


def test_models_of_one_law_make_its_expressions_once(monkeypatch):
    model = softsoil.bicycle(softsoil.load_vehicle("reference"), CLAY)
    model.quantities(*model.symbols())
    monkeypatch.setattr(TurnSlip, "__call__", lambda *_: pytest.fail("the law was called again"))
    another = softsoil.bicycle(softsoil.load_vehicle("reference"), replace(CLAY, n=0.6))
    assert np.isfinite(np.array(another.ode()(another.x.pack(u=4.0), another.u.pack(steer=0.1), another.p.nominal))).all()
