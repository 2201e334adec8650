"""What is said of a refinement that names nothing."""

from types import SimpleNamespace

import pytest

from softsoil.refinement.selection import Selection
from softsoil.refinement.words import verdict_sentence


@pytest.mark.parametrize(("left", "said"), ((False, "nothing is missing"), (True, "more is left in the axle forces")))
def test_none_is_not_said_without_what_is_left(left, said):
    """An identified vehicle's file is not strained by a small load, which a rear axle left by 49 % still shows."""
    found = SimpleNamespace(verdict="none", judged=(), structure=(SimpleNamespace(left=False), SimpleNamespace(left=left)))
    assert said in verdict_sentence(found)


@pytest.mark.parametrize("accepted", [(), ("payload",), ("bank",)])
def test_effects_of_which_each_could_be_named_are_no_declared_model_that_stands(accepted):
    groups = (*((name,) for name in accepted if name == "bank"), ("payload", "rate_damping", "wheel_speed_scale"))
    selection = Selection(tuple(SimpleNamespace(name=name) for name in accepted), None, (), groups)  # type: ignore[arg-type]
    named = "payload" in accepted
    assert selection.undecided == (() if named else groups[-1])
    found = SimpleNamespace(verdict="unexplained", judged=(), structure=(), selection=selection, strain=0.8)
    said = verdict_sentence(found)
    assert ("Unexplained: payload, rate damping or wheel speed scale explains what is left" in said) is not named
