"""A clock that is off by some 0.01 s is no reason to say that nothing is missing."""

import numpy as np
import pytest

import softsoil
from drives import reference_vehicle
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.late_clocks import CLOCKS, LateClock, shifted
from softsoil.estimator.verdict import Verdict
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.refinement.drive_n import DriveN, FittedDrives
from softsoil.refinement.refine import refine
from softsoil.refinement.words import verdict_sentence
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY


@pytest.mark.study
def test_drives_that_are_inconsistent_are_unexplained_and_the_clock_is_named():
    log = add_noise(softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 26.0), "good", 2)
    late = shifted(log, CLOCKS["steer and the wheels"], -4)
    found = refine([late], Declaration(reference_vehicle(), CLAY), workers=1, candidates=("bank", "side_force"))
    assert not found.effects and found.judged[0].word == "inconsistent"
    assert found.verdict == "unexplained" and "the verdicts on n say" in verdict_sentence(found)
    (clock,) = [note for note in found.notes if "steer and the wheels recorded 0.0" in note]
    assert clock.startswith(f"{late.name}: ") and clock.endswith("identified")
    assert "s late would explain it: with late = 0.0" in clock


@pytest.mark.study
@pytest.mark.parametrize("explains", [True, False])
def test_a_clock_that_explains_what_an_effect_does_not_takes_its_name_back(explains, monkeypatch):
    """An offset of the steering that leaves n inconsistent, as the verdicts are made to say, with a clock and without one."""
    vehicle, t = reference_vehicle(), 0.012 * np.arange(1668)
    model = bicycle(vehicle, CLAY, "turn_slip", {"steering_offset": {"steering_offset": 0.03}})
    made = synthetic_drive(model, vehicle.radius, seconds=20.0, speed=5.5, steer=MultiSine(0.35, seed=4)(t))
    drive, clock = add_noise(made, "good", 1), LateClock("steer", 0.03, 0.5, 0.02)
    doubted = (DriveN(0.5, 0.02, Verdict("inconsistent", "the model leaves too much")),)
    monkeypatch.setattr(FittedDrives, "judged", lambda self: doubted)
    monkeypatch.setattr(FittedDrives, "late_clocks", lambda self: ((clock,),) if explains else ((),))
    declaration = Declaration(vehicle.with_(effects={}), CLAY)
    found = refine([drive], declaration, workers=1, candidates=("steering_offset",))
    if not explains:
        assert [effect.name for effect in found.effects] == ["steering_offset"] and found.verdict == "effect"
        return
    assert found.verdict == "unexplained" and not found.effects and not found.declaration.vehicle.effects
    assert f"{drive.name}: {clock.sentence}" in found.notes
    assert "not named, since a clock explains the drives and this does not: steering_offset" in found.notes
