"""Ground that shears anew in ruts is taken where the other asks for numbers that no vehicle has, and leaves more."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from softsoil.identification.identify import _on_either_ground
from softsoil.identification.result import Found
from softsoil.identification.rules import RULES
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import declared_vehicle, vehicle_of

KNOWN = Known("one", {"mass": 1378.0, "l_f": 1.55, "l_r": 1.17, "track": 1.23, "radius": 0.33, "width": 0.21})
ODD = Found(0.0, 0.04, "", "identified", 0.1, None, (0.95, 0.1))


def taken(costs, odd, known=KNOWN):
    """Which ground is taken, the notes and how many fits there were: costs and odd numbers on either ground."""
    asked = []

    def attempt(known, told):
        anew = known.other_ground
        asked.append(anew)
        numbers = {name: ODD if name in odd[anew] else replace(ODD, value=0.9) for name in ("kappa", "toe_rear")}
        return SimpleNamespace(numbers=numbers, state=SimpleNamespace(cost=costs[anew]), anew=anew)

    found, notes = _on_either_ground(attempt, known, RULES, lambda share: None)
    return found.anew, notes, len(asked)


def test_it_is_taken_where_it_leaves_less_with_fewer_odd_numbers():
    anew, notes, _ = taken((1.2, 1.0), ({"kappa"}, set()))
    assert anew and "sheared = 0" in notes[0] and "1.2 times less" in notes[0] and "where kappa would be strange" in notes[0]


@pytest.mark.parametrize(
    ("costs", "odd", "fits"),
    [
        ((1.2, 1.0), (set(), set()), 1),
        ((1.0, 0.995), ({"kappa"}, set()), 2),
        ((1.2, 1.0), ({"kappa"}, {"toe_rear"}), 2),
    ],
    ids=["no odd number", "it leaves as much", "other odd numbers"],
)
def test_it_is_not_taken_without_need(costs, odd, fits):
    assert taken(costs, odd) == (False, (), fits)


def test_what_an_owner_says_of_the_ground_stands():
    said = replace(KNOWN, effects={"multipass": {"sheared": 1.0}})
    assert taken((1.2, 1.0), ({"kappa"}, set()), said) == (False, (), 1)


def test_the_vehicle_carries_its_ground():
    known = Known("one", KNOWN.numbers, effects={"multipass": {"kappa": 0.9}}, other_ground=True)
    ground = vehicle_of(known, {})
    assert declared_vehicle(known).effects == known.effects
    assert ground.effects["multipass"] == {"kappa": 0.9, "sheared": 0.0}
    assert vehicle_of(KNOWN, {}).effects["multipass"]["sheared"] == 1.0
