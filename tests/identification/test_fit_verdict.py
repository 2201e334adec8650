"""Whether a fit's numbers are those of a vehicle at all, and what is advised where a given one is contradicted."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from softsoil.identification.fit_verdict import fit_verdict
from softsoil.identification.result import Contradiction, Found
from softsoil.identification.rules import RULES

KNOWN = Found(1.0, 0.05, "m", "given", 0.1, 1.0, (1.0, 0.05))
FITTED = Found(0.1, 0.1, "rad", "identified", 0.1, None, (0.0, 0.1))


def verdict(contradictions=(), **moved):
    """Of a fit whose numbers stand so many standard deviations from what is expected of any vehicle."""
    numbers = {name: replace(FITTED, value=0.1 * sigmas) for name, sigmas in moved.items()}
    numbers |= {"radius": KNOWN, "yaw_inertia": replace(FITTED, value=600.0, std=20.0, before=(600.0, 200.0))}
    errors = SimpleNamespace(correlation=lambda *names: 0.1)
    state = SimpleNamespace(contradictions=contradictions, n=(0.6,), n_std=(0.02,), errors=errors)
    had = SimpleNamespace(steers=True, many_waves=True)
    return fit_verdict(state, numbers, SimpleNamespace(names=["log"]), had, RULES)


def test_several_numbers_that_no_vehicle_has_are_another_law():
    word, reason = verdict(toe=7.7, toe_rear=-5.6, kappa=2.0)
    assert word == "contradicts_given"
    assert "numbers that no vehicle has" in reason and "toe 0.77 rad by 7.7, toe_rear -0.56 rad by 5.6." in reason


@pytest.mark.parametrize("moved", [{"toe": 9.0, "kappa": 4.9}, {"toe": 2.9, "toe_rear": 2.0, "kappa": 1.0}])
def test_one_odd_number_is_a_vehicles_own(moved):
    assert verdict(**moved)[0] == "identified"


@pytest.mark.parametrize(("value", "left"), [(0.97, True), (0.9, False)])
def test_what_no_tape_misses_is_not_left_to_the_logs(value, left):
    """A radius that rolls 3 % smaller may be ground that resists; 10 % is no law of the model's."""
    one = Contradiction(name="radius", given=1.0, value=value, std=0.001, sigmas=30.0, evidence="rolling")
    word, reason = verdict((one,))
    assert word == "contradicts_given"
    assert ("[uncertainty] radius = 0.03" in reason) is left
    assert ("n is not to be had from these logs" in reason) is not left
