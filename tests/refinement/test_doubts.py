"""Numbers of the vehicle that a drive may doubt: how well each is known, and a wrong one that is not called an effect."""

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG, reference_vehicle
from softsoil.commands.cli import app
from softsoil.commands.refine_summary import say
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.refinement.doubts import departure, doubts, known_of, loosened
from softsoil.refinement.fit import Free
from softsoil.refinement.refine import refine
from softsoil.refinement.trace import make_bench
from softsoil.refinement.vehicle_numbers import FIXED, by_name
from softsoil.refinement.words import n_sentences, number_words, soil_sentences, verdict_sentence
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.soil import CLAY, SANDY_LOAM

N = 0.6


def plain_vehicle(**numbers):
    """The reference vehicle without declared effects and uncertainty."""
    return reference_vehicle().with_(**{"effects": {}, "uncertainty": {}, **numbers})


def drive(effects, soil=CLAY, n=N, seconds=26.0):
    """A noisy multi-sine drive of the bicycle with the given effects."""
    vehicle = plain_vehicle()
    model = bicycle(vehicle, soil.with_(n=n), "turn_slip", effects)
    t = 0.012 * np.arange(round(seconds / 0.012) + 1)
    steer = MultiSine(0.35, seed=4)(t)
    return add_noise(synthetic_drive(model, vehicle.radius, seconds=seconds, speed=5.5, steer=steer), "good", 1)


def test_a_number_is_known_as_it_is_stated_measured_or_expected():
    vehicle = plain_vehicle(toe=0.0, uncertainty={"yaw_inertia": 12.0})
    table, known = doubts(vehicle), known_of(vehicle)
    assert table["yaw_inertia"].std == 12.0
    assert table["track"].std == pytest.approx(by_name()["track"].measured(known, vehicle.track))
    assert table["toe"].std == pytest.approx(by_name()["toe"].prior(known)[1]), "a number at its default was not measured"
    assert "mass" not in table and "h_cg" not in table, "no log shows them"
    assert all(doubt.wide >= doubt.std > 0 for doubt in table.values())


def test_parameters_of_declared_effects_are_doubted_unless_drawn_fixed_or_tried_again():
    vehicle = reference_vehicle()
    names = set(doubts(vehicle))
    for key, values in vehicle.effects.items():
        effect = catalogue(vehicle)[key]
        for name, value in values.items():
            kept = name in (*effect.drawn, *FIXED.get(key, {})) or effect.repeats or value == effect.parameters[name].nominal
            assert (name not in names) == kept


def test_the_drives_alone_depart_by_what_the_prior_is_taken_out_of():
    """Two observations of one number, 1.0 +- 0.1 declared and 2.0 +- 0.1 by the drives: the fit is 1.5 +- 0.0707."""
    free = Free("m", ("m",), 0.1, 0.0, 9.0, known=(1.0, 0.1))
    assert departure(free, 1.5, 0.1 / np.sqrt(2)) == pytest.approx(1.0 / np.hypot(0.1, 0.1))
    assert departure(free, 1.0, 0.1) == 0.0, "the drives say nothing"


@pytest.fixture(scope="module")
def clean():
    return drive({})


def test_numbers_are_free_where_they_matter_and_not_where_the_drive_contradicts_them(clean):
    right = make_bench([clean], Declaration(plain_vehicle(), CLAY), 2.0, names=("payload",))
    bench, wrong = loosened(right, plain_vehicle())
    assert {free.name for free in bench.loose} == set(wrong) and "yaw_inertia" in wrong
    assert "track" not in wrong, "a single track does not depend on it"
    heavy = plain_vehicle(yaw_inertia=1.4 * plain_vehicle().yaw_inertia)
    bench, wrong = loosened(make_bench([clean], Declaration(heavy, CLAY), 2.0, names=("payload",)), heavy)
    assert "yaw_inertia" in wrong and "yaw_inertia" not in {free.name for free in bench.loose}
    assert bench.absent[0, bench.model.p.index("yaw_inertia")] == heavy.yaw_inertia


