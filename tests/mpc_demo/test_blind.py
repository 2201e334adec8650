"""The blind test, small: drives of the plant, an effect among a few, traced without being told."""

import json

import pytest
from typer.testing import CliRunner

from benchmarks.guide.json_page import undescribed
from softsoil.commands import blind as commands_blind
from softsoil.commands.cli import app
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.blind_cases import BORDER, INSIDE, KINDS, OUTSIDE, draw_cases, drive_case
from softsoil.mpc_demo.blind_test import as_the_catalogue_says, effect_of, plant_on, run_blind, score, totals
from softsoil.mpc_demo.sweep import RESULTS
from softsoil.plant.effects import Effects
from softsoil.symbolic.catalogue import catalogue

FEW = ("steer_offset", "slope_aside", "gyro_drift")
SECONDS = 26.0


def test_cases_are_the_seed_s_and_say_what_the_catalogue_calls_it():
    cases = draw_cases(40, 0)
    assert cases == draw_cases(40, 0) != draw_cases(40, 1)
    assert json.loads(json.dumps(cases)) == cases
    kinds = [case["kind"] for case in cases]
    assert [kinds.count(kind) for kind in ("effect", "clean", "outside")] == [25, 10, 5]
    named = {case["name"] for case in cases if case["kind"] == "effect"}
    assert named == set(INSIDE)
    declared = plant_on("clay")
    known = catalogue(declared.vehicle)
    for case in cases:
        Effects.from_table({k: v for k, v in case["effects"].items() if k != BORDER})
        told = as_the_catalogue_says(case, declared)
        assert case["kind"] != "effect" or told["name"] in known
        assert told["truth"].keys() <= {*known.get(told["name"], known["bank"]).parameters.names, "side_force"}
    assert not set(OUTSIDE) & set(known)


def test_the_border_lies_in_a_short_drive_s_fitted_part_as_in_a_long_one_s():
    long, short = ([case for case in draw_cases(40, 0, seconds) if case["name"] == BORDER] for seconds in (45.0, 15.0))
    assert long and [3.0 * case["effects"][BORDER][1] for case in short] == pytest.approx([c["effects"][BORDER][1] for c in long])


def test_every_switch_of_the_world_has_one_effect_that_answers():
    known = catalogue(plant_on("clay").vehicle)
    answered = [switch for effect in known.values() for switch in effect.answers_to]
    assert sorted(answered) == sorted(INSIDE)
    for effect in known.values():
        sizes = {*effect.parameters.names, effect.derived.name if effect.derived else ""}
        assert all(set(names) <= sizes for names in effect.answers_to.values())
    with pytest.raises(ValueError, match="found 'antigravity'"):
        effect_of("antigravity", plant_on("clay"))


@pytest.fixture(scope="module")
def traced(tmp_path_factory):
    """One drive with an effect and one without, traced among a few candidates."""
    folder = tmp_path_factory.mktemp("blind")
    drawn = draw_cases(len(KINDS), 3, SECONDS, FEW)
    cases = [drawn[KINDS.index(kind)] for kind in ("effect", "clean")]
    results, failures = run_blind(cases, folder, 1, lambda i, result: None)
    assert not failures, failures
    return cases, results, folder


@pytest.mark.slow
@pytest.mark.study
def test_effect_of_the_plant_is_found_and_nothing_is_invented(traced):
    cases, results, _ = traced
    assert [result["right"] for result in results] == [True, True], results
    assert results[0]["effects"][0]["name"] == effect_of(cases[0]["name"], plant_on("clay"))[0]
    assert results[1]["verdict"] == "none"
    assert totals(cases, results)["all"] == {"drives": 2, "right": 2}


@pytest.mark.study
def test_a_second_run_takes_what_is_there(traced, monkeypatch):
    cases, results, folder = traced
    monkeypatch.setattr("softsoil.mpc_demo.blind_test.drive_case", pytest.fail)
    again, failures = run_blind(cases, folder, 1, lambda i, result: None)
    assert again == results and not failures
    assert len((folder / RESULTS).read_text(encoding="utf-8").splitlines()) == len(cases)


def test_tracing_gets_no_truth():
    recording = drive_case(draw_cases(1, 3, 15.0)[0])
    assert not recording.truth
    assert not any(name.startswith("true_") for name in recording.channels)


@pytest.mark.study
def test_wrong_names_and_sizes_do_not_score(traced):
    """The score can fail: the same finding against another truth."""
    from softsoil.refinement.result import Refinement, TracedEffect

    declared = plant_on("clay")
    case = as_the_catalogue_says(traced[0][0], declared)
    lead = catalogue(declared.vehicle)[case["name"]].parameters[0].name

    def finding(name, value):
        effect = TracedEffect(name, "", {lead: (value, 0.1, "")})
        blank = dict.fromkeys(Refinement.__dataclass_fields__)
        return Refinement(**{**blank, "verdict": "effect", "effects": (effect,), "inseparable": (), "ranking": (), "carried": (),
                             "declaration": Declaration(declared.vehicle, declared.soil)})  # fmt: skip

    true = case["truth"][lead]
    assert score(case, finding(case["name"], 1.2 * true))[0]
    assert not score(case, finding(case["name"], 1.4 * true))[0]
    assert not score(case, finding("payload", true))[0]
    assert not score({**case, "kind": "clean"}, finding(case["name"], true))[0]
    assert not score({**case, "kind": "outside"}, finding(case["name"], true))[0]


def test_command_shows_a_table_and_keeps_what_failed(tmp_path, monkeypatch):
    results = [{"right": True, "why": "none", "verdict": "none", "effects": [], "n_after": 0.6}, None]
    monkeypatch.setattr(commands_blind, "run_blind", lambda *args: (results, {1: "ValueError: cut off"}))
    outcome = CliRunner().invoke(app, ["blind-test", "--drives", "2", "--out", str(tmp_path)])
    assert outcome.exit_code == 0, outcome.output
    assert "drive 1 failed: ValueError: cut off" in outcome.output
    content = json.loads((tmp_path / "blind.json").read_text(encoding="utf-8"))
    assert content["totals"]["all"] == {"drives": 2, "right": 1}
    assert content["failures"] == {"1": "ValueError: cut off"} and undescribed("blind.json", content) == []


def test_command_says_what_is_wrong():
    outcome = CliRunner().invoke(app, ["blind-test", "--drives", "0"])
    assert outcome.exit_code == 2
