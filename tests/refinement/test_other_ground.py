"""A drive on ground of the other kind, sheared anew in ruts or not, is said to be that, and nothing else is named for it."""

from dataclasses import replace

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.refinement.doubts import grounds, other_ground
from softsoil.refinement.handed_on import _traced
from softsoil.refinement.refine import refine
from softsoil.refinement.trace import make_bench, try_effect
from softsoil.refinement.words import verdict_sentence
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.soil import CLAY

N = 0.6
TRIED = ("payload", "bank", "steering_offset")


def on(sheared):
    """A vehicle's file for ground that keeps this share of what a rut has been sheared."""
    return reference_vehicle().with_(effects={"multipass": {"kappa": 0.95, "sheared": sheared}}, uncertainty={}, joint_error=None)


def drive(sheared):
    """A noisy multi-sine drive of the bicycle on such ground."""
    vehicle = on(sheared)
    model = bicycle(vehicle, CLAY.with_(n=N), "turn_slip", vehicle.effects)
    t = 0.012 * np.arange(round(26.0 / 0.012) + 1)
    steer = MultiSine(0.35, seed=4)(t)
    return add_noise(synthetic_drive(model, vehicle.radius, seconds=26.0, speed=5.5, steer=steer), "good", 1)


def test_the_other_kind_is_tried_where_the_file_says_one():
    assert other_ground(reference_vehicle().with_(effects={}, joint_error=None)) == {}
    for declared, other in ((1.0, 0.0), (0.0, 1.0)):
        (effect,) = other_ground(on(declared)).values()
        assert effect.typical == {"sheared": other} and effect.parameters["sheared"].nominal == declared
        assert grounds(on(declared))["sheared"].signal.nominal == declared
    unsaid = reference_vehicle().with_(effects={"multipass": {"kappa": 0.95}}, joint_error=None)
    assert other_ground(unsaid)["sheared"].parameters["sheared"].nominal == 1.0


@pytest.mark.study
@pytest.mark.slow
@pytest.mark.parametrize("declared", [1.0, 0.0])
def test_it_is_said(declared):
    found = refine([drive(1.0 - declared)], Declaration(on(declared), CLAY), workers=1, candidates=TRIED)
    assert found.verdict == "contradicts_given" and not found.effects
    (number,) = found.contradicted
    assert number.name == "sheared" and number.declared == declared and abs(number.value - declared) > 0.8
    refined = found.declaration.vehicle
    assert refined.effects["multipass"]["sheared"] == pytest.approx(number.value)
    assert found.n_after[0] == pytest.approx(N, rel=0.05)
    assert "the data support no effect, but ground of the other kind than declared (sheared)" in verdict_sentence(found)


@pytest.mark.study
@pytest.mark.slow
def test_the_declared_kind_is_not_doubted():
    found = refine([drive(1.0)], Declaration(on(1.0), CLAY), workers=1, candidates=TRIED)
    assert found.verdict == "none" and not found.contradicted


def test_which_ground_it_is_is_no_number_of_ruts_that_are_traced():
    """Tried on a vehicle without them, ruts keep the kind of ground that is expected: nobody has asked which it is."""
    vehicle = on(1.0).with_(effects={})
    bench = make_bench([drive(1.0).between(0.0, 14.0)], Declaration(vehicle, CLAY), 2.0, names=("multipass",))
    ruts = catalogue(vehicle)["multipass"]
    found = try_effect(bench, ruts, [dict(ruts.typical)])
    assert "kappa" in found.fit.named() and "sheared" not in found.fit.named() and "sheared" not in found.fit.at_bound
    assert found.fit.p[0, bench.model.p.index("sheared")] == 1.0
    assert set(_traced(ruts, replace(bench, absent=found.fit.p), found.fit).parameters) == {"kappa"}
