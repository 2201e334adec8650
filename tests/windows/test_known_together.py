"""What is known of numbers together counts as what is known of each; bounds at infinity; numbers freed twice."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import softsoil
from softsoil.declaration.ground import idle
from softsoil.files.joint_error import JointError
from softsoil.refinement.doubts import doubts
from softsoil.symbolic.signals import Layout, Signal
from softsoil.windows.free_starts import joint_prior
from softsoil.windows.free_windows import Linear
from softsoil.windows.own_numbers import with_own_numbers
from softsoil.windows.parameters import Free
from softsoil.windows.window_fit import fit_windows

MODEL = SimpleNamespace(p=Layout.of(Signal("a", "", "seen"), Signal("b", "", "seen with it")))


class Sums:
    """60 windows of 20 noisy values of a + b."""

    compiled, first, rows = SimpleNamespace(model=MODEL), np.zeros((60, 1)), np.arange(60)
    drive = SimpleNamespace(t=np.arange(60.0))

    def __init__(self, seed):
        self.y = 0.3 + np.random.default_rng(seed).normal(size=(60, 20))

    def residual(self, p, x0):
        return p[0] + p[1] - self.y

    def follow(self, row, x0):
        pass

    def linearise(self, p, x0, free):
        return Linear(self.residual(p, x0), np.zeros((60, 20, 1)), np.ones((60, 20, len(free))))


@pytest.mark.parametrize("mean", [0.0, 0.2])
def test_a_joint_error_of_numbers_is_in_the_error_of_what_is_confused_with_them(mean):
    a, b = Free("a", ("a",), 1.0, -9.0, 9.0), Free("b", ("b",), 1.0, -9.0, 9.0)
    start = np.zeros(2), np.zeros((1, 2))
    each = fit_windows([Sums(1)], [a, replace(b, known=(mean, 0.5))], *start)
    joint = joint_prior(JointError(("b",), (0.5,), ((),)), MODEL, {"b": mean})
    together = fit_windows([Sums(1)], [a, b], *start, [joint])
    assert together.value == pytest.approx(each.value, abs=1e-6)
    assert together.std == pytest.approx(each.std, rel=1e-3) and each.std[0] > 0.49


def test_a_number_without_an_upper_bound_is_not_at_it():
    above = Free("k", ("k",), 10.0, 0.0, np.inf)
    assert not above.at_bound(300.0) and above.at_bound(0.0)


def test_numbers_that_are_parameters_already_stay_so():
    model = softsoil.bicycle(softsoil.load_vehicle("reference"), softsoil.load_soil("clay"))
    twice = with_own_numbers(with_own_numbers(model, ["track"]), ["scrub"])
    assert idle(twice, ["track", "scrub"]) == ()


def test_the_stated_error_of_a_number_at_its_default_is_believed():
    vehicle = softsoil.load_vehicle("paper").with_(toe=0.0, uncertainty={"toe": 0.001})
    assert doubts(vehicle)["toe"].std == 0.001
