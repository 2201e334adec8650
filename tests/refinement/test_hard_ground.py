"""softsoil refine on hard ground: friction and tread in the place of n, what was added named, nothing invented, no n anywhere."""

import json
import math
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.guide.json_page import undescribed
from drives import reference_vehicle
from softsoil.commands.cli import app
from softsoil.declaration.ground import HARD_GROUND, idle, load_ground, sinks
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
from softsoil.estimator.estimate import estimate
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.recording.read import write_drive
from softsoil.refinement.fit import Fit
from softsoil.refinement.ground import fitted_ground
from softsoil.refinement.refine import refine
from softsoil.refinement.unknown_ground import free_n, free_road, ground_starts
from softsoil.refinement.windowing import Windowing
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive
from softsoil.windows.stiffness import needed_substeps

CANDIDATES = ("steering_offset", "bank", "yaw_moment", "gyro_bias", "soil_change")
FRICTION, TREAD, OFFSET, SECONDS = 0.55, 0.003, 0.03, 26.0
N = re.compile(r"(?<![\w.])n(_[fr0-9])?\"?\s*[:=]")
"""n with a value: n = 0.5, "n": 0.5, n_0: 0.5."""
runner = CliRunner()


def drive(effects, friction=FRICTION, seed=4):
    """A noisy multi-sine drive on a road."""
    vehicle = reference_vehicle()
    model = bicycle(vehicle, HARD_GROUND.with_(phi=math.atan(friction), k=TREAD), "hard_ground", effects)
    t = 0.012 * np.arange(round(SECONDS / 0.012) + 1)
    steer = MultiSine(0.35, seed=seed)(t)
    return add_noise(synthetic_drive(model, vehicle.radius, seconds=SECONDS, speed=5.5, steer=steer), "good", 1)


def road(friction, name="road"):
    return HARD_GROUND.with_(name=name, phi=math.atan(friction), k=0.8 * TREAD)


@pytest.fixture(scope="module")
def declared():
    """A road with a fifth more friction than there is, and a tread that is a fifth stiffer."""
    return Declaration(reference_vehicle().with_(effects={}), road(1.2 * FRICTION), "hard_ground")


@pytest.fixture(scope="module")
def offset_drive():
    return drive({"steering_offset": {"steering_offset": OFFSET}})


@pytest.fixture(scope="module")
def found(offset_drive, declared):
    return refine([offset_drive], declared, workers=1, candidates=CANDIDATES)


def test_friction_and_the_effect_are_found(found):
    assert found.verdict == "effect" and [effect.name for effect in found.effects] == ["steering_offset"]
    value, std, unit = found.effects[0].parameters["steering_offset"]
    assert unit == "rad" and abs(value - OFFSET) < 3 * std < 0.1 * OFFSET
    (ground,) = found.ground
    friction, tread = ground.numbers
    assert ground.name == "road" and (friction.name, tread.name, tread.unit) == ("friction", "tread", "m")
    assert abs(friction.value - FRICTION) < 3 * friction.std < 0.1 * FRICTION
    assert abs(tread.value - TREAD) < 3 * tread.std < 0.2 * TREAD
    assert friction.word == tread.word == "identified"
    assert found.n_before == found.n_after == found.n_std == found.judged == ()
    assert math.tan(found.declaration.soil.phi) == pytest.approx(friction.value)
    assert found.declaration.soil.k == tread.value


def test_nothing_is_named_on_a_clean_drive(declared):
    clean = refine([drive({})], declared, workers=1, candidates=CANDIDATES)
    assert clean.verdict == "none" and not clean.effects
    friction = clean.ground[0].numbers[0]
    assert abs(friction.value - FRICTION) < 3 * friction.std


def test_what_does_nothing_on_hard_ground_is_not_tried_and_said(found):
    assert "soil_change" not in {candidate.name for candidate in found.ranking}
    assert "soil_change: not tried, it does nothing with hard_ground" in found.notes
    assert any(note.startswith("neither n nor a verdict on it") for note in found.notes)


