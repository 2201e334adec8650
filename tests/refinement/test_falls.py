"""The sentence on the held-out error: of lateral channels, and of the speed where that is what an effect explains."""

from types import SimpleNamespace

import pytest

import softsoil
from softsoil.refinement.words import falls_sentence, times_smaller

LATERAL = {"v": 4.0, "omega_z": 4.0, "psi": 4.0, "y": 4.0}


def found(u_before, lateral_after=1.0):
    before = {**LATERAL, "u": u_before, "x": 1.0}
    after = {**dict.fromkeys(LATERAL, lateral_after), "u": 1.0, "x": 1.0}
    return SimpleNamespace(before={"2.5": before}, after={"2.5": after}, effects=("drag",), contradicted=())


def test_an_effect_on_the_speed_is_seen_to_explain_it():
    assert "1.1 times smaller" in falls_sentence(found(25.0, 4.0 / 1.21))
    assert falls_sentence(found(25.0, 4.0 / 1.21)).endswith("heading and y; of the speed 5 times).")


@pytest.mark.parametrize("u_before", [0.0, 1.0, 4.0])
def test_a_speed_that_gains_no_more_is_not_spoken_of(u_before):
    assert "2 times smaller" in falls_sentence(found(u_before)) and "speed" not in falls_sentence(found(u_before))


def test_a_name_that_no_vehicle_has_is_refused_with_those_there_are():
    with pytest.raises(ValueError, match=r"vehicle: expected one of reference, paper, plant, heavy, or a TOML file; found 'bla'"):
        softsoil.load_vehicle("bla")


def test_an_error_that_grew_is_not_called_smaller():
    assert [times_smaller(ratio) for ratio in (4.24, 1.0, 0.8)] == ["4.24 times smaller", "1 times smaller", "1.25 times larger"]
