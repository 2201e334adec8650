"""A steering gain that no linkage makes is a wrong ratio in the import's map, and said so."""

from dataclasses import replace

from drives import reference_vehicle
from softsoil.identification.result import Found
from softsoil.identification.steering_ratio import steering_ratio

GAIN = Found(0.89, 0.017, "", "identified", 5.0, None, (1.0, 0.02))


def test_the_ratio_that_would_be_right_is_said():
    (note,) = steering_ratio({"steering_gain": GAIN}, reference_vehicle())
    assert "0.890 ± 0.017 times as far as the logs say" in note and "ratio in the map of the import is 1.124 times" in note


def test_a_linkage_or_a_gain_that_is_not_known_is_none():
    for other in (replace(GAIN, value=0.97), replace(GAIN, std=0.05), replace(GAIN, state="not_identifiable")):
        assert steering_ratio({"steering_gain": other}, reference_vehicle()) == ()
    assert steering_ratio({"toe": GAIN}, reference_vehicle()) == ()