def test_drives_of_one_class_share_friction_and_others_have_their_own(declared):
    drives = [drive({}, FRICTION, 4), drive({}, 0.4, 5), drive({}, FRICTION, 6)]
    dry, wet = road(0.6, "dry"), road(0.5, "wet")
    both = refine(drives, declared, soils=[dry, wet, dry], workers=1, candidates=("steering_offset",))
    assert [(ground.name, len(ground.drives)) for ground in both.ground] == [("dry", 2), ("wet", 1)]
    for ground, true in zip(both.ground, (FRICTION, 0.4), strict=True):
        assert abs(ground.numbers[0].value - true) < 3 * ground.numbers[0].std
    assert both.declaration.soil.name == "dry" and both.verdict == "none"


@pytest.mark.study
def test_the_command_says_friction_and_no_n(offset_drive, tmp_path):
    log = tmp_path / "drive.csv"
    write_drive(offset_drive, log)
    vehicle = tmp_path / "plain.toml"
    declared = Declaration(reference_vehicle().with_(effects={}), road(0.6), "hard_ground")
    vehicle.write_text(declaration_toml(declared), encoding="utf-8")
    assert not N.search(vehicle.read_text(encoding="utf-8"))
    result = runner.invoke(app, ["refine", str(log), "--model", str(vehicle), "--workers", "1", "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert "road: friction identified" in result.output and "steering_offset" in result.output
    assert "beside friction and tread" in " ".join(result.output.split())
    texts = [result.output, *((tmp_path / "out" / n).read_text(encoding="utf-8") for n in ("refine.json", "refined.toml"))]
    html = re.sub(r"data:image/png;base64,[^\"]*", "", (tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    for text in (*texts, html):
        assert not N.search(text) and "sinkage exponent" not in text
    assert "coefficient of friction" in html and "<code>n</code>" not in html
    content = json.loads(texts[1])
    assert undescribed("refine.json", content) == []
    assert "n" not in content and set(content["ground"][0]) == {"name", "drives", "friction", "tread"}
    assert set(content["ground"][0]["friction"]) == {"before", "value", "std", "unit", "verdict", "reason"}
    again = load_declaration(tmp_path / "out" / "refined.toml")
    assert again.soil.phi == pytest.approx(math.atan(content["ground"][0]["friction"]["value"]))
    assert again.law == "hard_ground" and "steering_offset" in again.vehicle.effects


def test_estimate_says_that_there_is_no_n(offset_drive, tmp_path):
    model = nominal_bicycle(reference_vehicle(), HARD_GROUND, "hard_ground")
    none = estimate(offset_drive, model)
    assert none.verdict.word == "no_soil" and not none.verdict.usable and np.isnan(none.n_front).all()
    log = tmp_path / "drive.csv"
    write_drive(offset_drive, log)
    result = runner.invoke(app, ["estimate", str(log), "--law", "hard_ground", "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert "no soil: nothing sinks" in result.output and not re.search(r"n front|rear \d|n [^.]*± ", result.output)
    content = json.loads((tmp_path / "out" / "estimate.json").read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert content["verdict"] == "no_soil" and content["n_front"] is None and content["n_front_std"] is None
    assert not (tmp_path / "out" / "estimate.png").exists()


@pytest.mark.parametrize("command", ["study", "map"])
def test_what_rests_on_n_refuses_hard_ground(command, offset_drive, tmp_path):
    log = tmp_path / "drive.csv"
    write_drive(offset_drive, log)
    result = runner.invoke(app, [command, str(log), "--soil", "clay", "--law", "hard_ground", "--out", str(tmp_path / "out")])
    assert result.exit_code == 2 and "expected a soil's, with which wheels sink" in result.output


def test_which_laws_sink():
    vehicle = reference_vehicle()
    assert all(sinks(nominal_bicycle(vehicle, CLAY, law)) for law in ("turn_slip", "bekker", "dallas"))
    hard = nominal_bicycle(vehicle, CLAY, "hard_ground")
    assert not sinks(hard) and idle(hard, ("n_f", "phi", "k", "c")) == ("n_f", "c")


def test_a_file_of_hard_ground_needs_friction_and_tread_alone(declared, tmp_path):
    path = tmp_path / "road.toml"
    path.write_text(declaration_toml(declared), encoding="utf-8")
    again = load_declaration(path)
    assert again.law == declared.law and (again.soil.phi, again.soil.k) == pytest.approx((declared.soil.phi, declared.soil.k))
    soft = path.read_text(encoding="utf-8").replace("hard_ground", "turn_slip")
    path.write_text(soft, encoding="utf-8")
    with pytest.raises(ValueError, match=r"expected keys 'k_phi' .*'n' "):
        load_declaration(path)


def test_a_class_of_hard_ground_is_a_file_of_two_numbers(tmp_path):
    path = tmp_path / "wet.toml"
    path.write_text("phi = 0.4\nk = 0.004\n", encoding="utf-8")
    wet = load_ground(str(path), hard=True)
    assert (wet.name, wet.phi, wet.k) == ("wet", 0.4, 0.004)
    with pytest.raises(ValueError, match="expected keys 'k_phi'"):
        load_ground(str(path), hard=False)
    path.write_text("phi = 0.4\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"wet\.toml: expected key 'k' "):
        load_ground(str(path), hard=True)
    assert load_ground("clay", hard=True) == CLAY


def test_states_are_smoothed_by_the_sample_rate_on_hard_ground():
    assert Windowing().smooth(0.01, sinks=False) == pytest.approx(0.07)
    assert Windowing().smooth(0.2, sinks=False) == 0.25 and Windowing().smooth(0.01, sinks=True) is None
    assert Windowing(smoothing=0.1).smooth(0.01, sinks=True) == 0.1


def test_unknowns_of_the_ground():
    assert [(f.name, f.drive) for f in free_n(2)] == [("n_0", 0), ("n_1", 1)]
    one = free_road([CLAY, CLAY])
    assert [(f.name, f.sets, f.drive) for f in one] == [("phi", ("phi",), None), ("k", ("k",), None)]
    other = CLAY.with_(name="other")
    assert [(f.name, f.drives) for f in free_road([CLAY, other, CLAY])] == [
        ("phi_0", (0, 2)), ("k_0", (0, 2)), ("phi_1", (1,)), ("k_1", (1,)),
    ]  # fmt: skip
    starts = ground_starts(one, np.array([0.5, 0.002]))
    assert list(starts[0]) == [0.5, 0.002] and len(starts) == 13
    assert starts[:, 0].min() < 0.4 and starts[:, 0].max() > 0.8 and starts[:, 1].max() / starts[:, 1].min() > 10


@pytest.mark.parametrize(
    ("phi", "std", "left", "word"),
    [
        (0.5, 0.005, False, "identified"),
        (0.5, 0.05, False, "not_excited"),
        (0.5, 0.005, True, "inconsistent"),
        (1.1, 0.005, False, "at_bound"),
    ],
)
def test_a_friction_is_judged(phi, std, left, word):
    free = free_road([HARD_GROUND])
    last = Fit(free, np.array([phi, 0.003]), np.array([std, 1e-5]), np.zeros((1, 2)), 1.0, ())
    (ground,) = fitted_ground(free, [HARD_GROUND], ["a"], np.array([0.6, 0.002]), last, [left], 0.03)
    friction = ground.numbers[0]
    assert friction.word == word and friction.value == pytest.approx(math.tan(phi))
    assert friction.before == pytest.approx(math.tan(0.6))
    assert friction.std == pytest.approx(np.hypot(std / math.cos(phi) ** 2, 0.03 * math.tan(phi)))


def test_a_stiffer_ground_needs_more_steps(offset_drive):
    """Of a linear tyre d(omega_z)/dt falls with c/u: four times the stiffness, four times the steps."""
    model = nominal_bicycle(reference_vehicle(), HARD_GROUND, "hard_ground")
    ready = [shooting_drive(offset_drive, model, 2.0)]
    steps = {k: needed_substeps(model, ready, model.p.pack(phi=0.5, k=k)[None]) for k in (0.01, 0.0008, 0.0002)}
    assert steps[0.01] == 1 and steps[0.0002] == pytest.approx(4 * steps[0.0008], abs=3)
    soil = nominal_bicycle(reference_vehicle(), CLAY)
    assert needed_substeps(soil, [shooting_drive(offset_drive, soil, 2.0)], soil.p.nominal[None]) == 1


def test_free_numbers_of_several_drives():
    assert Free("a", ("a",), 1.0, 0.0, 1.0).drives == (0,) and Free("a", ("a",), 1.0, 0.0, 1.0, drive=(1, 2)).drives == (1, 2)
