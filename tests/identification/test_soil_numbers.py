"""Numbers of a soil from drives: recovered on the model itself, refused without stated errors, doubted in a wrong class."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG, PROJECT
from softsoil.commands.cli import app
from softsoil.declaration.model_file import soil_toml
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.files.joint_error import JointError
from softsoil.identification.rules import RULES
from softsoil.identification.soil_numbers import _Bench, _verdict, identify_soil
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, load_soil
from softsoil.symbolic.vehicle import load_vehicle

VEHICLE = load_vehicle("reference")
STATED = (("phi", 0.03), ("k", 0.003), ("k_phi", 70000.0))
GROUND = CLAY.with_(phi=0.25, k=0.008, n=0.6)


def drive_on(soil, seed, seconds=24.0):
    t = 0.012 * np.arange(round(seconds / 0.012) + 1)
    made = synthetic_drive(bicycle(VEHICLE, soil), VEHICLE.radius, seconds=seconds, steer=MultiSine(0.35, seed=seed)(t))
    return add_noise(made, "good", seed)


@pytest.mark.study
def test_friction_and_shear_modulus_are_recovered_and_n_with_them():
    error = JointError(("yaw_inertia", "track"), (20.0, 0.01), ((), (0.3,)))
    vehicle = VEHICLE.with_(joint_error=error, n_error=0.02)
    found = identify_soil([drive_on(GROUND, 1), drive_on(GROUND.with_(n=0.5), 2)], CLAY.with_(uncertainty=STATED), vehicle)
    assert found.verdict == "identified" and len(found.n) == 2
    for name in ("phi", "k"):
        one = found.numbers[name]
        assert one.state == "identified" and one.std < 0.3 * one.given_std
        assert abs(one.value - getattr(GROUND, name)) < 3 * one.std, name
    for (value, std), true in zip(found.n.values(), (0.6, 0.5), strict=True):
        assert abs(value - true) < 3 * std < 0.4 * true
    wrong = [abs(value - true) for (value, _), true in zip(found.n_before.values(), (0.6, 0.5), strict=True)]
    assert max(wrong) > 0.08, "with the class as given n takes its errors up"
    assert found.ratio is not None and found.ratio > 1.2
    assert dict(found.soil.uncertainty) == {name: one.std for name, one in found.numbers.items()}
    assert not found.unexplained[0].beyond(dict(VerdictRules().unexplained))


@pytest.mark.study
@pytest.mark.slow
def test_a_soil_far_from_its_class_contradicts_it():
    near = CLAY.with_(uncertainty=(("phi", 0.002), ("k", 0.003)))
    found = identify_soil([drive_on(GROUND, 1)], near, VEHICLE)
    assert found.verdict == "contradicts_given" and "phi" in found.reason


@pytest.mark.study
def test_drives_of_one_steering_wave_say_nothing_of_the_soil():
    t = 0.012 * np.arange(1501)
    wave = bicycle(VEHICLE, GROUND)
    made = synthetic_drive(wave, VEHICLE.radius, seconds=18.0, steer=0.4 * np.sin(2 * np.pi * t / 3.0))
    found = identify_soil([add_noise(made, "good", 1)], CLAY.with_(uncertainty=STATED[:1]), VEHICLE)
    assert found.verdict == "needs_data" and "one steering wave" in found.reason


@pytest.mark.study
def test_an_n_at_a_bound_is_no_n():
    near = CLAY.with_(uncertainty=(("k", 1e-5),))
    found = identify_soil([drive_on(CLAY.with_(phi=0.45, n=0.25), 1, 18.0)], near, VEHICLE)
    assert found.verdict == "contradicts_given"


def test_a_number_far_from_its_class_departs_from_it_though_the_drives_hardly_reduce_its_error():
    """What several numbers share is known, and none of them: c moves by 3.4 of its standard deviations all the same."""
    stated = SimpleNamespace(soil=CLAY.with_(uncertainty=(("c", 800.0),)), rules=RULES)
    found = _Bench.numbers(stated, SimpleNamespace(named=lambda: {"c": (1383.0, 700.0)}))["c"]
    assert found.state == "not_identifiable" and found.std == 800.0
    assert found.departs == pytest.approx((4140.0 - 1383.0) / 800.0)
    had = SimpleNamespace(steers=True, many_waves=True)
    verdict, reason = _verdict({"c": found}, {"log": (0.5, 0.02)}, SimpleNamespace(at_bound=()), had)
    assert verdict == "contradicts_given" and "c is 1383, given as 4140" in reason


@pytest.mark.study
def test_what_a_file_says_of_its_numbers_together_is_known_of_them():
    """Errors of phi and k that are almost one: the drive then knows phi better by what it says of k."""
    stated = CLAY.with_(uncertainty=(("phi", 0.003), ("k", 0.003)))
    alike = JointError(("phi", "k"), (0.003, 0.003), ((), (0.95,)))
    log = drive_on(CLAY.with_(n=0.6), 1, 12.0)
    alone = identify_soil([log], stated, VEHICLE).numbers
    for soil in (stated, stated.with_(uncertainty=())):
        together = identify_soil([log], soil.with_(joint_error=alike), VEHICLE).numbers
        assert together.keys() == alone.keys() and together["phi"].std < 0.9 * alone["phi"].std
        assert abs(together["phi"].value - CLAY.phi) < 3 * together["phi"].std


def test_a_soil_without_stated_errors_is_refused():
    with pytest.raises(ValueError, match=r"soil clay: expected a table .uncertainty. .* found none"):
        identify_soil([drive_on(CLAY, 1, 6.0)], CLAY, VEHICLE)


@pytest.mark.study
@pytest.mark.slow
def test_the_command_writes_a_soil_that_every_command_takes(tmp_path):
    field = tmp_path / "field.toml"
    declared = CLAY.with_(name="field", phi=0.24, uncertainty=STATED[:2])
    field.write_text(soil_toml(declared, ("from a shear vane",)), encoding="utf-8")
    assert load_soil(field) == declared
    run = CliRunner().invoke(app, ["soil", str(MULTI_LOG), "--soil", str(field), "--noise", "good", "--out", str(tmp_path)])
    assert run.exit_code == 0, run.output
    assert "vehicle: reference" in run.output and "Identified: the drives give numbers of the soil" in run.output
    soil = load_soil(tmp_path / "soil.toml")
    assert soil.joint_error is not None and soil.joint_error.names == ("phi", "k")
    assert soil.joint_error.std == pytest.approx([std for _, std in soil.uncertainty], rel=1e-4)
    found = json.loads((tmp_path / "soil.json").read_text(encoding="utf-8"))
    assert soil.verdict == "identified"
    assert soil.phi == found["numbers"]["phi"]["value"] and abs(soil.phi - 0.2269) < 3 * dict(soil.uncertainty)["phi"]
    assert found["verdict"] == "identified" and set(found["before"]["mse"]) == set(found["after"]["mse"])
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "angle of internal friction" in report and report.count("<img ") == 2 and "13.8 ± 1.7 deg" in report
    other = tmp_path / "other.toml"
    text = (PROJECT / "vehicles" / "reference.toml").read_text(encoding="utf-8")
    smaller = re.sub(r"^radius = [0-9.]+", "radius = 0.28", text, count=1, flags=re.MULTILINE)
    other.write_text(smaller, encoding="utf-8")
    arguments = ["soil", str(MULTI_LOG), "--soil", str(field), "--vehicle", str(other), "--out", str(tmp_path / "none")]
    refused = CliRunner().invoke(app, arguments)
    assert refused.exit_code == 2 and "--vehicle names the vehicle that drove" in refused.output
    refused = CliRunner().invoke(app, ["soil", str(MULTI_LOG), "--soil", "clay", "--out", str(tmp_path / "none")])
    assert refused.exit_code == 2 and "expected a table [uncertainty]" in refused.output