@pytest.fixture(scope="module")
def doubted(clean):
    wrong = Declaration(plain_vehicle(yaw_inertia=1.4 * plain_vehicle().yaw_inertia), CLAY)
    return refine([clean], wrong, workers=1, candidates=("payload", "bank", "yaw_moment"))


@pytest.mark.slow
def test_a_wrong_inertia_is_said_and_not_called_a_payload(doubted, capsys):
    assert doubted.verdict == "contradicts_given" and not doubted.effects
    (number,) = doubted.contradicted
    assert number.name == "yaw_inertia" and number.value == pytest.approx(plain_vehicle().yaw_inertia, rel=0.05)
    assert doubted.declaration.vehicle.yaw_inertia == pytest.approx(number.value)
    assert doubted.declaration.vehicle.uncertainty["yaw_inertia"] == pytest.approx(number.std)
    assert doubted.n_after[0] == pytest.approx(N, rel=0.05)
    assert doubted.judged[0].usable
    assert "yaw_inertia" in verdict_sentence(doubted) and number_words(number) in _said(doubted, capsys)
    content = doubted.as_json()
    assert content["contradicted"]["yaw_inertia"]["declared"] == pytest.approx(1.4 * plain_vehicle().yaw_inertia)
    assert content["n"]["verdict"] == ["identified"]
    assert n_sentences(doubted)[0].startswith(f"{doubted.recordings[0].name} on clay: n identified: ")


def _said(found, capsys):
    say(found)
    return capsys.readouterr().out


@pytest.mark.study
@pytest.mark.slow
def test_an_inertia_declared_too_small_is_no_payload_either(clean):
    wrong = Declaration(plain_vehicle(yaw_inertia=0.65 * plain_vehicle().yaw_inertia), CLAY)
    found = refine([clean], wrong, workers=1, candidates=("payload", "bank"))
    assert [number.name for number in found.contradicted] == ["yaw_inertia"] and not found.effects


@pytest.mark.study
@pytest.mark.slow
def test_a_payload_that_is_there_is_no_wrong_inertia():
    loaded = drive({"payload": {"payload_mass": 350.0, "payload_x": 2.4}})
    found = refine([loaded], Declaration(plain_vehicle(), CLAY), workers=1, candidates=("payload", "bank", "yaw_moment"))
    assert [effect.name for effect in found.effects] == ["payload"] and not found.contradicted
    assert found.effects[0].parameters["payload_mass"][0] == pytest.approx(350.0, rel=0.2)


@pytest.mark.study
@pytest.mark.slow
def test_drives_on_two_soils_share_an_effect_and_keep_their_own_soil_and_n():
    offset = {"steering_offset": {"steering_offset": 0.03}}
    logs = [drive(offset), replace(drive(offset, SANDY_LOAM, 0.7), name="other")]
    found = refine(
        logs, Declaration(plain_vehicle(), CLAY), soils=[CLAY, SANDY_LOAM], workers=1, candidates=("steering_offset", "bank")
    )
    assert [effect.name for effect in found.effects] == ["steering_offset"]
    assert found.n_after == pytest.approx((N, 0.7), rel=0.05)
    assert found.as_json()["n"]["soil"] == ["clay", "sandy_loam"] and all(verdict.usable for verdict in found.judged)
    assert found.declaration.soil.name == "clay" and soil_sentences(found)
    k_c = found.bench.model.p.index("k_c")
    assert tuple(found.bench.absent[:, k_c]) == (CLAY.k_c, SANDY_LOAM.k_c)
    with pytest.raises(ValueError, match=r"soils: expected one per drive \(1\), found 2"):
        refine(logs[:1], Declaration(plain_vehicle(), CLAY), soils=[CLAY, SANDY_LOAM])


def test_soils_are_one_for_all_or_one_per_log(tmp_path):
    result = CliRunner().invoke(
        app, ["refine", str(MULTI_LOG), "--soil", "clay", "--soil", "sand", "--soil", "clay", "--out", str(tmp_path / "o")]
    )
    assert result.exit_code == 2 and "expected one for all or one per log (1), found 3" in result.output
    assert not (tmp_path / "o").exists()


