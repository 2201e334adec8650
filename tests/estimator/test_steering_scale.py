"""A steering angle of another scale: alone, and beside a wrong mass, which hides behind it."""

from dataclasses import replace

import pytest

import softsoil
from softsoil.commands.estimate import _windows
from softsoil.estimator.changed_vehicle import change_words
from softsoil.estimator.strain import VehicleChange
from softsoil.recording.noise import add_noise


@pytest.fixture(scope="module")
def log():
    return add_noise(softsoil.read_drive(softsoil.example_logs()[0]).between(0.0, 30.0), "good", 1)


def estimated(log, scale, **numbers):
    vehicle = softsoil.load_vehicle("reference")
    wrong = vehicle.with_(**{name: factor * getattr(vehicle, name) for name, factor in numbers.items()})
    model = softsoil.bicycle(wrong, softsoil.load_soil("clay"))
    return softsoil.estimate(log.with_channels(steer=scale * log["steer"]), model, 0.7)


@pytest.mark.study
def test_a_right_scale_is_right(log):
    found = estimated(log, 1.0)
    change = found.verdict.evidence.change
    assert found.verdict.usable and abs(change.steering) < 2.5 * change.steering_std < 0.05
    assert _windows(found)["steering"] == {"share": 1.0 + change.steering, "std": change.steering_std}


@pytest.mark.study
@pytest.mark.parametrize(("scale", "mass"), [(1.05, 1.08), (0.95, 0.92)])
def test_a_wrong_one_shows_where_a_wrong_mass_hides_it(log, scale, mass):
    """n is 11 to 16 % off there, and nothing else in the drive says so: neither what is left of its motion nor a load."""
    found = estimated(log, scale, mass=mass)
    change = found.verdict.evidence.change
    assert abs(found.n_front[-1] / 0.5 - 1.0) > 0.10 and abs(change.load) < 0.08
    assert change.steering == pytest.approx(1.0 / scale - 1.0, abs=3.0 * change.steering_std)
    assert found.verdict.word == "inconsistent" and "road wheels that turn" in found.verdict.reason
    assert ("less than steer says" if scale > 1 else "farther than steer says") in found.verdict.reason


def test_words_name_all_that_is_wrong():
    change = VehicleChange(5.0, 0.12, 0.02, 0.02, -0.06, 0.01)
    every = change_words(change, 3.5, True, True, True)
    assert "strain 5.0" in every and "12 ± 2 % heavier" in every and "turn 6 ± 1 % less than steer says" in every
    assert change_words(change, 3.5, False, False, False) == ""
    assert "heavier" not in change_words(change, 3.5, False, False, True)
    absurd = change_words(replace(change, load=-0.68), 3.5, False, True, False)
    assert "of no such vehicle with any load (one 68 % lighter would fit best)" in absurd
