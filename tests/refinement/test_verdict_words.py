"""What is said of a refinement that names nothing."""

from types import SimpleNamespace

import pytest

from softsoil.refinement.remarks import one_by_one
from softsoil.refinement.selection import Selection, select
from softsoil.refinement.words import verdict_sentence


@pytest.mark.parametrize(("left", "said"), ((False, "nothing is missing"), (True, "more is left in the axle forces")))
def test_none_is_not_said_without_what_is_left(left, said):
    """An identified vehicle's file is not strained by a small load, which a rear axle left by 49 % still shows."""
    found = SimpleNamespace(verdict="none", judged=(), structure=(SimpleNamespace(left=False), SimpleNamespace(left=left)))
    assert said in verdict_sentence(found)


def test_drives_that_may_differ_are_to_be_traced_alone():
    assert one_by_one("unexplained", 2)[0].endswith("trace each alone")
    assert one_by_one("unexplained", 1) == one_by_one("effect", 2) == one_by_one("none", 3) == ()


ALIKE = ("payload", "rate_damping", "wheel_speed_scale")


def test_effects_that_explain_alike_are_named_together():
    found = SimpleNamespace(verdict="unexplained", judged=(), structure=(), strain=0.8,
                            selection=Selection((), None, (), (ALIKE,), undecided=ALIKE))  # type: ignore[arg-type]  # fmt: skip
    said = verdict_sentence(found)
    assert said.startswith("Unexplained: payload, rate damping or wheel speed scale explains what is left")


@pytest.mark.parametrize(("others", "undecided"), [(ALIKE[1:], ALIKE), (ALIKE[1:2], ())])
def test_more_than_two_that_explain_alike_are_undecided(others, undecided, monkeypatch):
    """Of two, the better one is named beside the other."""
    module = "softsoil.refinement.selection."
    ranked = [SimpleNamespace(name=name) for name in ALIKE]
    monkeypatch.setattr(module + "rank", lambda bench, tried, workers, progress: [one for one in ranked if one.name in tried])
    monkeypatch.setattr(module + "contended", lambda bench, ranking, workers, one_wave: (ranking, []))
    monkeypatch.setattr(module + "supported", lambda candidate, effect, least: candidate.name == ALIKE[0])
    monkeypatch.setattr(module + "placed_for_sure", lambda candidate, effect: False)
    monkeypatch.setattr(module + "like", lambda best, ranking, bench: others)
    monkeypatch.setattr(module + "accept", lambda bench, candidate, effects: (bench, ()))
    found = select(None, dict.fromkeys(ALIKE), {}, 1, lambda share: None)  # type: ignore[arg-type]
    assert found.undecided == undecided and found.groups[0] == (ALIKE[0], *others)
    assert [one.name for one in found.accepted] == ([] if undecided else [ALIKE[0]])
