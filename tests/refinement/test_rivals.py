"""What a log shows of absent channels: effects that it can name, and rivals that it cannot, which no other name replaces."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.derive import completed
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.refinement.observations import lacking
from softsoil.refinement.refine import refine
from softsoil.refinement.remarks import would_separate
from softsoil.refinement.words import verdict_sentence
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.soil import CLAY

BANK = 0.06
CANDIDATES = ("bank", "accelerometer_bias", "grade")


@pytest.fixture(scope="module")
def banked() -> Recording:
    """A noisy multi-sine drive of the bicycle on ground that slopes aside."""
    vehicle = reference_vehicle()
    model = bicycle(vehicle, CLAY.with_(n=0.6), "turn_slip", {"bank": {"bank": BANK}})
    steer = MultiSine(0.35, seed=4)(0.012 * np.arange(2168))
    return add_noise(synthetic_drive(model, vehicle.radius, seconds=26.0, speed=5.5, steer=steer), "good", 1)


def without(drive: Recording, *names: str) -> Recording:
    channels = {name: values for name, values in drive.channels.items() if name not in names}
    return completed(replace(drive, channels=channels), reference_vehicle())


def test_positions_show_the_lateral_velocity_but_not_to_what_moves_the_positions(banked):
    known = catalogue(reference_vehicle())
    assert lacking(known["bank"], [without(banked, "v")]) == ()
    assert lacking(known["bank"], [banked, without(banked, "v", "x")]) == ("v",)
    assert lacking(known["bank"], [without(banked, "psi")]) == ("psi",)
    assert lacking(known["lever_arm"], [without(banked, "v")]) == ("v",)


@pytest.fixture(scope="module")
def declared() -> Declaration:
    return Declaration(reference_vehicle().with_(effects={}), CLAY)


@pytest.mark.study
@pytest.mark.filterwarnings("ignore:.*bias")
def test_a_bank_is_named_without_v(banked, declared):
    found = refine([without(banked, "v")], declared, workers=1, candidates=CANDIDATES)
    assert [effect.name for effect in found.effects] == ["bank"]
    assert found.effects[0].parameters["bank"][0] == pytest.approx(BANK, rel=0.05)


@pytest.mark.study
@pytest.mark.filterwarnings("ignore:.*bias")
def test_a_bank_without_a_heading_is_not_named_and_nothing_else_in_its_place(banked, declared):
    found = refine([without(banked, "x", "y", "psi")], declared, workers=1, candidates=CANDIDATES)
    assert found.verdict == "unexplained" and found.effects == () and found.declaration.vehicle.effects == {}
    assert found.selection.unnamable == ("bank",) and found.would_separate == "bank: a log with psi"
    assert "bank" in verdict_sentence(found)
    assert any(note.startswith("bank: explains") and "rests on psi" in note for note in found.notes)


def test_each_effect_of_a_group_says_what_tells_it_from_its_like():
    known = catalogue(reference_vehicle())
    one = SimpleNamespace(tried=known, accepted=(), ranking=(), unnamable=(), rivals={})
    said = would_separate([("payload", "steering_gain")], "effect", one)
    assert f"{known['payload'].separates} (payload), or {known['steering_gain'].separates} (steering_gain)" in said
    alike = would_separate([("bank", "grade")], "effect", one)
    assert alike == f"bank, grade: {known['bank'].separates}"
