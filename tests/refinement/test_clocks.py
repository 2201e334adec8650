"""A clock that is off by some 0.01 s is no reason to say that nothing is missing."""

import softsoil
from drives import reference_vehicle
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.late_clocks import CLOCKS, shifted
from softsoil.recording.noise import add_noise
from softsoil.refinement.refine import refine
from softsoil.refinement.words import verdict_sentence
from softsoil.symbolic.soil import CLAY


def test_drives_that_are_inconsistent_are_unexplained_and_the_clock_is_named():
    log = add_noise(softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 26.0), "good", 2)
    late = shifted(log, CLOCKS["steer and the wheels"], -4)
    found = refine([late], Declaration(reference_vehicle(), CLAY), workers=1, candidates=("bank", "side_force"))
    assert not found.effects and found.judged[0].word == "inconsistent"
    assert found.verdict == "unexplained" and "the verdicts on n say" in verdict_sentence(found)
    (clock,) = [note for note in found.notes if "steer and the wheels recorded 0.0" in note]
    assert clock.startswith(f"{late.name}: ") and clock.endswith("identified")
    assert "s late would explain it: with late = 0.0" in clock
