"""A drive of another vehicle than the one that was identified: said where its file states errors of its numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from identified import LOAD, NUMBERS, STD, N, drive, vehicle
from softsoil.commands.estimate import _not_looked_at
from softsoil.estimator.estimate import estimate
from softsoil.estimator.modes import run_horizon
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.strain import vehicle_change
from softsoil.estimator.tuning import UNSTATED_ERROR, Tuning, common_error
from softsoil.estimator.verdict import _shows_a_load
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.files.joint_error import independent_error, joint_error_of
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.noise import add_noise
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.windows.own_numbers import stated_error

WIDE = joint_error_of(NUMBERS, np.diag([100.0, 0.004]) ** 2)


@pytest.fixture(scope="module")
def loaded():
    return drive(LOAD, "good")


@pytest.mark.parametrize("noise", ["good", "table5"])
def test_the_vehicle_itself_is_not_strained(noise):
    found = estimate(drive({}, noise), bicycle(vehicle(), CLAY), method="horizon")
    change = found.verdict.evidence.change
    assert found.verdict.word == "identified" and 0.0 < change.strain < 3.0
    assert abs(change.load) < 3.0 * change.load_std < 0.2
    assert found.n_front[-1] == pytest.approx(N, rel=0.05)


def test_a_load_strains_its_numbers(loaded):
    found = estimate(loaded, bicycle(vehicle(), CLAY), method="horizon")
    assert found.verdict.word == "inconsistent" and "strain" in found.verdict.reason and "heavier" in found.verdict.reason
    change = found.verdict.evidence.change
    assert change.strain > 3.5
    assert change.load == pytest.approx(LOAD["payload"]["payload_mass"] / vehicle().mass, abs=3.0 * change.load_std)


@pytest.mark.study
@pytest.mark.parametrize("effects", [{}, LOAD], ids=["empty", "loaded"])
def test_a_load_shows_without_wheel_speeds(effects):
    verdict = estimate(drive(effects, "good", wheels=False), bicycle(vehicle(), CLAY), method="horizon").verdict
    change, mass = verdict.evidence.change, effects.get("payload", {}).get("payload_mass", 0.0)
    assert verdict.word == ("inconsistent" if effects else "identified")
    assert ("heavier than declared" in verdict.reason) == bool(effects)
    assert change.load * vehicle().mass == pytest.approx(mass, abs=4.0 * change.load_std * vehicle().mass)


def test_noisy_sensors_show_a_load_where_the_numbers_hardly_move():
    found = estimate(drive(LOAD, "table5"), bicycle(vehicle(WIDE), CLAY), method="horizon")
    change = found.verdict.evidence.change
    assert found.verdict.word == "inconsistent" and "the drive is that of a vehicle" in found.verdict.reason
    assert change.strain < 3.5 and change.load > 2.5 * change.load_std


@pytest.mark.study
def test_what_was_identified_with_a_load_is_lighter_without():
    found = estimate(drive({}, "good"), bicycle(vehicle().with_(effects=LOAD), CLAY), method="horizon")
    change = found.verdict.evidence.change
    assert found.verdict.word == "inconsistent" and change.strain > 3.5 and change.load < -5.0 * change.load_std


def test_the_vehicle_is_not_forgotten_with_the_soil():
    """n is that of the last seconds, a load that of the whole drive: over twice the time it is known better."""
    rules = HorizonRules(forgetting=4.0, longest=8.0)

    def seen(seconds, effects):
        windows = drive_windows(drive(effects, "good", seconds), bicycle(vehicle(), CLAY), 1.0, rules)
        return vehicle_change(windows, run_horizon(windows, N, True, rules))

    short, long, heavier = seen(13.0, {}), seen(26.0, {}), seen(26.0, LOAD)
    assert long.seen_std < 0.8 * short.seen_std
    assert abs(long.load) < 3.0 * long.load_std
    assert heavier.load == pytest.approx(LOAD["payload"]["payload_mass"] / vehicle().mass, abs=3.0 * heavier.load_std)


@pytest.mark.study
def test_a_declared_load_is_as_uncertain_as_its_file_says(loaded):
    less = {"payload": {**LOAD["payload"], "payload_mass": 200.0}}
    exact, vague = (
        estimate(loaded, bicycle(vehicle().with_(effects=less, uncertainty=known), CLAY), method="horizon").verdict
        for known in ({}, {"payload_mass": 150.0})
    )
    assert "heavier" in exact.reason and "heavier" not in vague.reason
    assert vague.evidence.change.load == exact.evidence.change.load
    assert vague.evidence.change.load_std > 150.0 / vehicle().mass > exact.evidence.change.load_std


@pytest.mark.parametrize(("seen", "asked"), [(0.07, "drive about 1.4 times as long, or with"), (0.2, "drive with more")])
def test_a_drive_that_would_not_show_a_load_is_asked_for_what_would(seen, asked):
    evidence = SimpleNamespace(change=SimpleNamespace(seen_std=seen))
    word, reason = _shows_a_load(evidence, np.array([0.5]), (), VerdictRules())
    assert word == "not_excited" and asked in reason
    assert _shows_a_load(SimpleNamespace(change=SimpleNamespace(seen_std=0.05)), np.array([0.5]), (), VerdictRules()) is None


def test_a_drive_that_does_not_turn_says_nothing_of_a_load():
    model = bicycle(vehicle(), CLAY.with_(n=N))
    straight = synthetic_drive(model, vehicle().radius, seconds=12.0, speed=4.0, steer=np.zeros(1001))
    change = estimate(add_noise(straight, "good", 2), bicycle(vehicle(), CLAY), method="horizon").verdict.evidence.change
    assert change.load_std > 0.3 and abs(change.load) < change.load_std


def test_a_log_without_noise_weighs_no_more_than_one_of_good_sensors(monkeypatch):
    """What the equations miss is not white: as exact as its sensors, a log would strain numbers that are right."""
    heavier = vehicle().with_(yaw_inertia=vehicle().yaw_inertia + 2.0 * STD[0])
    windows = drive_windows(drive({}, "none"), bicycle(heavier, CLAY), 1.0, HorizonRules())
    horizon = run_horizon(windows, N, True, HorizonRules())
    weighed = vehicle_change(windows, horizon).strain
    assert 0.0 < weighed < 3.5
    monkeypatch.setattr("softsoil.estimator.strain.Tuning", lambda: Tuning(sensor_floor=(1e-4,) * 6))
    assert vehicle_change(windows, horizon).strain > 1.1 * weighed


def test_a_declared_load_does_not(loaded):
    found = estimate(loaded, bicycle(vehicle().with_(effects=LOAD), CLAY), method="horizon")
    change = found.verdict.evidence.change
    assert found.verdict.word == "identified" and change.strain < 3.0 and abs(change.load) < 3.0 * change.load_std


@pytest.mark.study
def test_numbers_stated_one_by_one_say_it_too(loaded):
    stated = vehicle(None).with_(uncertainty=dict(zip(NUMBERS, STD, strict=True)))
    found = estimate(loaded, bicycle(stated, CLAY), method="horizon")
    assert found.verdict.word == "inconsistent" and "heavier" in found.verdict.reason
    kept = estimate(drive({}, "good"), bicycle(stated, CLAY), method="horizon").verdict
    assert kept.word == "identified" and kept.evidence.change.strain < 3.0


def test_a_joint_error_stands_before_numbers_stated_one_by_one_and_no_load_is_among_them():
    stated = vehicle(None).with_(uncertainty={"track": 0.01, "payload_mass": 20.0})
    assert stated_error(stated) == independent_error({"track": 0.01}) and stated_error(None) is None
    assert stated_error(stated.with_(joint_error=WIDE)) is WIDE


def test_errors_of_effects_alone_say_nothing_of_the_vehicle():
    stated = vehicle(None).with_(effects={"multipass": {"kappa": 1.0}}, uncertainty={"kappa": 0.05})
    assert stated_error(stated) is None
    assert stated_error(stated.with_(joint_error=WIDE)) is WIDE
    both = stated.with_(uncertainty={"kappa": 0.05, "track": 0.01})
    assert stated_error(both) == independent_error({"kappa": 0.05, "track": 0.01})


@pytest.mark.parametrize(
    ("stated", "own"),
    [
        ({}, UNSTATED_ERROR),
        ({"yaw_inertia": 41.0}, UNSTATED_ERROR),
        ({"yaw_moment": 5.7, "kappa": 0.1}, UNSTATED_ERROR),
        ({"yaw_inertia": 600.0, "ackermann": 0.4, "toe": 0.01}, UNSTATED_ERROR),
        ({"yaw_inertia": 41.0, "ackermann": 0.07, "toe": 0.003}, 0.0),
    ],
    ids=lambda value: ", ".join(value) if isinstance(value, dict) else None,
)
def test_one_stated_error_makes_n_no_surer(stated, own):
    """An entry of [uncertainty], as of an effect that refine named, is no statement of how well the vehicle is known."""
    model = bicycle(vehicle(None).with_(uncertainty=stated), CLAY)
    assert common_error(0.02, model) == pytest.approx(np.hypot(0.02, own))


def test_that_n_keeps_that_error_is_said():
    """Where nothing was looked at, and where the one stated error was enough for a look."""
    cases = ((None, "not looked at: "), (object(), "does not state how well it is known (n_error, [joint_error], or "))
    for change, words in cases:
        found = SimpleNamespace(verdict=SimpleNamespace(evidence=SimpleNamespace(change=change)))
        (said,) = _not_looked_at(found, unstated=True)
        assert words in said and "5 % of n is in its standard deviation" in said
    assert _not_looked_at(found, unstated=False) == []


def test_without_stated_errors_nothing_is_said_of_it(loaded):
    bare = vehicle(None).with_(uncertainty={})
    found = estimate(loaded, bicycle(bare, CLAY), method="horizon")
    assert found.verdict.evidence.change is None and "strain" not in found.verdict.reason
