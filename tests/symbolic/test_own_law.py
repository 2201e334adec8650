"""A force law given as an object: the vehicle's simulated soil, options of its own, and laws that are no dataclass."""

from dataclasses import replace

import numpy as np
import pytest

import softsoil
from drives import PROJECT
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.bicycle import vehicle_law
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.wheel import force_law

VEHICLE, SOIL = softsoil.load_vehicle("reference"), softsoil.load_soil("clay")


def rates(law):
    model = softsoil.bicycle(VEHICLE, SOIL, law)
    x, u = model.x.pack(u=4.0, v=0.2, omega_z=0.3), model.u.pack(steer=0.1)
    return np.array(model.ode()(x, u, model.p.nominal)).ravel()


def test_a_law_itself_is_that_of_its_name():
    assert VEHICLE.simulator
    np.testing.assert_array_equal(rates(TurnSlip()), rates("turn_slip"))
    assert vehicle_law(VEHICLE, TurnSlip()) == vehicle_law(VEHICLE, "turn_slip") != TurnSlip()


def test_an_option_of_its_own_stays():
    own = replace(TurnSlip(), contact_step=0.007)
    assert VEHICLE.simulator["contact_step"] != 0.007
    assert vehicle_law(VEHICLE, own).contact_step == 0.007


class Plain:
    """A law that is no dataclass."""

    name = "plain"

    def __call__(self, soil, wheel, contact):
        return force_law("bekker")(soil, wheel, contact)


def test_a_law_need_not_be_a_dataclass():
    np.testing.assert_allclose(rates(Plain()), rates("bekker"), rtol=1e-12)


def test_a_declaration_takes_names_only():
    with pytest.raises(ValueError, match=r"law: expected one of bekker, .* by its name"):
        Declaration(VEHICLE, SOIL, TurnSlip())


@pytest.mark.parametrize(("vehicle", "soil", "words"), [("paper", SOIL, "vehicle"), (VEHICLE, "clay", "soil")])
def test_names_in_place_of_vehicle_and_soil_are_named(vehicle, soil, words):
    with pytest.raises(TypeError, match=f"{words}: expected a .*softsoil.load_{words}"):
        softsoil.bicycle(vehicle, soil)


def test_the_law_of_the_documentation_turns_the_vehicle():
    text = (PROJECT / "docs" / "concepts" / "force-law.md").read_text(encoding="utf-8")
    code = text.split("## Your own law")[1].split("```python\n")[1].split("```")[0]
    names: dict = {}
    exec(code, names)
    model = names["model"]
    x, u = model.x.pack(u=4.0), model.u.pack(steer=0.1)
    turning = float(model.ode()(x, u, model.p.nominal)[model.x.index("omega_z")])
    assert model.name == "bicycle_stiff" and 0.1 < turning < 50.0
    assert np.isfinite(np.array(model.ode()(np.zeros(len(x)), np.zeros(len(u)), model.p.nominal))).all()
