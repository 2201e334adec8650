"""What is said of a refinement that names nothing."""

from types import SimpleNamespace

import pytest

from softsoil.refinement.words import verdict_sentence


@pytest.mark.parametrize(("left", "said"), ((False, "nothing is missing"), (True, "more is left in the axle forces")))
def test_none_is_not_said_without_what_is_left(left, said):
    """An identified vehicle's file is not strained by a small load, which a rear axle left by 49 % still shows."""
    found = SimpleNamespace(verdict="none", judged=(), structure=(SimpleNamespace(left=False), SimpleNamespace(left=left)))
    assert said in verdict_sentence(found)
